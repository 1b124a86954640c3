# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A controller that stood still for seconds answers by where the carriage is, not where it was.

Its queues are full of old samples then. Answered one by one, they threw the valve open to either
side for a tenth of a second and more, and the carriage swung past its target by centimetres. Time
is simulated here; test_faults.py freezes the node itself.
"""

from collections.abc import Iterator
from typing import NamedTuple

import pytest
from rclpy.parameter import Parameter

from rodless_base.measurement import Measurement
from rodless_base.ros.cdr import unpack_float64
from rodless_control import Pid, PidParameters, ReferencePoint
from rodless_control.node.controller_node import ControllerNode
from rodless_control.node.position_watch import WATCH_PERIOD, PositionWatch
from rodless_control.node.stalls import LONGEST, STALL, YOUNG, Stalls
from rodless_lab.session.observer import Observer

INTERVAL = 1e-3


class Clock:
    """A steady time that the test sets."""

    def __init__(self) -> None:
        self.now = 50.0

    def __call__(self) -> float:
        """Return it."""
        return self.now


class Taken(NamedTuple):
    """A sample as the controller came to it."""

    sent: float  # s of the steady clock
    at: float
    passed: bool


def stream(stall: float, step: float = 0.0, interval: float = INTERVAL) -> list[Taken]:
    """Let samples come for ten seconds, of which the controller stands still for ``stall`` (s).

    The sender's clock is an hour ahead, and set by ``step`` (s) during the stall.
    """
    clock = Clock()
    stalls = Stalls(lambda: interval, clock)
    began, taken = clock.now, list[Taken]()
    stands = began + 5.0
    for k in range(round(10.0 / interval)):
        sent = began + k * interval
        while clock.now + WATCH_PERIOD < sent:
            clock.now += WATCH_PERIOD
            stalls.poll()
        clock.now = max(clock.now + 50e-6, sent + 200e-6)
        if stands <= clock.now < stands + stall:
            clock.now = stands + stall
        told = sent + 3600.0 + (step if sent > stands + stall / 2.0 else 0.0)
        taken.append(Taken(sent, clock.now, stalls.was_passed(told)))
    return taken


@pytest.mark.parametrize("stall", [0.15, 3.0])
@pytest.mark.parametrize("interval", [1e-3, 1e-2])
def test_of_what_waited_the_newest_samples_alone_are_answered(
    stall: float, interval: float
) -> None:
    """By the other machine's clock, whatever that shows; before and later every sample is."""
    taken = stream(stall, interval=interval)
    end = 55.0 + stall
    for one in taken:
        waited = one.at >= 55.0 and one.sent < end - max(interval, YOUNG) - 1e-3
        fresh = one.at < 55.0 or one.sent >= end - YOUNG
        assert one.passed or not waited
        assert not (one.passed and fresh)
    assert sum(one.passed for one in taken) == pytest.approx((stall - YOUNG) / interval, abs=3.0)


def test_a_pause_too_short_for_a_stall_passes_nothing() -> None:
    """A busy machine stops its processes for some hundredths of a second all the time."""
    assert not any(one.passed for one in stream(0.9 * STALL))


def test_a_clock_that_is_set_back_in_a_stall_silences_no_controller() -> None:
    """All samples seem to be an hour old then: for two seconds, and no longer."""
    passed = [one for one in stream(1.0, step=-3600.0) if one.passed]
    assert max(one.at for one in passed) <= 55.0 + 1.0 + LONGEST


class Bench:
    """A controller in this process that nothing spins, and what it sends at a time of the test."""

    def __init__(self, controller: ControllerNode, in_lockstep: bool) -> None:
        self.controller = controller
        self.answers = controller._answers
        self.clock = Clock()
        self.answers._stalls = Stalls(lambda: INTERVAL, self.clock)
        self.voltages: list[float] = []
        self.answers._outbox.send = lambda _to, data: self.voltages.append(unpack_float64(data))
        self.in_lockstep = in_lockstep
        self.answers._plant_waits = lambda: in_lockstep

    def take(self, k: int, position: float, began: int = 0) -> None:
        """Give the sample of ``k`` ms, which was sent then, in a run that ``began`` then."""
        sent = 1000 * 10**9 + k * 10**6
        info = {"source_timestamp": sent, "received_timestamp": 0}
        self.answers.take(Measurement((k - began) * 10**6, position), info)

    def run(self, first: int, last: int) -> None:
        """Give samples as they come, of a carriage that moves at 0.1 m/s."""
        for k in range(first, last):
            self.clock.now = 50.0 + k * 1e-3
            self.take(k, 1e-4 * k)

    def stall(self) -> int:
        """Give samples for 0.3 s, and stand still for two; return how many were answered."""
        self.run(0, 300)
        self.clock.now += 2.0
        return len(self.voltages)

    def news(self) -> str | None:
        """Return what the node has to say of samples skipped."""
        return self.answers.pace.news("law Pid")


@pytest.fixture(params=[False, True], ids=["realtime", "lockstep"])
def bench(observer: Observer, request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return a controller with the PID, which has a set-point of 0.1 m."""
    controller = ControllerNode(
        context=observer.context,
        namespace="/standing",
        parameter_overrides=[Parameter("controller.feedforward", value=0.0)],
    )
    controller._loop.setpoints.receive(0.1)
    yield Bench(controller, request.param)
    controller.node.destroy_node()


@pytest.mark.ros
def test_the_first_answer_after_a_stall_is_that_of_a_law_that_saw_a_gap(bench: Bench) -> None:
    """Two seconds' worth of samples get none in real time; in lock-step none is left out."""
    before = bench.stall()
    for k in range(300, 2279):
        bench.take(k, 0.03)
    bench.take(2300, 0.0999)
    if bench.in_lockstep:
        assert len(bench.voltages) == before + 1980
        return
    assert len(bench.voltages) == before + 1
    law = Pid(PidParameters().with_values({"controller.feedforward": 0.0}))
    for k in range(300):
        # The set-point comes with the second sample.
        law.update(Measurement(k * 10**6, 1e-4 * k), ReferencePoint(0.1, 0.0), INTERVAL * (k > 0))
    law.hold()
    expected = law.update(Measurement(2300 * 10**6, 0.0999), ReferencePoint(0.1, 0.0), 2.001)
    assert 5.08 < expected[0] < 10.0
    assert bench.voltages[-1] == pytest.approx(expected[0], abs=1e-9)
    news = bench.news()
    assert news is not None
    assert news.startswith("the controller stood still for 2.0")


@pytest.mark.ros
def test_what_samples_are_apart_is_told_by_those_left_out_too(bench: Bench) -> None:
    """A law of half a second stands still for each sample that it answers, and passes all others.

    By those alone the samples would seem to be half a second apart: that was said, and one as old
    was answered, as one that has hardly waited.
    """
    bench.take(0, 0.05)
    for began in range(20, 10_000, 500):
        bench.clock.now += 0.5
        for k in range(began, began + 500, 20):
            bench.take(k, 0.05)
    assert bench.answers.pace.interval == pytest.approx(0.02)


@pytest.mark.ros
def test_a_sample_that_nothing_follows_is_answered_all_the_same(bench: Bench) -> None:
    """Its sender may wait for that, or be paused: one poll later there is no newer one."""
    before = bench.stall()
    bench.take(300, 0.05)
    bench.answers.poll()
    bench.answers.poll()
    assert len(bench.voltages) == before + 1
    assert bench.answers.pace.skipped == 0
    bench.answers.poll()
    assert len(bench.voltages) == before + 1


@pytest.mark.ros
@pytest.mark.parametrize("comes", [True, False])
def test_of_a_sender_that_sends_on_no_old_sample_is_answered(bench: Bench, comes: bool) -> None:
    """The middleware was stopped too: it may bring some old samples, and the others much later.

    Half a second later here. Where none comes any more, the last one is answered in the end.
    """
    before = bench.stall()
    for k in range(300, 304):
        bench.take(k, 0.0)
    for _ in range(25):
        bench.clock.now += WATCH_PERIOD
        bench.answers.poll()
    if bench.in_lockstep:
        assert len(bench.voltages) == before + 4
        return
    assert len(bench.voltages) == before
    if comes:
        bench.take(2800, 0.0999)
    else:
        for _ in range(round(LONGEST / WATCH_PERIOD)):
            bench.clock.now += WATCH_PERIOD
            bench.answers.poll()
    assert len(bench.voltages) == before + 1
    assert bench.answers.pace.skipped == (4 if comes else 3)


@pytest.mark.ros
@pytest.mark.parametrize("polls", [1, 2, 5])
def test_old_samples_that_trickle_in_keep_no_valve_open(bench: Bench, polls: int) -> None:
    """Each counted as a position: the valve stood as before the stall for up to two seconds.

    Those two ``polls`` and more apart were answered besides, one by one, as if each were the last.
    """
    before = bench.stall()
    watchdog = bench.controller._watchdog
    watchdog._watch = PositionWatch(lambda: round(bench.clock.now * 1e9))
    watchdog.begin()
    watchdog.poll()
    count = 60 // polls
    for k in range(300, 300 + count):
        bench.take(k, 0.05)
        for _ in range(polls):
            bench.clock.now += WATCH_PERIOD
            bench.answers.poll()
            watchdog.poll()
    if bench.in_lockstep:
        assert len(bench.voltages) == before + count
        assert watchdog.problem is None
        return
    closed = bench.controller._number("controller.neutral_voltage")
    assert bench.voltages[-1] == closed
    assert sum(voltage != closed for voltage in bench.voltages[before:]) == (polls > 1)
    assert watchdog.problem == "no position: valve closed"
    bench.take(2800, 0.0999)
    watchdog.poll()
    assert bench.answers.by_law
    assert watchdog.problem is None


@pytest.mark.ros
def test_a_sample_that_waits_is_answered_after_a_reset_too(bench: Bench) -> None:
    """Its sender, which waits for that, would stand for good."""
    before = bench.stall()
    bench.take(300, 0.05)
    bench.answers.reset()
    bench.answers.poll()
    bench.answers.poll()
    assert len(bench.voltages) == before + 1


@pytest.mark.ros
def test_a_reset_of_the_plant_is_noticed_where_the_law_is_too_slow(bench: Bench) -> None:
    """The sample that it answers next may have a later stamp than the last of a short run."""
    bench.run(0, 50)
    bench.answers.pace.must_skip = lambda *_: True  # type: ignore[method-assign]
    before = len(bench.voltages)
    for k in range(50, 150):
        bench.take(k, 0.0, began=50)
    left_out = 0 if bench.in_lockstep else 100
    assert len(bench.voltages) == before + 100 - left_out
    assert bench.controller._loop.restarts == 1


@pytest.mark.ros
def test_a_reset_of_the_plant_in_a_stall_is_noticed(bench: Bench) -> None:
    """Later stamps than the last before the stall do not tell of it; those left out do."""
    bench.stall()
    for k in range(300, 2300):
        bench.take(k, 0.0, began=500 if k >= 500 else 0)
    assert bench.controller._loop.restarts == 1
