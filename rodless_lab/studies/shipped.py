# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Studies and tasks that ship with the package."""

import os
from pathlib import Path

from rodless_base.one_line import shown
from rodless_base.parameter_file import preset_directory
from rodless_lab.studies.errors import StudyError


def shipped(kind: str) -> dict[str, Path]:
    """Return the files of a kind (``studies``, ``tasks``) that ship, by name."""
    return {file.stem: file for file in sorted((preset_directory() / kind).glob("*.yaml"))}


def find_file(kind: str, given: str | Path) -> Path:
    """Return a file: a path, or the name of one that ships; raises StudyError."""
    known = shipped(kind)
    if isinstance(given, str) and given in known:
        return known[given]
    if not isinstance(given, str | os.PathLike) or Path(given).suffix not in (".yaml", ".yml"):
        raise StudyError(
            f"{shown(given)}: refused, must be a file .yaml or .yml, or one of {', '.join(known)}"
        )
    return Path(given)
