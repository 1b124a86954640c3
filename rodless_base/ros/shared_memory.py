# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The shared memory of Fast DDS: what dead processes have left there, and too little of it."""

import fcntl
import os
import re
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

FOLDER = Path("/dev/shm")

# What a process needs there, in bytes: a segment of 540 kB and a few ports of 52 kB.
NEEDED = 1_000_000

# With less, in bytes, a process dies of SIGBUS as soon as it loads ROS, whose tracing has a page
# there.
LEAST = 16_384

# A segment, 16 hexadecimal digits, has a file beside it that its owner keeps locked while it lives.
LOCK_FILE = re.compile(r"fast(?:rtps|dds)_[0-9a-z]{16}_[es]l")

# Before it is locked such a file is there for a moment; wall-clock s.
YOUNG = 10.0

TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"

# With this range ROS makes a transport for shared memory whatever else is set.
LOCALHOST = "LOCALHOST"


def is_fast_dds() -> bool:
    """Whether the environment leaves it at Fast DDS, which ROS takes by itself."""
    chosen = os.environ.get("RMW_IMPLEMENTATION") or "rmw_fastrtps_cpp"
    return chosen.startswith("rmw_fastrtps")


def prepare_shared_memory(folder: Path = FOLDER) -> str | None:
    """Clear what dead processes left, and do without where there is no room: return that, if so.

    To be called before ROS is loaded. Segments alone are cleared, by the rule of ``fastdds shm
    clean``: those of this user whose owner holds no lock. Ports are left: Fast DDS takes them up
    again. Raises RuntimeError where there is no room and ROS insists.
    """
    clear_dead_segments(folder)
    free = _free(folder)
    if free < LEAST:
        raise RuntimeError(f"{folder}: {free / 1e3:.0f} kB free, ROS cannot be loaded: free some")
    if free >= NEEDED or TRANSPORTS in os.environ or not is_fast_dds():
        return None
    lack = f"{folder}: {free / 1e3:.0f} kB free, nodes need {NEEDED / 1e3:.0f} kB of shared memory"
    if os.environ.get(RANGE) == LOCALHOST:
        raise RuntimeError(f"{lack} with {RANGE}={LOCALHOST}: free some, or leave that out")
    os.environ[TRANSPORTS] = "UDPv4"
    return f"{lack}: going without, over UDP ({TRANSPORTS}=UDPv4)"


def clear_dead_segments(folder: Path = FOLDER) -> int:
    """Remove the segments in ``folder`` whose owner has died; return how many."""
    cleared = 0
    with suppress(OSError):
        for lock_file in sorted(folder.iterdir()):
            if LOCK_FILE.fullmatch(lock_file.name):
                cleared += _clear(lock_file)
    return cleared


def _clear(lock_file: Path) -> bool:
    """Remove a segment and its lock file, unless somebody lives who holds that."""
    try:
        with _locked(lock_file):
            segment = lock_file.with_name(lock_file.name[: -len("_el")])
            segment.unlink(missing_ok=True)
            lock_file.unlink()
    except OSError:  # locked, gone meanwhile, of another user, or on a read-only file system
        return False
    return True


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold the lock of a file of this user's; raises OSError where that cannot be."""
    descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        found = os.fstat(descriptor)
        is_own = found.st_uid == os.getuid() and stat.S_ISREG(found.st_mode)
        if not is_own or time.time() - found.st_mtime < YOUNG:
            raise PermissionError(path)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def _free(folder: Path) -> float:
    """Return the bytes that can be written there; as many as wanted where that is not known."""
    try:
        found = os.statvfs(folder)
    except OSError:
        return float("inf")
    # Of a read-only one Fast DDS says so itself, and goes on over UDP; one without a limit says 0.
    is_unknown = found.f_flag & os.ST_RDONLY or not found.f_blocks
    return float("inf") if is_unknown else float(found.f_bavail * found.f_frsize)
