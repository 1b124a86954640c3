# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How well plant time keeps up with the wall clock."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from rodless_base.constants import NANOSECONDS_PER_SECOND

# Plant time falls behind where it advances by less than this share of what it should.
ENOUGH = 0.95

# Good reports in a row after which plant time keeps up again: a machine at its limit would
# otherwise say so every second.
GOOD_REPORTS = 10


@dataclass(frozen=True)
class Pace:
    """The pace since the report before, and the lag that has built up."""

    speed_factor: float  # plant s per wall-clock s
    lag: float  # s of plant time
    # None where that cannot be told: plant time was not meant to advance all the while.
    falls_behind: bool | None


class PaceMeter:
    """Compares plant time with the wall clock.

    The lag is how far plant time is behind the wall clock times ``speed``, counted from when the
    plant was started, resumed or reset; pauses do not count, nor does what ``now`` leaves out.
    Plant time advances in periods, so up to one of them is no lag. With ``speed`` 0 the commands
    drive plant time, and nothing can lag.
    """

    def __init__(
        self, speed: float, period: int, now: Callable[[], int] = time.monotonic_ns
    ) -> None:
        """Expect ``speed`` plant s per wall-clock s, in periods of ``period`` ns of plant time."""
        self._speed = speed
        self._period = period
        self._now = now
        self._wall, self._plant = now(), 0
        self._start: tuple[int, int] | None = None
        self._lag = 0
        self._elapsed = self._advanced = 0
        self._interrupted = True

    def observe(self, plant: int, running: bool) -> None:
        """Take plant time (ns) as it is now, and whether it is meant to advance.

        To be called often: what ends before the next call, such as a short pause, is not seen.
        """
        wall = self._now()
        was_reset = plant < self._plant
        self._elapsed += wall - self._wall
        self._advanced += plant if was_reset else plant - self._plant
        self._wall, self._plant = wall, plant
        if not running:
            self._start = None
        elif self._start is None or was_reset:
            self._start = wall, plant
        else:
            start_wall, start_plant = self._start
            due = round(self._speed * (wall - start_wall)) - self._period
            self._lag = max(due - (plant - start_plant), 0)
            return
        self._interrupted = True

    def report(self) -> Pace:
        """Return the pace since the last report, and begin the next."""
        due = ENOUGH * self._speed * self._elapsed - self._period
        pace = Pace(
            speed_factor=self._advanced / self._elapsed if self._elapsed else 0.0,
            lag=self._lag / NANOSECONDS_PER_SECOND,
            falls_behind=None if self._interrupted else self._advanced < due,
        )
        self._elapsed = self._advanced = 0
        self._interrupted = self._start is None
        return pace


class PaceNews:
    """Says once that plant time falls behind, and once that it keeps up again."""

    def __init__(self, speed: float, period: float) -> None:
        """Name ``time.speed`` and ``time.period`` (s) in what is said."""
        self._speed = speed
        self._period = period
        self.clear()

    def clear(self) -> None:
        """Forget what was heard: a plant that falls behind still is news again."""
        self._good = 0
        self.behind = False

    def hear(self, pace: Pace) -> str | None:
        """Return what has changed with this report, if anything; ``behind`` says which way."""
        if pace.falls_behind:
            self._good = 0
            if not self.behind:
                self.behind = True
                return self._falls_behind(pace)
        elif self.behind and pace.falls_behind is not None:
            self._good += 1
            if self._good == GOOD_REPORTS:
                self.behind = False
                return f"plant time keeps up again; total lag {pace.lag:.3f} s"
        return None

    def _falls_behind(self, pace: Pace) -> str:
        return (
            f"plant time falls behind: {pace.speed_factor:.2f} s per wall-clock second instead of "
            f"{self._speed:g}, {pace.lag:.3f} s late by now; this machine is too slow or too busy "
            f"for time.period {self._period:g} s at time.speed {self._speed:g}: take a longer "
            "time.period or a smaller time.speed, or run fewer programs beside the plant"
        )
