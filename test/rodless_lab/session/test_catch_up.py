# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How long a command of a test waits for what the rig has sent while the test computed."""

import math
import time
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from rodless_lab.session.catch_up import CATCH_UP_TIMEOUT, PAUSED_STANDSTILL, STANDSTILL, CatchUp
from rodless_lab.session.live_session import LiveSession
from rodless_lab.session.samples import Received, Stamped

MILLISECOND = 1_000_000  # ns


class Clock:
    """Wall clock and monotonic time of these tests; nothing sleeps."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0  # s
        monkeypatch.setattr(time, "monotonic", lambda: self.now)
        monkeypatch.setattr(time, "time_ns", lambda: round(self.now * 1e9))


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Time that passes where a test lets it."""
    return Clock(monkeypatch)


def put(received: Received, number: int, sent: float) -> None:
    """Take sample ``number`` of 1 ms each, ``sent`` (s) by the wall clock."""
    message = Stamped(round(sent * 1e9), number * MILLISECOND, (0.0, 0.0, 0.0))
    for topic in received.topics:
        topic.put(message)


def started(clock: Clock) -> Received:
    """A rig whose sample 0 has come long ago."""
    received = Received()
    put(received, 0, clock.now - 50.0)
    return received


def test_it_is_over_with_the_first_sample_sent_after_the_command(clock: Clock) -> None:
    """Not with the older ones that come meanwhile, however many there are."""
    received = started(clock)
    coming = CatchUp(received, paused=False)
    command = clock.now
    for number in range(1, 51):
        clock.now += 1e-3
        put(received, number, command - 51e-3 + number * 1e-3)
        assert not coming.is_over()
    put(received, 51, command + 1e-3)
    assert coming.is_over()


@pytest.mark.parametrize(("paused", "standstill"), [(False, STANDSTILL), (True, PAUSED_STANDSTILL)])
def test_a_plant_of_which_nothing_comes_stands_still(
    clock: Clock, paused: bool, standstill: float
) -> None:
    """Counted from what came last, not from the command, and from one look to the next."""
    received = started(clock)
    coming = CatchUp(received, paused)
    clock.now += 0.9 * standstill
    assert not coming.is_over()
    put(received, 1, clock.now - 60.0)
    clock.now += 5.0 * standstill  # the test is held up; what is there is looked at first
    assert not coming.is_over()
    clock.now += 0.9 * standstill
    assert not coming.is_over()
    clock.now += 0.2 * standstill
    assert coming.is_over()


def test_a_rig_that_is_far_behind_is_not_waited_for_for_ever(clock: Clock) -> None:
    """Samples come, each older than the command."""
    received = started(clock)
    coming = CatchUp(received, paused=False)
    looks = 0
    while not coming.is_over():
        looks += 1
        clock.now += 0.1
        put(received, looks, 60.0 + looks * 1e-3)
    assert looks * 0.1 == pytest.approx(CATCH_UP_TIMEOUT, abs=0.2)


class Session(LiveSession):
    """A session in lock-step whose waits ask once."""

    _mode, _duration = "lockstep", 2e-3

    def __init__(self, received: Received) -> None:
        super().__init__()
        self._received = received
        self._receiver = SimpleNamespace(take_waiting=lambda _: None)  # type: ignore[assignment]
        self.waits: list[tuple[bool, float | None]] = []

    def _wait(  # type: ignore[override]
        self,
        condition: Callable[[], bool],
        what: str,  # noqa: ARG002
        timeout: float | None = None,
        running: bool = False,  # noqa: ARG002
    ) -> None:
        self.waits.append((condition(), timeout))


def test_a_plant_whose_duration_is_over_is_not_waited_for(clock: Clock) -> None:
    """It sends nothing any more: gains that are set between two runs cost no time.

    Nor does the session's patience end the wait, for the command has taken effect.
    """
    received = started(clock)
    session = Session(received)
    session._catch_up()
    put(received, 1, clock.now - 40.0)
    session._catch_up()
    put(received, 2, clock.now - 40.0)
    session._catch_up()
    assert session.waits == [(False, math.inf), (False, math.inf), (True, math.inf)]
