# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Paths as they are given, to a function or on a command line."""

import os
from collections.abc import Callable
from pathlib import Path

from rodless_base.one_line import OneLineError, shown

# Of one name in a path, in bytes: what the file systems of Linux take.
LONGEST_NAME = 255


def file_path(given: object, refusal: Callable[[str], Exception] = OneLineError) -> Path:
    """Return the path that is given as a text or as an object with one, such as a Path.

    ``refusal`` makes the error, by default a ValueError, for a text that no file can have.

    Raises
    ------
    TypeError
        For what is no path: a number, bytes, None.
    ValueError
        Or what ``refusal`` makes; it says why.

    Examples
    --------
    >>> file_path("run1").name
    'run1'
    """
    text = os.fspath(given) if isinstance(given, os.PathLike) else given
    if not isinstance(text, str):
        raise TypeError(f"{shown(given)} refused, must be a path: a text or a pathlib.Path")
    wrong = _wrong_with(text)
    if wrong:
        raise refusal(f"{shown(text)} refused, no file has this path: {wrong}")
    return Path(text)


def _wrong_with(text: str) -> str:
    if not text:
        return "it is empty"
    if "\0" in text:
        return "it has a NUL"
    try:
        names = os.fsencode(text).split(b"/")
    except UnicodeEncodeError:
        return "it has half a character"
    if max(map(len, names)) > LONGEST_NAME:
        return f"it has a name of more than {LONGEST_NAME} bytes"
    return ""
