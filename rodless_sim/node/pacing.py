# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Deadlines on the wall clock, kept by sleeping; lateness is counted, never made up."""

import time
from collections.abc import Callable

from rodless_base.constants import NANOSECONDS_PER_SECOND

# A long sleep is taken in pieces, so that a request to stop is seen in time.
LONGEST_SLEEP = 50_000_000


class Pacer:
    """A grid of deadlines ``period`` ns apart."""

    def __init__(
        self,
        period: int,
        now: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Start the grid now."""
        self._period = period
        self._now = now
        self._sleep = sleep
        self.overruns = 0
        self.restart()

    def restart(self) -> None:
        """Start the grid anew now."""
        self._deadline = self._now()

    def wait(self, stopped: Callable[[], bool]) -> bool:
        """Sleep until the next deadline; return False as soon as ``stopped`` says so.

        A deadline that is already a whole period past is an overrun: it is counted and the grid
        moves on to the present, so no burst of steps follows.
        """
        self._deadline += self._period
        late = self._now() - self._deadline
        if late >= self._period:
            self.overruns += late // self._period
            self._deadline += late
        while not stopped():
            remaining = self._deadline - self._now()
            if remaining <= 0:
                return True
            self._sleep(min(remaining, LONGEST_SLEEP) / NANOSECONDS_PER_SECOND)
        return False
