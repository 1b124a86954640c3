# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Files that are opened only where they are files: a pipe would be waited for without end."""

import errno
import os
import stat
from pathlib import Path

_WHAT = {
    errno.EISDIR: os.strerror(errno.EISDIR),
    errno.ELOOP: "a symbolic link, which is not followed",
    errno.ENXIO: "not a file but a pipe or device",
}


class NotAFileError(OSError):
    """What stands at a path is no regular file; ``strerror`` says what it is."""


def open_file(path: Path, flags: int = os.O_RDONLY) -> int:
    """Return a descriptor of a regular file, opened with ``flags`` of :func:`os.open`, at once.

    Raises NotAFileError for a folder, pipe, device or socket, with ``os.O_NOFOLLOW`` for a
    symbolic link too; OSError for what cannot be opened.
    """
    try:
        descriptor = os.open(path, flags | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except OSError as error:
        what = _WHAT.get(error.errno or 0)
        # Where links are followed, they go in a circle.
        if what is None or (error.errno == errno.ELOOP and not flags & os.O_NOFOLLOW):
            raise
        raise NotAFileError(error.errno, what, str(path)) from error
    kind = os.fstat(descriptor).st_mode
    if stat.S_ISREG(kind):
        return descriptor
    os.close(descriptor)
    number = errno.EISDIR if stat.S_ISDIR(kind) else errno.ENXIO
    raise NotAFileError(number, _WHAT[number], str(path))


def read_file(path: Path) -> bytes:
    """Return what a regular file holds; raises as :func:`open_file`."""
    with os.fdopen(open_file(path), "rb") as file:
        return file.read()
