# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the rows of a sweep are kept, so that the end of the process, however it comes, loses none.

A row is appended to the journal of its part as soon as it is known; once all rows of a part are,
the part becomes a Parquet file and the journal goes. Both hold the same numbers, to the bit: a
resumed sweep ends with the files of one that was never interrupted.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import Any

from rodless_base.atomic_write import atomic_write, make_folder
from rodless_base.real_number import is_number
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.journal import add_line, claim, known_lines, locked
from rodless_lab.studies.part import (
    check_rows,
    data_folder,
    parquet_modules,
    part_bytes,
    part_file,
)
from rodless_lab.studies.row_run import RowResult
from rodless_lab.studies.saved_study import FILE, study_text
from rodless_lab.studies.study import Study

# Rows of a file, some seconds of work; fewer where their traces would fill the memory.
PART = 1000
NUMBERS = 1_000_000


class Store:
    """The results of one study in one folder; one process at a time has it open."""

    def __init__(self, folder: Path, study: Study) -> None:
        """Open the folder, or make it.

        Raises StudyError where another study has its results there, or another process is at work;
        ModuleNotFoundError without pyarrow; OSError for a folder that cannot be written.
        """
        parquet_modules()
        self._folder = folder
        self._study = study
        self._size = max(min(PART, NUMBERS // (study.numbers + 1)), 1)
        self._lock = Lock()
        make_folder(data_folder(folder))
        self._only = locked(folder)
        try:
            claim(folder, FILE, study_text(study), "the results of another study")
            self._known = [self._read_part(part) for part in range(self._parts)]
        except BaseException:
            os.close(self._only)
            raise

    def close(self) -> None:
        """Let others have the folder."""
        os.close(self._only)

    @property
    def _parts(self) -> int:
        return -(-len(self._study) // self._size)

    def missing(self) -> Iterator[int]:
        """Yield the rows that are not known yet, in order."""
        for number in range(len(self._study)):
            known = self._known[number // self._size]
            if known is not None and number not in known:
                yield number

    @property
    def done(self) -> int:
        """How many rows are known."""
        return sum(
            len(self._rows_of(part)) if known is None else len(known)
            for part, known in enumerate(self._known)
        )

    def add(self, result: RowResult) -> None:
        """Keep a row: the end of this process does not lose it then; several threads may."""
        part = result.row // self._size
        row = result._asdict() | {"metrics": list(result.metrics)}
        with self._lock:
            known = self._known[part]
            if known is None or result.row in known:
                return
            add_line(self._journal(part), row)
            known[result.row] = row
            if len(known) == len(self._rows_of(part)):
                self._finish(part, known)
                self._known[part] = None

    def _finish(self, part: int, known: dict[int, dict[str, Any]]) -> None:
        rows = [known[number] for number in self._rows_of(part)]
        atomic_write(self._file(part), part_bytes(self._study, rows))
        self._journal(part).unlink()

    def _read_part(self, part: int) -> dict[int, dict[str, Any]] | None:
        """Return the rows that the journal of a part has, None where the part is complete."""
        journal = self._journal(part)
        if self._file(part).exists():
            check_rows(self._file(part), self._study, self._rows_of(part))
            journal.unlink(missing_ok=True)
            return None
        known: dict[int, dict[str, Any]] = {
            row["row"]: row for row in known_lines(journal, lambda row: self._checked(row, part))
        }
        if len(known) == len(self._rows_of(part)):
            self._finish(part, known)
            return None
        return known

    def _checked(self, row: dict[str, Any], part: int) -> dict[str, Any]:
        """Return a ``row`` of a journal; raises ValueError, TypeError or KeyError for none."""
        numbers = [value for value in row["metrics"] if value is not None]
        kinds = {"row": int, "failure": str, "traces": dict}
        if not all(type(row[name]) is kind for name, kind in kinds.items()):
            raise TypeError("other fields than a row has")
        if row["row"] not in self._rows_of(part) or not all(map(is_number, numbers)):
            raise ValueError("other numbers than a row has")
        if len(row["metrics"]) != len(RunMetrics._fields):
            raise ValueError("other figures than a row has")
        return row

    def _rows_of(self, part: int) -> range:
        return range(part * self._size, min((part + 1) * self._size, len(self._study)))

    def _file(self, part: int) -> Path:
        return part_file(self._folder, part)

    def _journal(self, part: int) -> Path:
        # Readers of the data set leave out what begins with a dot.
        return self._file(part).with_name(f".part-{part:05}.jsonl")
