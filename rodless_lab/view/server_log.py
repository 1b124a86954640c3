# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the libraries below the pages log, in one line each."""

import errno
import logging
import os
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rodless_base.one_line import described, in_one_line

# Those that log what came over a socket.
SERVER = "uvicorn.error"  # which logs errors of pages, too
LOGGERS = ("nicegui", "asyncio", "engineio.server", "socketio.server", SERVER)
WEBSOCKETS = f"{os.sep}uvicorn{os.sep}protocols{os.sep}websockets{os.sep}"

# s between two lines on messages that were none, or on connections that find no room.
PERIOD = 10.0
FULL = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

PACKAGES = ("rodless_base", "rodless_sim", "rodless_control", "rodless_lab")

# Where this package's own modules are: the four that it installs lie side by side.
OURS = tuple(f"{Path(__file__).parents[2] / name}{os.sep}" for name in PACKAGES)

# Through which every request of a page goes on to the libraries.
PASSED_THROUGH = str(Path(__file__).with_name("origins.py"))


class OneLineEach(logging.Filter):
    """Lets one line through for a message that was none, and counts those that come meanwhile.

    What a socket sends may be anything, and the libraries below answer it by tracebacks of their
    own. An error in this package keeps its traceback: that is a fault to be mended.
    """

    def __init__(self) -> None:
        """Begin."""
        super().__init__()
        self._said = -PERIOD
        self._since = 0
        self._said_full = -PERIOD

    def filter(self, record: logging.LogRecord) -> bool:
        """Make the record one line; False for one that only counts."""
        text = in_one_line(record.getMessage())
        error = record.exc_info[1] if record.exc_info else None
        if error is not None and not _is_ours(error, record.name):
            why = in_one_line(described(error))
            if record.name == "asyncio" and isinstance(error, OSError) and error.errno in FULL:
                if time.monotonic() - self._said_full < PERIOD:
                    return False
                self._said_full = time.monotonic()
                text = f"more connections than can be served wait or are refused: {why}"
            elif isinstance(error, OSError):
                text = f"{text}: {why}"
            elif self._counted():
                return False
            else:
                text = (
                    "messages from a socket that were none of a page's, ignored: "
                    f"{self._since}; the last: {type(error).__name__}: {why}"
                )
                self._said, self._since = time.monotonic(), 0
            record.exc_info = record.exc_text = None
        record.msg, record.args = text, ()
        return True

    def _counted(self) -> bool:
        """Count a message that was none; whether that is enough, since others were just told of."""
        self._since += 1
        return time.monotonic() - self._said < PERIOD


def _is_ours(error: BaseException, logger: str) -> bool:
    """Whether an error may be this package's, and is no answer to what a socket has sent."""
    files = {frame.filename for frame in traceback.extract_tb(error.__traceback__)}
    if logger == SERVER and not any(WEBSOCKETS in file for file in files):
        return True  # of a page, by whatever made it
    return any(file.startswith(OURS) for file in files - {PASSED_THROUGH})


@contextmanager
def one_line_each() -> Iterator[None]:
    """Filter the libraries' loggers by one :class:`OneLineEach`."""
    one = OneLineEach()
    for name in LOGGERS:
        logging.getLogger(name).addFilter(one)
    try:
        yield
    finally:
        for name in LOGGERS:
            logging.getLogger(name).removeFilter(one)
