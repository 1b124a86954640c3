# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Time in which this process has been awake."""

import threading
import time
from collections.abc import Callable

from rodless_base.constants import NANOSECONDS_PER_SECOND

# Seconds between two readings beyond which the process has been stopped, or had no processor.
STALL = 0.5

# How often, in s, to look how much processor time this process has used: reading that costs several
# times what reading a clock does.
LOOK = 0.1


class AwakeClock:
    """Seconds that pass from reading to reading; of a longer pause between two, ``STALL`` counts.

    Whoever was stopped has not waited for others. It has to be read all the while.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        """Begin at 0; ``now`` is a steady time in s."""
        self._now = now
        self._read = now()
        self._awake = 0.0

    def __call__(self) -> float:
        """Return the time in s."""
        now = self._now()
        self._awake += min(now - self._read, STALL)
        self._read = now
        return self._awake


class RunningClock:
    """Nanoseconds in which this process ran or could have; what it was stopped for is left out.

    All of its threads that keep time read it, all the while. Where none has for longer than
    ``STALL`` and the processor was hardly used either, the process was stopped, or had none. One
    that computes for as long is slow, and that counts.
    """

    def __init__(
        self,
        now: Callable[[], int] = time.monotonic_ns,
        used: Callable[[], int] = time.process_time_ns,
    ) -> None:
        """Go by ``now``, a steady time in ns; ``used`` is the processor time so far, in ns."""
        self._now = now
        self._used = used
        self._lock = threading.Lock()
        self._read = self._looked = now()
        self._used_then = used()
        self.stopped = 0  # ns that were left out so far

    def __call__(self) -> int:
        """Return the time in ns."""
        with self._lock:
            now = self._now()
            if now - self._looked > LOOK * NANOSECONDS_PER_SECOND:
                self._look(now)
            self._read = now
            return now - self.stopped

    def _look(self, now: int) -> None:
        silent = now - self._read
        used = self._used()
        idle = used - self._used_then < silent / 2
        if idle and silent > STALL * NANOSECONDS_PER_SECOND:
            self.stopped += silent
        self._looked, self._used_then = now, used


class StopNews:
    """Says of each stop that it has been, and for how long."""

    def __init__(self, clock: RunningClock) -> None:
        """Tell of stops from now on."""
        self._clock = clock
        self._told = clock.stopped

    def hear(self) -> str | None:
        """Return what has not been told yet; None where that is nothing."""
        stopped = self._clock.stopped
        untold, self._told = stopped - self._told, stopped
        if not untold:
            return None
        seconds = untold / NANOSECONDS_PER_SECOND
        return (
            f"this process stood still for {seconds:.2f} s: it was stopped, had no processor, or a "
            "stopped reader held it in shared memory; that counts neither as lag nor as overruns"
        )
