# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Deadlines held on a clock that only sleeping and working move."""

import pytest

from rodless_base.constants import NANOSECONDS_PER_SECOND as NANOSECONDS
from rodless_sim.node.pacing import LONGEST_SLEEP, Pacer

PERIOD = 1_000_000


class Clock:
    """A clock in ns whose sleeps last ``share`` of what was asked, and ``late`` ns more."""

    def __init__(self, share: float = 1.0, late: int = 0) -> None:
        self.time = 123_456_789
        self.share = share
        self.late = late
        self.sleeps: list[int] = []

    def now(self) -> int:
        """Return the time."""
        return self.time

    def sleep(self, seconds: float) -> None:
        """Let about ``seconds`` pass."""
        self.sleeps.append(round(seconds * NANOSECONDS))
        self.time += max(round(self.share * self.sleeps[-1]), 1) + self.late

    def work(self, duration: int) -> None:
        """Let ``duration`` ns pass."""
        self.time += duration


def pacer(clock: Clock, period: int = PERIOD) -> Pacer:
    """A pacer on ``clock``."""
    return Pacer(period, clock.now, clock.sleep)


def never() -> bool:
    """Nobody asks to stop."""
    return False


@pytest.mark.parametrize("late", [0, 1, 57_000, 400_000])
def test_the_grid_is_held_exactly(late: int) -> None:
    """Ten thousand periods with work in them and sleeps too long end where they should."""
    clock = Clock(late=late)
    start, pace = clock.time, pacer(clock)
    for k in range(1, 10_001):
        clock.work(k * 7919 % 500_000)
        assert pace.wait(never)
        assert clock.time == start + k * PERIOD + late
    assert pace.overruns == 0


def test_no_deadline_is_met_early() -> None:
    """A sleep that ends too soon is followed by another."""
    clock = Clock(share=0.6)
    start, pace = clock.time, pacer(clock)
    for k in range(1, 1001):
        assert pace.wait(never)
        assert clock.time == start + k * PERIOD
    assert len(clock.sleeps) > 2000


def test_a_little_late_is_made_up_without_counting() -> None:
    """Half a period late the next deadline stays on the grid."""
    clock = Clock()
    start, pace = clock.time, pacer(clock)
    clock.work(3 * PERIOD // 2)
    assert pace.wait(never)
    assert clock.time == start + 3 * PERIOD // 2
    assert pace.wait(never)
    assert clock.time == start + 2 * PERIOD
    assert pace.overruns == 0


@pytest.mark.parametrize(("periods", "missed"), [(2.0, 1), (2.1, 1), (3.7, 2), (1000.5, 999)])
def test_an_overrun_is_counted_and_followed_by_no_burst(periods: float, missed: int) -> None:
    """Deadlines that passed are lost: the next one is a whole period after the late one."""
    clock = Clock()
    pace = pacer(clock)
    clock.work(round(periods * PERIOD))
    late = clock.time
    assert pace.wait(never)
    assert clock.time == late
    for k in range(1, 6):
        assert pace.wait(never)
        assert clock.time == late + k * PERIOD
    assert pace.overruns == missed


def test_a_machine_that_is_always_too_slow_does_not_spiral() -> None:
    """With 2.5 periods of work in each, every wait returns at once and counts what it missed."""
    clock = Clock()
    pace = pacer(clock)
    for _ in range(100):
        clock.work(5 * PERIOD // 2)
        before = clock.time
        assert pace.wait(never)
        assert clock.time == before
    assert clock.sleeps == []
    assert pace.overruns == 100


def test_a_request_to_stop_is_seen_during_a_long_sleep() -> None:
    """In a period of 10 s it is noticed within one piece of sleep."""
    clock = Clock()
    start, pace = clock.time, pacer(clock, 10 * NANOSECONDS)
    request = start + 3 * NANOSECONDS + 120_000_000
    assert not pace.wait(lambda: clock.time >= request)
    assert 0 <= clock.time - request <= LONGEST_SLEEP
    assert max(clock.sleeps) <= LONGEST_SLEEP <= NANOSECONDS // 5


def test_a_long_period_is_slept_through_in_pieces() -> None:
    """The pieces add up to the period exactly."""
    clock = Clock()
    assert pacer(clock, 3 * NANOSECONDS + 7).wait(never)
    assert sum(clock.sleeps) == 3 * NANOSECONDS + 7


@pytest.mark.parametrize("work", [0, 10 * PERIOD])
def test_who_is_to_stop_does_not_wait(work: int) -> None:
    """A request made before counts at once, in time or late."""
    clock = Clock()
    pace = pacer(clock)
    clock.work(work)
    assert not pace.wait(lambda: True)
    assert clock.sleeps == []


def test_a_restart_forgives_the_time_before() -> None:
    """After a pause the grid starts anew, with no overrun."""
    clock = Clock()
    pace = pacer(clock)
    assert pace.wait(never)
    clock.work(30 * NANOSECONDS)
    pace.restart()
    begin = clock.time
    assert pace.wait(never)
    assert clock.time == begin + PERIOD
    assert pace.overruns == 0
