# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which files a study or a task is read from."""

from pathlib import Path

from rodless_base.parameter_file import preset_names
from rodless_base.yaml_file import read_yaml
from rodless_lab.studies.fields import Fields
from rodless_lab.studies.shipped import find_file


def files_read(kind: str, given: str | Path, what: str) -> dict[Path, str]:
    """Return the file of a study or task that has been read, and that of its base if it has one.

    ``kind`` is as for :func:`find_file`; ``what``, such as "the task", says what each is read as.
    """
    path = find_file(kind, given)
    base = Fields.of(str(path), read_yaml(path, what)).values.get("base")
    found = {path: what}
    if base is not None and base not in preset_names():
        found[path.parent / base] = f"the base of {what}"
    return found
