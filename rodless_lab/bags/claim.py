# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A storage file that is being recorded is its recorder's alone."""

import errno
import fcntl
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rodless_lab.bags.metadata import BagError


@contextmanager
def claimed(file: Path) -> Iterator[None]:
    """Keep ``file`` for this process, which may change it.

    Raises :class:`BagError` where another has claimed it, or has it open to write as rosbag2's
    recorder does; OSError for a file that cannot be read.
    """
    with _opened(file) as descriptor:
        if not _is_free(descriptor, fcntl.LOCK_EX):
            raise BagError(f"{file}: is still being written; end the recording first")
        yield


def is_being_written(file: Path) -> bool:
    """Whether another process has claimed ``file``, or has it open to write; raises OSError."""
    with _opened(file) as descriptor:
        return not _is_free(descriptor, fcntl.LOCK_SH)


def claim(descriptor: int) -> None:
    """Keep the file that is open as ``descriptor`` until that is closed, or the process ends."""
    _is_locked(descriptor, fcntl.LOCK_EX)


@contextmanager
def _opened(file: Path) -> Iterator[int]:
    descriptor = os.open(file, os.O_RDONLY | os.O_CLOEXEC)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _is_free(descriptor: int, lock: int) -> bool:
    return not (_is_locked(descriptor, lock) or _is_open_to_write(descriptor))


def _is_locked(descriptor: int, lock: int) -> bool:
    """Whether another process keeps this one from the ``lock``; this one has it otherwise."""
    try:
        fcntl.flock(descriptor, lock | fcntl.LOCK_NB)
    except OSError as error:
        # Shared file systems may have no locks; there nobody is kept out.
        return error.errno == errno.EWOULDBLOCK
    return False


def _is_open_to_write(descriptor: int) -> bool:
    """Whether the kernel refuses a lease, which it gives on a file that nobody can change.

    Some file systems give none, nor does anybody else's file: then nothing is known.
    """
    try:
        # By default the signal that somebody wants to write now would end this process.
        fcntl.fcntl(descriptor, fcntl.F_SETSIG, signal.SIGURG)
        fcntl.fcntl(descriptor, fcntl.F_SETLEASE, fcntl.F_RDLCK)
        fcntl.fcntl(descriptor, fcntl.F_SETLEASE, fcntl.F_UNLCK)
    except OSError as error:
        return error.errno == errno.EAGAIN
    return False
