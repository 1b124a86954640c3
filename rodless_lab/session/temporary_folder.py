# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the parameters of nodes stand while these run."""

import tempfile

from rodless_base.atomic_write import cannot_be_written
from rodless_lab.session.errors import HarnessError


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """Make a folder that goes at the end of its block.

    Raises HarnessError where none can be made, as in a container that can only be read.
    """
    try:
        return tempfile.TemporaryDirectory(prefix="rodless_sim-", ignore_cleanup_errors=True)
    except OSError as error:
        folder = cannot_be_written("folder for the nodes' parameters", error)
        raise HarnessError(f"{folder}; set TMPDIR to one that can") from error
