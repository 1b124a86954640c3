# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The parts of a sweep: which rows stand in which file of its data set."""

import os
from pathlib import Path
from typing import Any

from rodless_base.atomic_write import atomic_write
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.own_file import read_own
from rodless_lab.studies.part import checked_part, part_bytes, read_part
from rodless_lab.studies.saved_study import FILE
from rodless_lab.studies.seal import Seal
from rodless_lab.studies.study import Study

# Rows of a file, some seconds of work; fewer where their traces would fill the memory.
PART = 1000
NUMBERS = 1_000_000

# What begins so is left out by readers of a data set.
_HIDDEN = (".", "_")


def data_folder(folder: Path) -> Path:
    """Return where the parts of a sweep in ``folder`` are."""
    return folder / "rows"


class Parts:
    """The parts of one study in one folder, which has the study and the folder of the data set."""

    def __init__(self, folder: Path, study: Study) -> None:
        """Look at the folder.

        Raises StudyError where something in the data set is none of its parts, OSError.
        """
        self._data = data_folder(folder)
        self._study = study
        self.results_of = read_own(folder / FILE)
        self._size = max(min(PART, NUMBERS // (study.numbers + 1)), 1)
        self._refuse_others()

    @property
    def numbers(self) -> range:
        """The numbers of the parts."""
        return range(-(-len(self._study) // self._size))

    def of(self, row: int) -> int:
        """Return the part that a row belongs to."""
        return row // self._size

    def rows(self, part: int) -> range:
        """Return the rows of a part."""
        return range(part * self._size, min((part + 1) * self._size, len(self._study)))

    def journal(self, part: int) -> Path:
        """Return where the rows of a part are until all of them are known."""
        return self._data / f".part-{part:05}.jsonl"

    def is_complete(self, part: int) -> bool:
        """Whether the file of a part is there, or something in its place."""
        return os.path.lexists(self._file(part))

    def write(self, part: int, rows: list[dict[str, Any]]) -> None:
        """Write a part, whole or not at all; raises OSError."""
        atomic_write(self._file(part), part_bytes(self._study, rows, self._seal(part)))

    def check(self, part: int) -> None:
        """Raise StudyError for a part that is not as this sweep wrote it."""
        checked_part(self._file(part), self._seal(part))

    def read(self, part: int, traces: bool = True) -> Any:
        """Return the table of a complete part, its ``traces`` too or not; raises as check."""
        return read_part(self._file(part), self._seal(part), traces)

    def _file(self, part: int) -> Path:
        return self._data / f"part-{part:05}.parquet"

    def _seal(self, part: int) -> Seal:
        return Seal(self.results_of, self._file(part).name)

    def _refuse_others(self) -> None:
        own = {self._file(part).name for part in self.numbers}
        entries = self._data.iterdir() if self._data.exists() else ()
        for name in sorted(entry.name for entry in entries):
            if name not in own and not name.startswith(_HIDDEN):
                raise StudyError(
                    f"{self._data / name}: no part of this sweep, but read with its rows; move it "
                    "elsewhere"
                )
