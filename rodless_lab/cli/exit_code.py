# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How the commands end that read bags and write into a folder."""

import sys
from collections.abc import Callable
from pathlib import Path

from rodless_base.atomic_write import cannot_be_written, check_writable
from rodless_lab.runs.measured_run import RunError
from rodless_sim import ParameterError


def can_be_written(output: Path, look: Callable[[Path], None] = check_writable) -> bool:
    """Whether ``output`` can be; says on standard error where not. ``look`` raises OSError then."""
    try:
        look(output)
    except OSError as error:
        print(cannot_be_written(error.filename or output, error), file=sys.stderr)
        return False
    return True


def exit_code(
    work: Callable[[], None], output: Path, look: Callable[[Path], None] = check_writable
) -> int:
    """Do ``work``; return 0, or 2 after a line about a run or ``output`` that cannot be used.

    ``output``, by default a folder, is looked at as by :func:`can_be_written` before the work.
    """
    if not can_be_written(output, look):
        return 2
    try:
        work()
    except (RunError, ParameterError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(cannot_be_written(error.filename or output, error), file=sys.stderr)
        return 2
    return 0
