# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A plant that was stopped itself blames neither whom it waited for nor the machine."""

import re

import pytest
from outgoing import Outgoing
from running import StartProcess, until_it_says

from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters
from rodless_sim.node.awake_clock import LOOK, STALL, AwakeClock, RunningClock, StopNews
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.pace import PaceMeter
from rodless_sim.node.pacing import Pacer

SECOND = 1_000_000_000
PERIOD = 1_000_000


def test_it_goes_with_the_clock_and_leaves_out_stops() -> None:
    """Read every 20 ms it adds up; of 12 s between two readings it counts half a second."""
    wall = 100.0
    clock = AwakeClock(lambda: wall)
    for _ in range(50):
        wall += 0.02
        last = clock()
    assert abs(last - 1.0) < 1e-9
    wall += 12.0
    assert abs(clock() - (1.0 + STALL)) < 1e-9


def test_a_plant_that_was_stopped_blames_nobody() -> None:
    """SIGSTOP for longer than time.command_timeout; a controller that is silent is still found."""
    wall, samples = 0.0, []
    engine = Engine(
        RigParameters({"time.mode": "lockstep"}), lambda seen, _: samples.append(seen.stamp)
    )
    clock = AwakeClock(lambda: wall)
    one = {b"1": "/controller"}
    plant = Lockstep(engine, 2.0, lambda: True, lambda: one, lambda: 1, Outgoing(), clock)
    plant.poll()
    wall += 12.0
    assert plant.problem is None
    plant.poll()
    assert samples == [0]
    for _ in range(120):
        wall += 0.02
        plant.poll()
    assert plant.problem is not None
    assert "/controller" in plant.problem
    assert samples == [0, 0]


class Stopwatch:
    """A running clock, and how often it has asked for the processor time."""

    def __init__(self) -> None:
        self.wall = self.used = self.looks = 0
        self.clock = RunningClock(lambda: self.wall, self._look)

    def _look(self) -> int:
        self.looks += 1
        return self.used

    def silence(self, lasted: int, used: int) -> int:
        """Read again after ``lasted`` ns, ``used`` of them by this process; return what counts."""
        before = self.clock()
        self.wall += lasted
        self.used += used
        return self.clock() - before


def test_the_processor_time_is_looked_at_ten_times_a_second() -> None:
    """However often the clock is read: that costs more than to read a clock."""
    watch = Stopwatch()
    for _ in range(1000):
        watch.silence(PERIOD, 0)
    assert watch.clock() == SECOND
    assert watch.looks == pytest.approx(1.0 / LOOK, abs=1.1)


@pytest.mark.parametrize(
    ("lasted", "share", "counts"),
    [(STALL, 0.0, True), (STALL + 1e-9, 0.0, False), (1.0, 0.5, True), (1.0, 0.49, False)],
)
def test_a_stop_is_longer_than_a_stall_and_leaves_half_the_processor_unused(
    lasted: float, share: float, counts: bool
) -> None:
    """What counts is counted to the nanosecond, and what does not leaves nothing."""
    span = round(lasted * SECOND)
    assert Stopwatch().silence(span, round(share * span)) == counts * span


class Machine:
    """A wall clock, processor time, and a plant of two threads that go by them."""

    def __init__(self) -> None:
        self.wall = self.used = 0
        self.clock = RunningClock(lambda: self.wall, lambda: self.used)
        self.news = StopNews(self.clock)
        self.pacer = Pacer(PERIOD, self.clock, self._sleep)
        self.meter = PaceMeter(1.0, PERIOD, self.clock)
        self.plant = 0

    def _sleep(self, seconds: float) -> None:
        self.wall += max(round(seconds * SECOND), 1)

    def compute(self, seconds: float) -> None:
        """Let the processor work."""
        self.wall += round(seconds * SECOND)
        self.used += round(seconds * SECOND)

    def run(self, seconds: float, work: float = 1e-4) -> None:
        """Step, each step computing for ``work`` s, and look how the pace is after each twenty."""
        end = self.wall + round(seconds * SECOND)
        while self.wall < end:
            for _ in range(20):
                self.compute(work)
                assert self.pacer.wait(lambda: False)
                self.plant += PERIOD
            self.meter.observe(self.plant, running=True)


@pytest.mark.parametrize("meter_first", [True, False])
@pytest.mark.parametrize("stop", [STALL + 2 * LOOK, 5.0, 3600.0])
def test_what_a_plant_was_stopped_for_is_neither_lag_nor_overruns(
    stop: float, meter_first: bool
) -> None:
    """Whichever thread runs first afterwards; that it was is said once, and for how long."""
    machine = Machine()
    machine.run(2.0)
    assert machine.meter.report().lag == 0.0
    assert machine.news.hear() is None
    machine.wall += round(stop * SECOND)
    if meter_first:
        machine.meter.observe(machine.plant, running=True)
    assert machine.pacer.wait(lambda: False)
    machine.plant += PERIOD
    machine.run(1.0)
    pace = machine.meter.report()
    assert machine.pacer.overruns == 0
    assert pace.lag < 0.05
    assert pace.falls_behind is False
    assert f"stood still for {stop:.2f} s" in str(machine.news.hear())
    assert machine.news.hear() is None


@pytest.mark.parametrize("work", [2 * PERIOD / SECOND, STALL + 2 * LOOK, 5.0])
def test_a_plant_that_computes_for_too_long_is_slow(work: float) -> None:
    """Steps that take longer than their period lag and overrun, also those longer than a stall."""
    machine = Machine()
    machine.run(1.0)
    machine.meter.report()
    machine.run(20.0 * work, work)
    pace = machine.meter.report()
    assert machine.news.hear() is None
    assert machine.pacer.overruns > 0
    assert pace.lag > work
    assert pace.falls_behind is True


def test_a_plant_that_is_often_held_for_less_than_a_stall_is_slow() -> None:
    """A crowded machine, which lets it run in between: that counts, and nothing was stopped."""
    machine = Machine()
    machine.run(1.0)
    machine.meter.report()
    for _ in range(10):
        machine.wall += round(0.8 * STALL * SECOND)
        machine.run(0.1)
    assert machine.pacer.overruns > 1000
    assert machine.meter.report().falls_behind is True
    assert machine.news.hear() is None


def test_a_plant_in_real_time_that_goes_on_after_a_stop_blames_no_machine(
    start_node: StartProcess, observer: Observer
) -> None:
    """SIGSTOP: it says that it was stopped, and its lag is shorter than that."""
    with start_node("plant", {"time.period": 5e-3}, namespace="stopped") as process:
        until_it_says(process, "ready: ")
        before = observer.counter("/stopped/plant", "lag (s)", fresh=True)
        process.freeze()
        with pytest.raises(TimeoutError):
            observer.wait(lambda: False, "what does not come", 8.0 * STALL)
        process.thaw()
        until_it_says(process, "that counts neither as lag nor as overruns")
        stops = re.findall(r"stood still for ([0-9.]+) s", process.output)
        lag = observer.counter("/stopped/plant", "lag (s)", fresh=True)
        assert lag - before < 0.5 * max(map(float, stops))
