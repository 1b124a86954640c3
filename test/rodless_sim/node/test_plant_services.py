# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Pause, step and reset of a running plant."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import cast

import pytest
from outgoing import Outgoing
from rosgraph_msgs.msg import Clock
from running import StartProcess
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.observer import TIMEOUT, Observer
from rodless_sim.node.engine import Engine
from rodless_sim.node.pacing import Pacer
from rodless_sim.node.realtime import Realtime

PERIOD = 5_000_000


@pytest.fixture(scope="module", autouse=True)
def plant(start_node: StartProcess) -> Iterator[None]:
    """Run a plant that nobody commands."""
    with start_node("plant", {"time.period": PERIOD * 1e-9}):
        yield


@pytest.fixture(scope="module")
def samples(observer: Observer) -> list[JointState]:
    """Record the plant's samples; they have begun to come."""
    samples = observer.collect(JointState, "/joint_states")
    observer.more(samples, 5)
    return samples


@pytest.fixture(autouse=True)
def running(observer: Observer) -> Iterator[None]:
    """Leave the plant running, whatever a test did."""
    yield
    pause(observer, False)


def times(samples: list[JointState]) -> list[int]:
    """Return their stamps in ns."""
    return [stamp_nanoseconds(sample.header.stamp) for sample in samples]


def pause(observer: Observer, paused: bool) -> None:
    """Stop plant time, or let it run."""
    response = observer.call(SetBool, "/plant/pause", data=paused)
    assert response.success
    assert response.message == ("paused" if paused else "running")


def test_a_paused_plant_stands_still_until_it_goes_on_where_it_was(
    observer: Observer, samples: list[JointState]
) -> None:
    """No sample comes while it is paused; then they come on, without a gap in plant time."""
    observer.more(samples, 5)
    pause(observer, True)
    observer.diagnostic("/plant", fresh=True)
    count = len(samples)
    observer.diagnostic("/plant", fresh=True)
    assert len(samples) == count
    pause(observer, False)
    observer.more(samples, 20)
    around = times(samples[count - 5 : count + 20])
    assert around == list(range(around[0], around[0] + 25 * PERIOD, PERIOD))


class Steps:
    """An engine whose steps do what the test wants."""

    ended = False

    def __init__(self, step: Callable[[], None]) -> None:
        self.step = step
        self.failure: str | None = None

    def offer(self) -> None:
        """Hand out nothing."""

    def fail(self, reason: str) -> None:
        """Take note of it."""
        self.failure = reason


def test_the_answer_to_pause_comes_after_the_last_sample() -> None:
    """A step under way is handed out first: who pauses and then resets gets no late sample."""
    begun, may_end, events = threading.Event(), threading.Event(), []

    def step() -> None:
        begun.set()
        may_end.wait(TIMEOUT)
        events.append("step")

    def pause() -> None:
        realtime.pause(True)
        events.append("paused")

    realtime = Realtime(cast(Engine, Steps(step)), 1_000_000, lambda: True, Outgoing())
    assert begun.wait(TIMEOUT)
    pausing = threading.Thread(target=pause)
    pausing.start()
    pausing.join(0.2)
    may_end.set()
    pausing.join(TIMEOUT)
    realtime.close()
    assert events == ["step", "paused"]


@pytest.mark.parametrize("paused", [True, False], ids=["paused", "at its end"])
def test_nothing_is_late_while_nothing_is_due(
    monkeypatch: pytest.MonkeyPatch, *, paused: bool
) -> None:
    """No step and no overrun, on a clock whose sleeps take ten periods."""
    slept, enough, ready, steps = list[float](), threading.Event(), threading.Event(), list[int]()

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 200:
            enough.set()

    monkeypatch.setattr(
        "rodless_sim.node.realtime.Pacer",
        lambda period, _: Pacer(period, lambda: 10 * period * len(slept), sleep),
    )
    engine = Steps(lambda: steps.append(0))
    engine.ended = not paused
    realtime = Realtime(cast(Engine, engine), 1_000_000, ready.is_set, Outgoing())
    realtime.pause(paused)
    ready.set()
    assert enough.wait(TIMEOUT)
    realtime.close()
    assert steps == []
    assert realtime.overruns == 0


def test_a_plant_whose_step_breaks_off_fails_until_a_reset() -> None:
    """The valve closes at once, the node is told where it looks, and the thread goes on."""
    steps: list[str | None] = []
    again = threading.Event()

    def step() -> None:
        steps.append(engine.failure)
        if len(steps) == 1:
            raise ArithmeticError("of the test's own")
        again.set()

    engine = Steps(step)
    realtime = Realtime(cast(Engine, engine), 1_000_000, lambda: True, Outgoing())
    assert again.wait(TIMEOUT)
    with pytest.raises(ArithmeticError, match="of the test's own"):
        realtime.poll()
    realtime.poll()
    realtime.close()
    assert steps[0] is None
    assert steps[1] is not None
    assert steps[1].startswith("ArithmeticError: of the test's own (test_plant_services.py, line")


def test_a_reset_forgets_a_step_that_broke_off_before_it() -> None:
    """The node has not looked yet: it would stop the new run for what the old one had."""
    again = threading.Event()

    def step() -> None:
        if engine.failure is not None:
            again.set()
            return
        raise ArithmeticError("of the run before")

    engine = Steps(step)
    engine.reset = lambda: None  # type: ignore[attr-defined]
    realtime = Realtime(cast(Engine, engine), 1_000_000, lambda: True, Outgoing())
    assert again.wait(TIMEOUT)
    realtime.close()
    realtime.reset()
    realtime.poll()


def test_a_step_is_one_period(observer: Observer, samples: list[JointState]) -> None:
    """Each ~/step of a paused plant gives one sample, a period later, and its clock."""
    clocks = observer.collect(Clock, "/clock")
    observer.more(clocks, 1)
    pause(observer, True)
    assert observer.call(Trigger, "/plant/reset").success
    observer.wait(lambda: times(samples)[-1] == 0, "sample 0")
    start = len(samples)
    for count in range(1, 6):
        assert observer.call(Trigger, "/plant/step").success
        observer.wait(lambda count=count: len(samples) == start + count, "the sample of the step")
    assert times(samples[start:]) == [PERIOD * count for count in range(1, 6)]
    observer.wait(lambda: stamp_nanoseconds(clocks[-1].clock) == 5 * PERIOD, "its clock")


def test_a_step_of_a_running_plant_is_refused(observer: Observer) -> None:
    """It says what to do first."""
    response = observer.call(Trigger, "/plant/step")
    assert not response.success
    assert response.message == "pause the plant first"


@pytest.mark.parametrize("paused", [False, True])
def test_a_reset_begins_plant_time_anew(
    observer: Observer, samples: list[JointState], paused: bool
) -> None:
    """Sample 0 follows; then time goes on from there if it ran before, else it stands."""
    observer.more(samples, 5)
    pause(observer, paused)
    start = len(samples)
    assert observer.call(Trigger, "/plant/reset").success
    observer.wait(lambda: 0 in times(samples[start:]), "sample 0")
    first = start + times(samples[start:]).index(0)
    if paused:
        observer.diagnostic("/plant", fresh=True)
        assert times(samples[first:]) == [0]
        pause(observer, False)
    observer.wait(lambda: len(samples) >= first + 20, "samples after the reset")
    assert times(samples[first : first + 20]) == list(range(0, 20 * PERIOD, PERIOD))


def test_a_plant_that_waits_for_its_recorders_takes_no_step() -> None:
    """They would not have its first samples; paused meanwhile, it says what it waits for."""
    ready = threading.Event()
    realtime = Realtime(cast(Engine, Steps(lambda: None)), 1_000_000, ready.is_set, Outgoing())
    realtime.pause(True)
    assert realtime.step() == "waiting for subscribers"
    ready.set()
    deadline = time.monotonic() + TIMEOUT
    while (said := realtime.step()) is not None:
        assert said == "waiting for subscribers"
        assert time.monotonic() < deadline
    realtime.close()
