# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A dead plant is told from one that is paused, slow, or waits for a command."""

from types import SimpleNamespace
from typing import cast

import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node

from rodless_control.loop import ControlLoop
from rodless_control.node.position_watch import (
    REPORT_TIMEOUT,
    STALL,
    WATCH_PERIOD,
    PlantReport,
    PositionWatch,
    plant_report,
)
from rodless_control.node.watchdog import Watchdog

TIMEOUT = 0.1
RUNNING = PlantReport("realtime", "paper", 1000.0)
PAUSED = PlantReport("realtime", "paper", 0.0)
LOCKSTEP = PlantReport("lockstep", "paper", 0.0)


class Bench:
    """A watch that is polled as the node polls it, on a clock of the test's own."""

    def __init__(self) -> None:
        self.time = 0
        self.watch = PositionWatch(lambda: self.time)

    def silence(self, limit: float, simulated: bool = True, every: float = 0.0) -> float:
        """Poll for up to ``limit`` s without a position; return when it was missed (inf: never).

        With ``every``, the plant repeats its report as often.
        """
        start, reported = self.time, self.time
        while self.time < start + limit * 1e9:
            self.time += round(WATCH_PERIOD * 1e9)
            if every and self.time >= reported + every * 1e9:
                assert self.watch.report is not None
                self.watch.hear(self.watch.report)
                reported = self.time
            self.watch.poll()
            if self.watch.missing(TIMEOUT, simulated):
                return (self.time - start) * 1e-9
        return float("inf")


def soon(limit: float) -> object:
    """Match a time just after ``limit``."""
    return pytest.approx(limit + WATCH_PERIOD, abs=1.01 * WATCH_PERIOD)


def test_a_real_rig_is_lost_after_the_timeout() -> None:
    """It reports nothing of itself: silence is all there is."""
    assert Bench().silence(10.0, simulated=False) == soon(TIMEOUT)


def test_a_simulated_plant_that_has_said_nothing_yet_is_waited_for_like_a_report() -> None:
    """It may be paused since before the controller started."""
    assert Bench().silence(10.0, simulated=True) == soon(REPORT_TIMEOUT)


@pytest.mark.parametrize("simulated", [False, True])
def test_a_plant_that_said_it_runs_is_lost_however_the_controller_was_started(
    simulated: bool,
) -> None:
    """With use_sim_time or without; its last reports do not help it."""
    bench = Bench()
    bench.watch.hear(RUNNING)
    assert bench.silence(10.0, simulated) == soon(STALL)


@pytest.mark.parametrize("report", [PAUSED, LOCKSTEP])
def test_a_plant_that_stands_still_is_lost_only_once_it_is_silent(report: PlantReport) -> None:
    """As long as it reports once a second, nothing is missing; then three reports have to fail."""
    bench = Bench()
    bench.watch.hear(report)
    assert bench.silence(60.0, every=1.0) == float("inf")
    bench.watch.hear(report)
    assert bench.silence(60.0) == soon(REPORT_TIMEOUT)


def test_a_slow_plant_is_waited_for_as_its_samples_are_due() -> None:
    """At one sample in two seconds, six must pass in silence."""
    bench = Bench()
    bench.watch.hear(PlantReport("realtime", "paper", 0.5))
    assert bench.silence(60.0, every=1.0) == soon(6.0)


def test_a_plant_that_goes_on_is_given_its_time() -> None:
    """The report that it runs may come before its first sample: the pause is no silence."""
    bench = Bench()
    bench.watch.hear(PAUSED)
    assert bench.silence(20.0, every=1.0) == float("inf")
    bench.watch.hear(RUNNING)
    assert bench.silence(10.0, every=1.0) == soon(STALL)


def test_positions_keep_it_content() -> None:
    """Each begins the silence anew."""
    bench = Bench()
    bench.watch.hear(RUNNING)
    for _ in range(100):
        assert bench.silence(0.9 * STALL) == float("inf")
        bench.watch.arrive()


def test_the_report_of_a_plant_that_is_gone_says_nothing_of_another_rig() -> None:
    """Positions that come on without reports are a real rig's: lost after the timeout, not before.

    One report that is late says nothing yet.
    """
    bench = Bench()
    bench.watch.hear(LOCKSTEP)
    for _ in range(round(3.0 / TIMEOUT)):
        assert bench.silence(0.9 * TIMEOUT, simulated=False) == float("inf")
        bench.watch.arrive()
    assert bench.watch.report == LOCKSTEP
    bench.silence(2.0, simulated=False)
    bench.watch.arrive()
    assert bench.watch.report is None
    assert bench.silence(10.0, simulated=False) == soon(TIMEOUT)


def test_a_controller_that_was_stopped_itself_blames_nobody() -> None:
    """Ten seconds between two polls are its own: what came meanwhile still waits in its queues."""
    bench = Bench()
    bench.watch.hear(RUNNING)
    bench.time += 10_000_000_000
    bench.watch.poll()
    assert not bench.watch.missing(TIMEOUT, simulated=True)


def test_a_timeout_of_zero_is_never() -> None:
    """As the parameter says."""
    watch = Bench().watch
    watch.hear(RUNNING)
    watch._positions_silent = 1e9
    assert not watch.missing(0.0, simulated=False)


def status(name: str, **values: str) -> DiagnosticStatus:
    """Return a status with these values."""
    pairs = [KeyValue(key=key.replace("_", " "), value=value) for key, value in values.items()]
    return DiagnosticStatus(name=name, values=pairs)


def test_only_the_plant_of_its_own_namespace_is_heard() -> None:
    """Whatever its name; a neighbour, a camera and the controller itself are not."""
    rate = KeyValue(key="Target frequency (Hz)", value="200")
    ours = status("/left/cyl1", mode="realtime", preset="paper")
    ours.values.append(rate)
    assert plant_report(ours, "/left") == PlantReport("realtime", "paper", 200.0)
    assert plant_report(ours, "/") is None
    assert plant_report(ours, "/left/cyl1") is None
    ours.name = "/plant"
    assert plant_report(ours, "/") == PlantReport("realtime", "paper", 200.0)
    for other in (status("/controller", positions_lost="0"), status("/camera", mode="auto")):
        assert plant_report(other, "/") is None
    odd = status("/camera", mode="auto")
    odd.values.append(KeyValue(key="Target frequency (Hz)", value="high"))
    assert plant_report(odd, "/") is None


@pytest.mark.parametrize(
    ("report", "words"),
    [
        (
            PlantReport("realtime", "calibrated", 1000.0),
            "realtime, plant's preset calibrated, 1000 Hz",
        ),
        (PlantReport("lockstep", "", 0.0), "lockstep"),
    ],
)
def test_the_preset_it_tells_of_is_the_plants(report: PlantReport, words: str) -> None:
    """A controller on gains of its own does not claim the preset that only the plant has."""
    assert report.text() == words


class Watched:
    """The watchdog of a controller, polled as its node does, and when it commanded unprompted."""

    def __init__(self, simulated: bool, timeout: float = TIMEOUT) -> None:
        self.time = 0
        self.commands: list[float] = []  # s
        node = SimpleNamespace(
            create_subscription=lambda *_: None,
            get_parameter=lambda _: SimpleNamespace(value=simulated),
            get_logger=lambda: SimpleNamespace(info=str, warning=str),
        )
        loop = SimpleNamespace(law=SimpleNamespace(USES_PRESSURES=False), lost=0)
        self.dog = Watchdog(
            cast(Node, node),
            cast(ControlLoop, loop),
            lambda: timeout,
            lambda: self.commands.append(self.time * 1e-9),
            lambda: None,
        )
        self.watch = self.dog._watch = PositionWatch(lambda: self.time)

    def poll(self, seconds: float) -> None:
        """Poll for so long."""
        until = self.time + round(seconds * 1e9)
        while self.time < until:
            self.time += round(WATCH_PERIOD * 1e9)
            self.dog.poll()


def test_a_plant_that_begins_is_sent_no_command_before_its_first_position() -> None:
    """A lock-step plant would take one for the answer to that; a real one is given its timeout.

    What is said is what has been done.
    """
    rig = Watched(simulated=False)
    assert rig.dog.problem == "no position: valve not commanded"
    rig.poll(1.0)
    assert rig.commands, "the valve of who listens already is closed"
    assert rig.dog.problem == "no position: valve closed"
    rig.commands.clear()
    rig.dog.begin()
    rig.poll(0.8 * TIMEOUT)
    assert rig.commands == []
    rig.poll(1.0)
    assert rig.commands[0] == soon(1.0 + TIMEOUT)
    rig.commands.clear()
    rig.watch.hear(LOCKSTEP)
    rig.poll(10.0)
    assert rig.commands == []


@pytest.mark.parametrize(("timeout", "closed"), [(60.0, STALL), (0.2, 0.2), (0.0, None)])
def test_the_valve_of_a_real_rig_is_closed_soon_after_a_start(
    timeout: float, closed: float | None
) -> None:
    """However long its timeout: in mid-motion it may stand as a dead controller has left it."""
    rig = Watched(simulated=False, timeout=timeout)
    rig.dog.begin()
    rig.poll(2.0)
    assert rig.commands[:1] == ([] if closed is None else [soon(closed)])
    said = "not commanded" if closed is None else "closed"
    assert rig.dog.problem == f"no position: valve {said}"


@pytest.mark.parametrize("simulated", [True, False])
def test_where_a_simulated_plant_has_gone_the_next_is_sent_no_command(simulated: bool) -> None:
    """It may count commands. A real rig, which reports nothing, is sent them for as long."""
    rig = Watched(simulated)
    rig.watch.hear(RUNNING)
    rig.dog.arrive()
    rig.poll(10.0)
    assert rig.commands[0] == soon(STALL)
    end = REPORT_TIMEOUT if simulated else 10.0
    assert rig.commands[-1] == pytest.approx(end, abs=2.0 * WATCH_PERIOD)
    assert rig.dog.problem == "no position: valve closed"
    rig.commands.clear()
    rig.watch.hear(RUNNING)
    rig.poll(WATCH_PERIOD)
    assert rig.commands, "it was there all the time, and is lost still"
