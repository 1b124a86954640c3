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

from rodless_base.atomic_write import make_folder
from rodless_lab.studies.journal import Journal
from rodless_lab.studies.own_file import claim, locked
from rodless_lab.studies.part import parquet_modules
from rodless_lab.studies.parts import Parts, data_folder
from rodless_lab.studies.row_run import RowResult
from rodless_lab.studies.saved_study import FILE, study_text
from rodless_lab.studies.study import Study


class Store:
    """The results of one study in one folder; one process at a time has it open."""

    def __init__(self, folder: Path, study: Study) -> None:
        """Open the folder, or make it.

        Raises StudyError where another study has its results there, another process is at work, or
        something there is not as it was written; ModuleNotFoundError without pyarrow; OSError for a
        folder that cannot be written.
        """
        parquet_modules()
        self._count = len(study)
        self._lock = Lock()
        make_folder(data_folder(folder))
        self._only = locked(folder)
        try:
            claim(folder, FILE, study_text(study), "the results of another study")
            self._parts = Parts(folder, study)
            self._known = [self._read_part(part) for part in self._parts.numbers]
        except BaseException:
            os.close(self._only)
            raise

    def close(self) -> None:
        """Let others have the folder."""
        os.close(self._only)

    def missing(self) -> Iterator[int]:
        """Yield the rows that are not known yet, in order."""
        for number in range(self._count):
            known = self._known[self._parts.of(number)]
            if known is not None and number not in known:
                yield number

    @property
    def done(self) -> int:
        """How many rows are known."""
        return sum(
            len(self._parts.rows(part)) if known is None else len(known)
            for part, known in enumerate(self._known)
        )

    def add(self, result: RowResult) -> None:
        """Keep a row: the end of this process does not lose it then; several threads may."""
        part = self._parts.of(result.row)
        row = result._asdict() | {"metrics": list(result.metrics)}
        with self._lock:
            known = self._known[part]
            if known is None or result.row in known:
                return
            known[result.row] = self._journal(part).add(row)
            if self._finished(part, known):
                self._known[part] = None

    def _finished(self, part: int, known: dict[int, dict[str, Any]]) -> bool:
        """Write a part of which all rows are known; return whether they are."""
        rows = self._parts.rows(part)
        if len(known) < len(rows):
            return False
        self._parts.write(part, [known[number] for number in rows])
        self._journal(part).remove()
        return True

    def _read_part(self, part: int) -> dict[int, dict[str, Any]] | None:
        """Return the rows that the journal of a part has, None where the part is complete."""
        journal = self._journal(part)
        if self._parts.is_complete(part):
            self._parts.check(part)
            journal.known()  # raises for what is none of ours
            journal.remove()
            return None
        known: dict[int, dict[str, Any]] = {row["row"]: row for row in journal.known()}
        return None if self._finished(part, known) else known

    def _journal(self, part: int) -> Journal:
        return Journal(self._parts.journal(part), self._parts.results_of)
