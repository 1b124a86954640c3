# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How much memory there is for a run."""

import os
from contextlib import suppress
from pathlib import Path

# The process's control group, where it sees one of its own.
GROUP = Path("/sys/fs/cgroup")


def available_memory() -> int:
    """Return the bytes that this process can have without others losing theirs."""
    return min(_free(), _free_of_group())


def refuse_more_than_there_is(size: int, what: str, way_out: str) -> None:
    """Raise ValueError, which says ``what`` takes how much and the ``way_out``, for too many bytes.

    Linux promises memory that it has not, and ends a process that then uses it.
    """
    available = available_memory()
    if size > available:
        raise ValueError(
            f"{what} take {size / 1e9:.3g} GB of memory, {available / 1e9:.3g} GB are free; "
            f"{way_out}"
        )


def room_for(size: int) -> int:
    """Return how many times there is room for so many bytes."""
    return available_memory() // size


def _free() -> int:
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _free_of_group() -> int:
    """Return what the control group may still take, as in a container; else a very large number."""
    try:
        limit = int((GROUP / "memory.max").read_text(encoding="ascii"))
    except (OSError, ValueError):  # there is none, or "max"
        return 2**63
    return max(limit - _used_by_group(), 0)


def _used_by_group() -> int:
    """Return what the group has taken, without the copies of files, which give way."""
    with suppress(OSError, ValueError):
        text = (GROUP / "memory.stat").read_text(encoding="ascii")
        counts = dict(line.split() for line in text.splitlines())
        files = sum(int(counts.get(f"{kind}_file", 0)) for kind in ("active", "inactive"))
        return int((GROUP / "memory.current").read_text(encoding="ascii")) - files
    return 0
