# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Standard output and error whose reader may leave: what cannot be written is left out.

A closed pipe or a full disk behind standard output must not end a node or a recording.
"""

import errno
import io
import os
import select
import stat
import sys
from typing import Any

INPUT, OUTPUT, ERROR = range(3)


class _Descriptor(io.FileIO):
    """Writes while it can; ``failure`` is the first reason why it could not."""

    failure: OSError | None = None

    def __init__(self, number: int) -> None:
        super().__init__(number, "w", closefd=False)

    def write(self, data: Any, /) -> int:
        """Write ``data``, or throw it away."""
        if self.failure is None:
            try:
                while (count := super().write(data)) is None:
                    # A full pipe that somebody has told not to block.
                    select.select([], [self], [])
                return count
            except OSError as error:
                self.failure = error
        return len(data)


class Output:
    """Standard output and error from now on until the process ends."""

    def __init__(self) -> None:
        """Replace ``sys.stdout`` and ``sys.stderr``, unless somebody else, a test, has already."""
        _open_closed()
        self._written: _Descriptor | None = None
        if sys.stdout is sys.__stdout__:
            self._written = _Descriptor(OUTPUT)
            sys.stdout = _text(self._written, line_buffering=self._written.isatty())
        if sys.stderr is sys.__stderr__:
            sys.stderr = _text(_Descriptor(ERROR), line_buffering=True)

    def end(self) -> str | None:
        """Hand over what has been printed; return why it could not be written.

        None for a reader who has left, or a terminal that was closed: they have seen what they
        wanted.
        """
        sys.stdout.flush()
        failure = None if self._written is None else self._written.failure
        if failure is None or failure.errno == errno.EPIPE or _is_closed_terminal(failure):
            return None
        return f"standard output: cannot be written: {failure.strerror}"


def _is_closed_terminal(failure: OSError) -> bool:
    """Whether it is one that ``failure`` comes from, and not a disk that is broken."""
    return failure.errno == errno.EIO and stat.S_ISCHR(os.fstat(OUTPUT).st_mode)


def _open_closed() -> None:
    """Put /dev/null in place of what the caller has closed, or the next file would be it."""
    for number in (INPUT, OUTPUT, ERROR):
        try:
            os.fstat(number)
        except OSError:
            # The lowest number that is free, which is this one.
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)


def _text(raw: _Descriptor, line_buffering: bool) -> io.TextIOWrapper:
    """Return a stream of text; what its encoding cannot say is written with backslashes."""
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=getattr(sys.__stdout__, "encoding", None),
        errors="backslashreplace",
        line_buffering=line_buffering,
    )
