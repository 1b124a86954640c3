# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A folder of results is written by one process at a time: its files belong together."""

import errno
import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rodless_base.atomic_write import make_folder, removal_of_new


@contextmanager
def results_folder(folder: Path) -> Iterator[Callable[[], None]]:
    """Keep ``folder`` for one process; it is made where it is missing.

    Raises OSError where nothing can be written, or where another process has it. The claim is a
    lock, which the kernel drops when the process ends, however it ends. A folder that is new and
    got nothing is removed in the end, or by what is yielded: by a process that ends on the spot.
    """
    remove_what_is_empty = removal_of_new(folder)
    make_folder(folder)
    claim, owner = os.open(folder, os.O_RDONLY | os.O_DIRECTORY), os.getpid()
    try:
        lock_or_refuse(claim, folder)
        yield remove_what_is_empty
    finally:
        if os.getpid() == owner:
            with suppress(OSError):  # closing alone keeps it, where a process was forked meanwhile
                fcntl.flock(claim, fcntl.LOCK_UN)
        os.close(claim)
        remove_what_is_empty()


def lock_or_refuse(descriptor: int, path: Path) -> None:
    """Lock what is open as ``descriptor``, or raise OSError: another process has ``path``.

    Shared file systems may have no locks; there nobody is kept out.
    """
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise OSError(
            errno.EBUSY,
            "another process writes there; wait for its end, or give another --output",
            str(path),
        ) from error
    except OSError as error:
        if error.errno not in (errno.EBADF, errno.ENOLCK, errno.ENOTSUP):
            raise
