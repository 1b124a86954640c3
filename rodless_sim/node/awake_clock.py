# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Time in which this process has been awake."""

import time
from collections.abc import Callable

# Seconds between two readings beyond which the process has been stopped, or had no processor.
STALL = 0.5


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
