# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The files that a folder of results has beside its data, and whose folder it is."""

import json
import os
from pathlib import Path

from rodless_base.atomic_write import atomic_write
from rodless_base.one_line import in_one_line
from rodless_base.regular_file import NotAFileError, open_file
from rodless_lab.results_folder import lock_or_refuse
from rodless_lab.studies.errors import StudyError

# Locked by the process that works in a folder.
LOCK = ".lock"


def open_own(path: Path, flags: int = os.O_RDONLY) -> int:
    """Return a descriptor as :func:`open_file`; raises StudyError for what is no file, OSError."""
    try:
        return open_file(path, flags)
    except NotAFileError as error:
        raise StudyError(
            f"{path}: {error.strerror}; remove it, or give another --output"
        ) from error


def read_own(path: Path) -> bytes:
    """Return what a file holds; raises as :func:`open_own`."""
    with os.fdopen(open_own(path), "rb") as file:
        return file.read()


def locked(folder: Path) -> int:
    """Return the descriptor that keeps others out until it is closed, or the process ends.

    Raises StudyError where another process has it, OSError.
    """
    descriptor = open_own(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)
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
    try:
        found = read_own(place).decode(errors="replace")
    except FileNotFoundError:
        atomic_write(place, content)
        return
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
    except (ValueError, TypeError, AttributeError, RecursionError):  # damaged
        return "all"
    return in_one_line(", ".join(keys)) or "its text alone"
