# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When the time of a clock is told to go to and fro, without ROS."""

from itertools import chain

import pytest

from rodless_lab.bags.ros.clock_watch import MANY_STEPS, ClockWatch


def times(first: int, count: int) -> list[int]:
    return [1_000_000 * (first + k) for k in range(count)]


def tells(clock: list[int]) -> int:
    watch = ClockWatch()
    told = 0
    for time in clock:
        watch.take(time)
        told += watch.look()
    return told


@pytest.mark.parametrize("ahead", [2, 5000])
def test_two_plants_on_one_clock_are_told_once(ahead: int) -> None:
    """Each message of the one that is behind goes back, however little."""
    both = zip(times(1, 100), times(1 + ahead, 100), strict=True)
    assert tells(list(chain.from_iterable(both))) == 1


def test_a_plant_that_is_reset_or_started_again_is_not_told() -> None:
    """However often: its time begins at 0 again; a few that begin late are no second plant."""
    assert tells(times(0, 100) * 3 * MANY_STEPS) == 0
    assert tells(times(5, 100) * MANY_STEPS) == 0
    assert tells(times(0, 10_000)) == 0
