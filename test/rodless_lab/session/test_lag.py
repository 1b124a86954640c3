# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session that falls behind what its rig sends says so; one that catches up does not."""

import warnings
from collections.abc import Callable

import pytest

from rodless_lab.session import lag as module
from rodless_lab.session.lag import LagWarning, LagWatch


class Clocks:
    """Wall clock and monotonic clock of one time."""

    now = 1000.0

    def time_ns(self) -> int:
        """As in the standard library."""
        return round(self.now * 1e9)

    def monotonic(self) -> float:
        """As in the standard library."""
        return self.now


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    """The clocks that the watch sees."""
    found = Clocks()
    monkeypatch.setattr(module, "time", found)
    return found


def told(clocks: Clocks, lag: Callable[[float], float], duration: float = 5.0) -> list[float]:
    """Wait for that long (s), samples being ``lag`` (s) late; return when a warning came."""
    watch, begun, found = LagWatch(), clocks.now, []
    watch.begin()
    while (since := clocks.now - begun) < duration:
        clocks.now += 0.01
        watch.take(round((clocks.now - lag(since)) * 1e9))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            watch.check()
        found += [since for one in caught if one.category is LagWarning]
    return found


def test_who_falls_behind_is_told_once(clocks: Clocks) -> None:
    """It is 1 s behind after 2 s, and still is a second later."""
    assert told(clocks, lambda since: 0.5 * since) == [pytest.approx(3.0, abs=0.05)]


def test_many_short_waits_count_as_one(clocks: Clocks) -> None:
    """A test that computes for longer between two waits than it waits falls behind as well."""
    watch = LagWatch()
    for turn in range(200):
        clocks.now += 0.02
        watch.begin()
        clocks.now += 0.01
        watch.take(round((clocks.now - 0.02 * turn) * 1e9))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            watch.check()
        if caught:
            break
    # Behind by 1 s from turn 50 on, and 100 waits of 10 ms later.
    assert turn == pytest.approx(150, abs=3)


def test_who_has_been_further_behind_is_told_as_well(clocks: Clocks) -> None:
    """2.5 s at first and 2.4 s from then on: that is no catching up."""
    assert told(clocks, lambda since: 2.5 if since < 0.5 else 2.4) == [pytest.approx(2.0, abs=0.1)]


@pytest.mark.parametrize(
    "lag", [lambda _: 0.9, lambda since: 4.0 - since, lambda since: 2.0 if since < 0.5 else 0.1]
)
def test_who_keeps_up_or_catches_up_is_not(clocks: Clocks, lag: Callable[[float], float]) -> None:
    """After a while of computing a test has a backlog, which its next wait works off."""
    assert told(clocks, lag) == []


def test_an_old_sample_alone_is_no_lag(clocks: Clocks) -> None:
    """The plant is paused or frozen: what the session knows is as old, and as new as can be."""
    watch = LagWatch()
    watch.begin()
    clocks.now += 2.0
    watch.take(round((clocks.now - 2.0) * 1e9))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(1000):
            watch.check()
            clocks.now += 0.01


def test_the_warning_names_the_way_out(clocks: Clocks) -> None:
    """One line."""
    watch = LagWatch()
    watch.begin()
    for _ in range(200):
        clocks.now += 0.01
        watch.take(round((clocks.now - 3.0) * 1e9))
    with pytest.warns(
        LagWarning, match=r"^this session is 3\.0 s behind its rig.*mode='lockstep'$"
    ):
        watch.check()
