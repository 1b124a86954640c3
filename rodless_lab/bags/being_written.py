# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a storage file is still being recorded, and keeping others from it."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rodless_base.one_line import in_one_line
from rodless_lab.bags.file_lock import is_locked_to_write, lock_to_write
from rodless_lab.bags.metadata import BagError

PROCESSES = Path("/proc")

_UNSEEN = "another process"


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Keep ``file`` for this process, which may change it.

    Raises :class:`BagError` where another process has it locked or open to write, as rosbag2's
    recorder has, which locks nothing; OSError for a file that cannot be opened.
    """
    writer = _seen_writer(file)
    descriptor = _opened(file)
    try:
        if writer or not lock_to_write(descriptor):
            raise BagError(f"{file} {still_written(writer or _UNSEEN)}")
        yield
    finally:
        os.close(descriptor)


def still_written(writer: str) -> str:
    """Say what is the matter with a file, and the way out."""
    return f"is still being written by {writer}; end that first"


def writer_of(file: Path) -> str:
    """Return the name of a process that writes ``file``; empty where there is none.

    Recorders of this package are noticed by their lock, whoever runs them; others only where the
    system shows what they have open. Raises OSError for a file that cannot be opened.
    """
    return _seen_writer(file) or (_UNSEEN if _is_locked(file) else "")


def _is_locked(file: Path) -> bool:
    with file.open("rb") as opened:
        return is_locked_to_write(opened.fileno())


def _seen_writer(file: Path) -> str:
    place = Path(os.path.realpath(file))
    for process in PROCESSES.glob("[0-9]*"):
        with suppress(OSError):  # it has ended meanwhile, or is another user's
            if any(_writes(one, place) for one in (process / "fd").iterdir()):
                command = in_one_line((process / "comm").read_text(errors="replace"))
                return f"process {process.name} ({command})"
    return ""


def _writes(descriptor: Path, place: Path) -> bool:
    """Whether a process's descriptor is of the file there, and can be written to."""
    with suppress(OSError):  # it has been closed meanwhile
        if descriptor.readlink() == place:
            about = (descriptor.parent.parent / "fdinfo" / descriptor.name).read_text()
            flags = next(line for line in about.splitlines() if line.startswith("flags:"))
            return bool(int(flags.split()[1], 8) & os.O_ACCMODE)
    return False


def _opened(file: Path) -> int:
    try:
        # Only one that can be written can be locked.
        return os.open(file, os.O_RDWR | os.O_CLOEXEC)
    except OSError as error:
        if error.errno not in (errno.EACCES, errno.EPERM, errno.EROFS):
            raise
        return os.open(file, os.O_RDONLY | os.O_CLOEXEC)
