# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The lock of who writes a storage file: nobody else can take it, and everybody can look at it.

It belongs to what is open, as flock's does, and forked processes share it. But it wants a file that
is open to write: with flock, whoever can read a file keeps its owner from it.
"""

import errno
import fcntl
import struct

# C's struct flock: type, where the start counts from, start, length (0: to the end), process.
_FLOCK = struct.Struct("hhqqi4x")

# Of shared file systems, and of kernels that have none of these locks.
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL)


def lock_to_write(descriptor: int) -> bool:
    """Lock a file as the one who writes it; return False where somebody else does.

    One that is open to read only is not locked, but looked at, and so is one that a reader has
    locked: there nobody is kept out, nor on shared file systems without locks. Raises OSError.
    """
    try:
        _ask(descriptor, fcntl.F_OFD_SETLK, fcntl.F_WRLCK)
    except OSError as error:
        if error.errno not in (errno.EAGAIN, errno.EACCES, errno.EBADF, *_NO_LOCKS):
            raise
        # The lock of a reader, which all who can read may take, keeps nobody out either.
        return not is_locked_to_write(descriptor)
    return True


def is_locked_to_write(descriptor: int) -> bool:
    """Whether somebody else writes the file that is open there; raises OSError."""
    try:
        return _ask(descriptor, fcntl.F_OFD_GETLK, fcntl.F_RDLCK) != fcntl.F_UNLCK
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        return False


def _ask(descriptor: int, command: int, kind: int) -> int:
    """Ask for, or about, a lock of the whole file; return the kind that is answered."""
    answer = fcntl.fcntl(descriptor, command, _FLOCK.pack(kind, 0, 0, 0, 0))
    return int(_FLOCK.unpack(answer)[0])
