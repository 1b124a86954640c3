# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lines that are kept as soon as they are known."""

import json
import os
import re
from pathlib import Path
from typing import Any

from rodless_base.atomic_write import naming
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.own_file import open_own
from rodless_lab.studies.seal import Seal

# A line is a JSON list of the first digits of its seal and of a value.
_DIGITS = 16
_HEAD = b'["' + b"0" * _DIGITS + b'", '


class Journal:
    """A file of values, one a line; a line says whether it is as it was written."""

    def __init__(self, path: Path, results_of: bytes) -> None:
        """Take the file, which need not be there, and what its values depend on."""
        self._path = path
        self._seal = Seal(results_of, path.name)

    def known(self) -> list[Any]:
        """Return the values that were kept, in order; half a line at the end is cut off.

        Raises StudyError for any other line that has changed since, or is another journal's, and
        for what is no regular file; OSError for one that cannot be read and written.
        """
        try:
            descriptor = open_own(self._path, os.O_RDWR | os.O_NOFOLLOW)
        except FileNotFoundError:
            return []
        found, good = [], 0
        with os.fdopen(descriptor, "rb+") as file:
            for number, line in enumerate(file, 1):
                # A process that was killed may have left half a line.
                if _is_begun(line):
                    break
                text = line[len(_HEAD) : -len(b"]\n")]
                if line != self._line(text):
                    raise StudyError(
                        f"{self._path}: line {number} is damaged; remove that line, or give "
                        "another --output"
                    )
                found.append(json.loads(text))
                good += len(line)
            file.truncate(good)
        return found

    def add(self, value: object) -> Any:
        """Keep a value, and return it as it will be known.

        What this process has written survives its end, not that of the machine. Raises as
        :meth:`known`.
        """
        text = json.dumps(value).encode()
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW
        descriptor = open_own(self._path, flags)
        try:
            with naming(self._path):
                _append(descriptor, self._line(text))
        finally:
            os.close(descriptor)
        return json.loads(text)

    def remove(self) -> None:
        """Remove the file, if there is one; raises OSError."""
        self._path.unlink(missing_ok=True)

    def _line(self, text: bytes) -> bytes:
        digits = self._seal.of(text)[:_DIGITS].encode()
        return b'["' + digits + b'", ' + text + b"]\n"


def _append(descriptor: int, line: bytes) -> None:
    """Write a line whole or not at all: half of one would spoil the next."""
    before = os.fstat(descriptor).st_size
    try:
        written = os.write(descriptor, line)
        while written < len(line):
            written += os.write(descriptor, line[written:])
    except BaseException:
        os.ftruncate(descriptor, before)
        raise


def _is_begun(line: bytes) -> bool:
    """Whether a line of a journal was begun and not ended; any other text is left alone."""
    # Where the machine went down, the end of a file may be zeros.
    begun = line.rstrip(b"\0")[: len(_HEAD)]
    return not line.endswith(b"\n") and _HEAD.startswith(re.sub(rb"[0-9a-f]", b"0", begun))
