# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lines that are kept as soon as they are known, in a folder of one process at a time."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from rodless_base.atomic_write import atomic_write
from rodless_base.one_line import in_one_line
from rodless_lab.results_folder import lock_or_refuse
from rodless_lab.studies.errors import StudyError

Found = TypeVar("Found")


# Locked by the process that works in a folder.
LOCK = ".lock"


def locked(folder: Path) -> int:
    """Return the descriptor that keeps others out until it is closed, or the process ends.

    Raises StudyError where another process has it.
    """
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        lock_or_refuse(descriptor, folder)
    except OSError as error:
        os.close(descriptor)
        raise StudyError(f"{folder}: {error.strerror}") from error
    return descriptor


def claim(folder: Path, file: str, content: str, what: str) -> None:
    """Keep in ``file`` of a folder what its results depend on.

    ``content`` is a JSON object. Raises StudyError where the file has a different one: then the
    folder holds ``what``, such as "the results of another study".
    """
    place = folder / file
    if not place.exists():
        atomic_write(place, content)
        return
    found = place.read_text(encoding="utf-8", errors="replace")
    if found != content:
        raise StudyError(
            f"{folder}: holds {what}, or of another version of this package: {file} differs in "
            f"{_different(found, content)}; give another --output, or remove the folder"
        )


def _different(found: str, wanted: str) -> str:
    """Return the keys whose values differ between two JSON objects."""
    try:
        there, here = json.loads(found), json.loads(wanted)
        keys = [key for key in {**there, **here} if there.get(key) != here.get(key)]
    except (ValueError, TypeError, AttributeError):  # damaged
        return "all"
    return in_one_line(", ".join(keys)) or "its text alone"


def known_lines(journal: Path, read: Callable[[Any], Found]) -> list[Found]:
    """Return what ``read`` makes of the lines of a journal.

    Half a line at its end is cut off. Raises StudyError for another line that is damaged: one that
    is no JSON, or of which ``read`` raises ValueError, TypeError or KeyError.
    """
    if not journal.exists():
        return []
    found, good = [], 0
    with journal.open("rb") as file:
        for number, line in enumerate(file, 1):
            # A process that was killed may have left half a line.
            if not line.endswith(b"\n"):
                break
            try:
                found.append(read(json.loads(line)))
            except (ValueError, TypeError, KeyError, ArithmeticError, RecursionError) as error:
                raise StudyError(
                    f"{journal}: line {number} is damaged; remove that line, or give another "
                    "--output"
                ) from error
            good += len(line)
    os.truncate(journal, good)
    return found


def add_line(journal: Path, value: object) -> None:
    """Keep a value: what this process has written survives its end, not that of the machine."""
    with journal.open("a", encoding="utf-8") as file:
        file.write(json.dumps(value) + "\n")
