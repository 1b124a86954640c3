# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How much memory processes keep: readings over time, and whether they grow."""

import os
from pathlib import Path

import numpy as np

# The first part of a run, in which caches fill, tells nothing of leaks.
SETTLING = 0.25

PAGE = os.sysconf("SC_PAGE_SIZE")  # bytes, of /proc/<pid>/statm
MEGA = 1e6


def resident(pid: int) -> float:
    """Return the memory of a process in MB; raises OSError for one that has ended."""
    return int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * PAGE / MEGA


def growth(readings: list[tuple[float, float]]) -> float:
    """Return how fast memory grows, in MB/h, from readings of time (s) and memory (MB).

    The slope of a straight line through all but the first quarter; NaN for too few.
    """
    settled = readings[int(SETTLING * len(readings)) :]
    if len(settled) < 3:
        return float("nan")
    times, sizes = np.array(settled).T
    return float(np.polyfit(times - times[0], sizes, 1)[0] * 3600.0)
