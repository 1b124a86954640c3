# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Faults are counted since the start or the last reset, and told as long as they are recent."""

import pytest

from rodless_base.fault_counts import WINDOW, FaultCounts, lately_text


class Clock:
    """A clock that the test sets."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        """Return the time set, in s."""
        return self.time


@pytest.fixture
def clock() -> Clock:
    """Return a clock at 100 s."""
    return Clock()


def test_a_fault_is_recent_for_ten_seconds_and_counted_for_good(clock: Clock) -> None:
    """Updated once a second, as nodes do."""
    counts = FaultCounts(clock)
    recent = []
    for second in range(15):
        clock.time = 101.0 + second
        assert counts.update({"lost": int(second >= 2), "late": 0})["lost"] == int(second >= 2)
        recent.append(counts.lately())
    assert recent == [{}] * 2 + [{"lost": 1}] * 10 + [{}] * 3
    assert lately_text(["lost", "late"]) == "in the last 10 s: lost, late"


def test_what_happened_before_the_first_update_counts(clock: Clock) -> None:
    """A fault at start-up is not overlooked, nor one that comes right after another update."""
    counts = FaultCounts(clock)
    assert counts.update({"lost": 3}) == {"lost": 3}
    assert counts.lately() == {"lost": 3}
    clock.time += WINDOW / 2
    assert counts.update({"lost": 5}) == {"lost": 5}
    assert counts.lately() == {"lost": 5}


def test_counting_begins_anew_when_it_is_cleared(clock: Clock) -> None:
    """The totals go on growing; a counter that appears later starts at zero."""
    counts = FaultCounts(clock)
    counts.update({"lost": 3})
    counts.clear({"lost": 4})
    assert counts.update({"lost": 4}) == {"lost": 0}
    assert counts.lately() == {}
    assert counts.update({"lost": 6, "new": 1}) == {"lost": 2, "new": 1}
    assert counts.lately() == {"lost": 2, "new": 1}
