# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a session promises of a healthy rig: start, time, parameters, set-points, samples."""

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from extent import also, extensive
from running import StartSession
from std_srvs.srv import Trigger

from rodless_control import PidParameters, references
from rodless_lab import closed_loop, read_run
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.reader import read_bag
from rodless_lab.harness import (
    HarnessError,
    Mode,
    NodeDiedError,
    PatienceError,
    RefusedError,
    RigSession,
    Sample,
    WaitTimeoutError,
)
from rodless_lab.session.processes import node_command
from rodless_sim import RigParameters, simulate

pytestmark = pytest.mark.usefixtures("compiled")

LAW_WITH_A_TERM = """
from typing import NamedTuple

from rodless_control import Law


class Command(NamedTuple):
    voltage: float
    doubled: float


class Doubling(Law):
    TERMS = ("doubled",)

    def update(self, measurement, reference, interval):
        voltage = 5.08 + 20.0 * (reference.position - measurement.position)
        return Command(voltage, 2.0 * voltage)
"""

STEP = {"reference.type": "step", "reference.at": 0.05, "reference.target": 0.058}
FIELDS = ("position", "velocity", "force", "pressure_a", "pressure_b", "voltage")


@pytest.mark.parametrize("one_process", [False, True], ids=["two processes", "one process"])
def test_a_lockstep_run_is_complete_and_equals_the_closed_loop(one_process: bool) -> None:
    """Samples 0 to N and all commands come; each number is that of the loop without ROS."""
    with RigSession(
        "lockstep", duration=0.5, controller=STEP, one_process=one_process, telemetry=True
    ) as rig:
        run = rig.run()
    expected = closed_loop(
        RigParameters.preset("paper"),
        PidParameters.preset("paper"),
        references.step(0.0, 0.058, at=0.05),
        duration=0.5,
        period=1e-3,
    )
    assert np.array_equal(np.rint(run.time * 1e9), np.arange(501) * 1_000_000)
    for name in (*FIELDS, "reference", "error"):
        assert np.array_equal(getattr(run, name), getattr(expected, name)), name
    assert np.all(run.supply_pressure == 0.52e6 + 101325.0)
    assert np.all(np.isfinite([run.p, run.i, run.d, run.feedforward]))
    assert set(rig.exit_codes.values()) == {0}


def test_telemetry_is_that_of_the_law_in_force(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law of the user's own: its terms and the reference come; the PID's columns are NaN."""
    (tmp_path / "law_with_a_term.py").write_text(LAW_WITH_A_TERM, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with RigSession(
        "lockstep",
        duration=0.1,
        telemetry=True,
        controller={**STEP, "controller.law": "law_with_a_term:Doubling"},
        environment={"PYTHONPATH": str(tmp_path)},
    ) as rig:
        run = rig.run()
    assert np.array_equal(run.reference, np.where(run.time < 0.05, 0.0, 0.058))
    assert list(run.terms) == ["doubled"]
    assert np.array_equal(run.terms["doubled"], 2.0 * run.voltage)
    assert np.all(np.isnan([run.error, run.p, run.i, run.d, run.feedforward]))


@extensive
def test_a_topic_that_does_not_come_is_named() -> None:
    """A controller that publishes one term elsewhere: the wait says which topic is missing."""
    elsewhere = [*node_command("controller"), "-r", "/controller/error:=/elsewhere"]
    rig = RigSession(telemetry=True, controller=elsewhere, timeout=20.0)
    with pytest.raises(WaitTimeoutError, match="waiting for a publisher of controller/error"):
        rig.__enter__()


def test_a_realtime_run_follows_a_setpoint(rig_session: StartSession) -> None:
    """The carriage goes where the test sends it; samples are one period apart from zero on."""
    rig = rig_session(plant={"time.period": 5e-3})
    rig.setpoint(0.01)
    rig.run_until(lambda sample: abs(sample.position - 0.01) < 5e-4, "the carriage at 10 mm")
    run = rig.samples()
    assert run.time == pytest.approx(np.arange(len(run)) * 5e-3)
    assert np.isfinite(run.voltage[:-1]).mean() > 0.5
    assert np.all(np.isnan(run.p)), "telemetry was not asked for"


def test_the_test_itself_can_be_the_controller(rig_session: StartSession) -> None:
    """In lock-step a law in the test answers each sample once, as an open-loop run would be."""
    rig = rig_session("lockstep", controller=None, duration=0.1)
    seen: list[Sample] = []

    def law(sample: Sample) -> float:
        seen.append(sample)
        return 5.6 if sample.time < 0.05 else 4.5

    rig.drive(law)
    run = rig.run()
    assert [sample.time for sample in seen] == pytest.approx(run.time[:-1])
    voltages = [5.6 if t < 0.05 else 4.5 for t in run.time[:-1]]
    expected = simulate(RigParameters.preset("paper"), voltages, 1e-3)
    assert np.array_equal(run.position, expected.position)
    assert np.array_equal(run.pressure_a, expected.pressure_a)


def test_a_lockstep_plant_that_the_test_answers_stands_where_the_test_stops(
    rig_session: StartSession,
) -> None:
    """After run_until nothing moves until the test goes on; a change acts from that sample on."""
    rig = rig_session("lockstep", controller=None)
    rig.drive(5.6)
    assert rig.run_until(0.02).time == pytest.approx(0.02)
    rig.set_parameters("plant", {"supply.pressure": 0.5e6})
    assert rig.latest.time == pytest.approx(0.02)
    assert rig.run_for(0.01).time == pytest.approx(0.03)
    run = rig.samples()
    changed = run.time[run.supply_pressure == 0.5e6]
    assert changed[0] == pytest.approx(0.021)
    assert len(changed) == 10


def test_single_commands_and_commands_that_are_no_numbers(rig_session: StartSession) -> None:
    """Each voltage sent is one period of a lock-step plant; NaN closes the valve and counts."""
    rig = rig_session("lockstep", controller=None)
    for voltage in (5.6, math.nan, 4.4):
        start = rig.latest.time
        rig.send_voltage(voltage)
        rig.run_until(start + 1e-3)
    rig.wait_until(lambda: rig.counter("plant", "commands received") == 3, "three commands")
    assert rig.counter("plant", "commands not finite") == 1
    with pytest.raises(HarnessError, match=r"^plant counts no 'commands not finit'; did you mean"):
        rig.counter("plant", "commands not finit")
    with pytest.raises(HarnessError, match=r"^plant: preset is '.*', no number"):
        rig.counter("plant", "preset")
    assert len(rig.samples()) == 4
    expected = simulate(RigParameters.preset("paper"), [5.6, 5.08, 4.4], 1e-3)
    assert np.array_equal(rig.samples().pressure_a, expected.pressure_a)


def test_no_voltage_is_sent_in_real_time_once_none_can_act(rig_session: StartSession) -> None:
    """Also by a test that never waits: the run is over, or the test has killed the plant."""
    rig = rig_session(controller=None, duration=0.05)

    def send_until_refused() -> None:
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            rig.send_voltage(5.08)

    with pytest.raises(HarnessError, match=r"and the run is over: the session's duration is 0\.05"):
        send_until_refused()
    rig.reset()
    rig.send_voltage(5.08)
    rig.kill("plant")
    with pytest.raises(HarnessError, match="no sample will come: the plant was ended by the test"):
        rig.send_voltage(5.08)


def test_pause_step_and_resume(rig_session: StartSession) -> None:
    """A session may start paused at sample 0; each step is one sample; resuming runs on."""
    rig = rig_session("lockstep", paused=True, controller=STEP)
    assert rig.latest.time == 0.0
    assert rig.step(3).time == pytest.approx(3e-3)
    assert len(rig.samples()) == 4
    rig.resume()
    assert rig.run_until(0.05).time == pytest.approx(0.05)
    with pytest.raises(RefusedError, match="pause"):
        rig.step()


def test_a_paused_plant_steps_in_real_time_too(rig_session: StartSession) -> None:
    """Without lock-step a step is a period as well, and time stands still between two."""
    rig = rig_session(paused=True)
    assert rig.step(2).time == pytest.approx(2e-3)
    assert len(rig.samples()) == 3


@pytest.mark.parametrize("mode", ["realtime", "lockstep"])
def test_a_run_that_is_over_takes_no_step(rig_session: StartSession, mode: str) -> None:
    """It says so at once, and the plant stands where it ended; after a reset it steps again."""
    rig = rig_session(mode, duration=0.05)
    rig.run()
    rig.pause()
    with pytest.raises(HarnessError, match=r"^a step has not come, and the run is over: the"):
        rig.step()
    asked = rig.observer.call_once(Trigger, "plant/step")
    assert (asked.success, asked.message) == (False, "time.duration is over; ~/reset begins anew")
    assert rig.latest.time == pytest.approx(0.05)
    rig.reset()
    assert rig.step().time == pytest.approx(1e-3)


@pytest.mark.parametrize("mode", ["realtime", "lockstep"])
def test_a_reset_begins_a_new_run(rig_session: StartSession, mode: str) -> None:
    """Both runs can be looked at, each from its sample 0 on; the loop works after the reset."""
    rig = rig_session(mode, controller=STEP)
    rig.run_until(0.1)
    sample = rig.reset()
    assert sample.time == 0.0
    rig.run_until(0.1)
    for run in (rig.samples(0), rig.samples(1)):
        assert run.time[0] == 0.0
        assert run.time[-1] >= 0.1
    assert np.nanmax(rig.samples().voltage[60:100]) > 5.5
    with pytest.raises(IndexError):
        rig.samples(2)


def test_a_fork_inside_the_block_ends_nothing(rig_session: StartSession) -> None:
    """Another process that leaves the block leaves the rig to the one that has started it."""
    rig = rig_session("lockstep", duration=0.2)
    child = os.fork()
    if child == 0:
        rig.__exit__(None, None, None)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    rig.run()
    assert rig.samples().time[-1] == pytest.approx(0.2)


def test_a_fork_that_looks_at_the_session_is_refused_and_ends_nothing(
    rig_session: StartSession,
) -> None:
    """It is told in one line; for the process that opened the session nothing has changed."""
    rig = rig_session("lockstep", duration=0.2)
    uses: list[Callable[[], object]] = [
        lambda: rig.exit_codes,
        lambda: rig.run_for(0.05),
        lambda: rig.freeze("plant"),
        lambda: rig.kill("controller"),
    ]
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        for use in uses:
            try:
                use()
                os.write(writing, b"done\n")
            except HarnessError as error:
                os.write(writing, f"{error}\n".encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as said:
        lines = said.read().splitlines()
    assert os.waitpid(child, 0)[1] == 0
    assert len(lines) == len(uses)
    assert all(line.startswith("this process was forked inside the block") for line in lines)
    assert set(rig.exit_codes.values()) == {None}
    rig.run()
    assert rig.samples().time[-1] == pytest.approx(0.2)


def test_parameters_change_together_or_not_at_all(rig_session: StartSession) -> None:
    """A refused change raises the node's own words and leaves every value as it was."""
    rig = rig_session()
    rig.set_parameters("plant", {"friction.forward.static": 40.0, "supply.pressure": 500_000})
    rig.set_parameters("controller", {"controller.kp": 500.0})
    with pytest.raises(RefusedError, match=r"friction\.forward\.static: 1 N refused, below"):
        rig.set_parameters("plant", {"supply.pressure": 4e5, "friction.forward.static": 1.0})
    with pytest.raises(RefusedError, match=r"did you mean supply\.pressure"):
        rig.set_parameters("plant", {"suply.pressure": 4e5})
    names = ["friction.forward.static", "supply.pressure"]
    assert list(rig.parameters("plant", names).values()) == [40.0, 500_000.0]
    assert rig.parameters("controller", ["controller.kp"]) == {"controller.kp": 500.0}


def test_the_controller_can_be_switched_off_and_reset(rig_session: StartSession) -> None:
    """Switched off it commands a closed valve whatever the error; switched on it works."""
    rig = rig_session("lockstep", telemetry=True, relay_commands=True, controller=STEP)
    rig.run_until(0.1)
    rig.enable_controller(False)
    off = rig.run_for(0.05).time
    rig.enable_controller(True)
    rig.reset_controller()
    rig.run_for(0.05)
    run = rig.samples()
    closed = run.time[run.voltage == 5.08]
    assert np.count_nonzero(closed > 0.1) >= 49
    assert np.all(run.voltage[run.time > off + 2e-3][:-1] != 5.08)


def test_waiting_ends_and_says_for_what(rig_session: StartSession) -> None:
    """A wait that times out names what was waited for and shows what the nodes have printed."""
    rig = rig_session()
    with pytest.raises(WaitTimeoutError, match="waiting for the moon") as caught:
        rig.run_until(lambda _: False, "the moon", timeout=0.2)
    assert "loading the compiled plant" in str(caught.value)
    with pytest.raises(TimeoutError, match="waiting for a sign"):
        rig.wait_until(lambda: False, "a sign", timeout=0.2)


def test_voltages_that_are_none_are_refused(rig_session: StartSession) -> None:
    """By value, before the plant hears of them; a session that has ended says so."""
    rig = rig_session("lockstep", controller=None)
    for odd in ("5", True, None, [5.0]):
        with pytest.raises(HarnessError, match=r"^send_voltage .* refused: must be a number of V$"):
            rig.send_voltage(odd)  # type: ignore[arg-type]
    with pytest.raises(HarnessError, match=r"^drive '5' refused: must be a number of V$"):
        rig.drive("5")  # type: ignore[arg-type]
    rig.send_voltage(5.08)
    assert rig.run_until(1e-3).time == 1e-3
    rig.__exit__(None, None, None)
    with pytest.raises(HarnessError, match="this session does not run"):
        rig.send_voltage(5.08)


def test_a_program_that_is_not_there_is_named() -> None:
    """The controller's, in one line of the harness."""
    with pytest.raises(HarnessError, match="controller: 'nosuchprogram' cannot be started: No"):
        RigSession(controller=["nosuchprogram"]).__enter__()


def test_a_node_that_does_not_start_fails_at_once_with_its_words() -> None:
    """A parameter that is no parameter: the session raises what the node has printed."""
    with pytest.raises(NodeDiedError, match=r"no\.such: no such parameter"):
        RigSession(plant={"no.such": 1.0}).__enter__()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"mode": "lock-step"}, "mode 'lock-step' refused, must be one of"),
        ({"duration": math.nan}, "duration nan refused, must be a number of s"),
        ({"duration": "1"}, "duration '1' refused, must be a number of s"),
        ({"duration": -1.0}, "duration -1.0 refused, must be a number of s"),
        ({"one_process": "maybe"}, "one_process 'maybe' refused, must be True or False"),
        ({"telemetry": None}, "telemetry None refused, must be True or False"),
        ({"environment": {"A\0": "x"}}, "environment .* refused, must be texts by name"),
        ({"timeout": None}, "timeout None refused, must be a positive number of s"),
        ({"controller": "ros2 run x"}, "controller 'ros2 run x' refused, must be parameters by"),
        ({"controller": []}, r"controller \[\] refused, must be parameters by name"),
        ({"controller": 3}, "controller 3 refused, must be parameters by name"),
        ({"bag": ""}, "'' refused, no file has this path"),
        ({"plant": ["a"]}, r"plant \['a'\] refused, must be parameters by name: {name: value}"),
        ({"environment": {"A": 1}}, "environment {'A': 1} refused, must be texts by name"),
        ({"environment": "A=1"}, "environment 'A=1' refused, must be texts by name"),
        (
            {"mode": "lockstep", "plant": {"time.mode": "realtime"}},
            "time.mode 'realtime' refused, the session has mode='lockstep': give it there",
        ),
        (
            {"plant": {"time.duration": 2.0}},
            "time.duration 2.0 refused, the session has duration=0.0: give it there",
        ),
        ({"bag": "bag", "bag_topics": ["x y"]}, "'x y' is no topic name"),
        ({"bag": "b", "bag_topics": "x"}, "bag_topics 'x' refused, must be a list of names: "),
        ({"bag": "b", "bag_topics": [5]}, r"bag_topics \[5\] refused, must be a list of names: "),
        ({"bag_topics": ["x"]}, "bag_topics: there is no bag to record them into; give bag too"),
        ({"check": 3}, "check 3 refused, must be a function without arguments"),
    ],
    ids=str,
)
def test_options_that_make_no_sense_are_refused(options: dict[str, Any], line: str) -> None:
    """Before anything starts."""
    with pytest.raises(ValueError, match=f"^{line}"):
        RigSession(**options)


def test_a_session_is_used_inside_its_block_and_once_at_a_time() -> None:
    """Entered twice it would leave a second rig behind, which every later session would hear."""
    session = RigSession("lockstep", duration=0.02)
    outside: list[Callable[[], object]] = [
        session.run,
        session.pause,
        lambda: session.latest,
        lambda: session.setpoint(0.05),
        lambda: session.kill("plant"),
        lambda: session.restart("plant"),
        lambda: session.freeze("plant"),
        lambda: session.thaw("plant"),
        session.step,
        lambda: session.__exit__(None, None, None),
    ]
    for ask in outside:
        with pytest.raises(HarnessError, match="does not run: use it inside its with block"):
            ask()
    with session as rig:
        pids = rig.pids
        with pytest.raises(HarnessError, match="this session runs already"):
            session.__enter__()
        assert len(rig.run()) == 21
        assert rig.pids == pids
    # Its last sample is there still, and a second end is none.
    for ask in [*outside[:2], *outside[3:-1]]:
        with pytest.raises(HarnessError, match="does not run: use it inside its with block"):
            ask()
    with session as rig:  # anew
        assert len(rig.run()) == 21


def test_a_session_that_is_entered_anew_knows_nothing_of_the_block_before() -> None:
    """Nodes begin paused, enabled and with the reference that they are given, each time."""
    session = RigSession("lockstep", controller={"reference.type": "step"}, paused=True)
    for _ in range(2):
        with session as rig:
            assert rig.step().time == 1e-3
            with pytest.raises(RefusedError, match=r"reference\.type is step; set-points need"):
                rig.setpoint(0.1)
            rig.set_parameters("/controller", {"reference.type": "setpoint"})
            rig.enable_controller()
            rig.setpoint(0.1)
            rig.enable_controller(False)
            rig.resume()
            rig.run_for(0.01)


def test_a_setpoint_that_cannot_be_is_refused_to_its_sender(rig_session: StartSession) -> None:
    """Millimetres for metres, no number, a text; within a range that was widened it arrives."""
    narrow = rig_session("lockstep", controller={"reference.maximum": 0.1}, duration=0.05)
    with pytest.raises(RefusedError, match=r"^setpoint 0.15 m refused, must be from 0 to 0.1 m"):
        narrow.setpoint(0.15)
    rig = rig_session("lockstep", duration=0.05)
    for wrong in (math.nan, math.inf, "0.1", None):
        with pytest.raises(ValueError, match=r"^setpoint .* must be a finite number \(m\)$"):
            rig.setpoint(wrong)  # type: ignore[arg-type]
    line = r"^setpoint 58 m refused, must be from 0 to 0.2 m \(reference.minimum, reference.max"
    with pytest.raises(RefusedError, match=line):
        rig.setpoint(58)
    rig.set_parameters("controller", {"reference.maximum": 0.5})
    rig.setpoint(0.3)
    rig.run()
    assert rig.diagnostics("controller").get("set-points refused", "0") == "0"


def test_a_setpoint_that_the_controller_does_not_follow_is_refused_to_its_sender(
    rig_session: StartSession,
) -> None:
    """Beside a reference of its own, or switched off; started again it is as it began."""
    rig = rig_session("lockstep", controller={"reference.type": "step"}, duration=0.1)
    own = r"^setpoint 0.1 m refused, reference.type is step; set-points need setpoint, ramp or move"
    with pytest.raises(RefusedError, match=own):
        rig.setpoint(0.1)
    rig.set_parameters("controller", {"reference.type": "setpoint"})
    rig.setpoint(0.1)
    rig.enable_controller(False)
    with pytest.raises(
        RefusedError, match=r"the controller is disabled; enable_controller\(\) first"
    ):
        rig.setpoint(0.1)
    rig.enable_controller()
    rig.setpoint(0.1)
    assert rig.diagnostics("controller").get("set-points refused", "0") == "0"
    rig.restart("controller")
    with pytest.raises(RefusedError, match=own):
        rig.setpoint(0.1)


def test_requests_that_make_no_sense_are_refused(rig_session: StartSession) -> None:
    """Options and calls that contradict each other raise instead of waiting for ever."""
    with pytest.raises(ValueError, match="one_process"):
        RigSession(controller=None, one_process=True)
    with pytest.raises(ValueError, match="telemetry"):
        RigSession(controller=None, telemetry=True)
    with pytest.raises(ValueError, match="relay_commands"):
        RigSession(controller=None, relay_commands=True)
    with pytest.raises(FileNotFoundError, match="paper"):
        RigSession(preset="no such")
    rig = rig_session(plant={"time.period": 5e-3})
    for call, text in (
        (lambda: rig.send_voltage(5.0), "the controller of this session"),
        (lambda: rig.drive(5.0), "the controller of this session"),
        (lambda: rig.alter_commands(None), "relay_commands"),
        (rig.run, "no duration"),
        (lambda: rig.kill("rig"), "plant, controller"),
    ):
        with pytest.raises(HarnessError, match=text):
            call()
    with pytest.raises(ValueError, match="wait_until: 5 refused, must be a function"):
        rig.wait_until(5, "x")  # type: ignore[arg-type]
    for condition in ("the carriage", math.nan, None):
        with pytest.raises(ValueError, match=r"must be a plant time \(s\) or a function"):
            rig.run_until(condition)  # type: ignore[arg-type]
    with pytest.raises(IndexError, match="run 5: there are 1, from 0 to 0"):
        rig.samples(5)
    for odd in ("x", 1.5, None):
        with pytest.raises(TypeError, match=r"^run .* refused, must be a whole number$"):
            rig.samples(odd)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"^count .* refused, must be a whole number$"):
            rig.step(odd)  # type: ignore[arg-type]
    for count in (0, -1):
        with pytest.raises(ValueError, match=rf"^count {count} refused, must be 1 or more$"):
            rig.step(count)
    with pytest.raises(TypeError, match=r"refused, must be a list of names: \['supply.pressure'\]"):
        rig.parameters("plant", "supply.pressure")
    with pytest.raises(TypeError, match=r"^\['a'\] refused, must be values by name"):
        rig.set_parameters("plant", ["a"])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"^5 refused, must be the name of a parameter"):
        rig.set_parameters("plant", {5: 6})  # type: ignore[dict-item]
    with pytest.raises(
        TypeError, match=r"^supply\.pressure: \{\} refused, must be a number, a text"
    ):
        rig.set_parameters("plant", {"supply.pressure": {}})
    rig.set_parameters("plant", {"supply.pressure": np.float32(6e5)})
    rig.set_parameters("plant", {})
    assert rig.parameters("plant", ["supply.pressure"]) == {"supply.pressure": 6e5}
    with pytest.raises(WaitTimeoutError, match=r"of plnt; nodes here: .*/controller.*/plant"):
        rig.observer.set_parameters("plnt", {"supply.pressure": 6e5}, timeout=1.0)


def test_a_bag_holds_the_session_from_sample_0_on(
    rig_session: StartSession, tmp_path: Path
) -> None:
    """In lock-step every sample, command and set-point is in it, and what was asked for besides."""
    bag = tmp_path / "bag"
    rig = rig_session(
        "lockstep", duration=0.2, paused=True, bag=bag, bag_topics=["controller/reference"]
    )
    rig.step(100)
    rig.setpoint(0.02)
    rig.resume()
    run = rig.run()
    rig.__exit__(None, None, None)
    recorded = read_bag(bag)
    for topic in ("/joint_states", "/supply/pressure", "/valve/voltage"):
        assert recorded[topic].log_time.tolist() == [k * 1_000_000 for k in range(201)], topic
    assert np.array_equal(recorded["/joint_states"].fields["position"][:, 0], run.position)
    assert np.array_equal(recorded["/valve/voltage"].fields["data"], run.voltage)
    read = read_run(bag)
    for name in ("position", "pressure_a", "pressure_b", "supply_pressure"):
        assert np.array_equal(getattr(read, name), getattr(run, name)), name
    assert recorded["/setpoint"].log_time.tolist() == [100 * 1_000_000]
    # Sample 100 was answered before; the set-point had arrived when the plant went on.
    reference = recorded["/controller/reference"].fields["data"]
    assert np.flatnonzero(reference == 0.02)[0] == 101
    assert len(reference) >= 200


@pytest.mark.parametrize(
    "options",
    [{"controller": None}, {"relay_commands": True}, {"one_process": True}],
    ids=["no controller", "relayed", "one process"],
)
def test_a_bag_can_be_had_with_every_kind_of_controller(
    rig_session: StartSession, tmp_path: Path, options: dict[str, Any]
) -> None:
    """Whoever sends the commands, the bag begins with sample 0 and the command that answers it."""
    rig = rig_session("lockstep", bag=tmp_path / "bag", **options)
    if options.get("controller", {}) is None:
        rig.drive(5.6)
    rig.run_until(0.05)
    rig.__exit__(None, None, None)
    recorded = read_bag(tmp_path / "bag")
    for topic in ("/joint_states", "/valve/voltage"):
        assert recorded[topic].log_time[:50].tolist() == [k * 1_000_000 for k in range(50)], topic


def test_a_bag_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    """The session does not begin, says why, and leaves no process behind."""
    rig = RigSession(bag=tmp_path)
    with pytest.raises(BagError, match="exists already"):
        rig.__enter__()
    assert None not in rig.exit_codes.values()


def test_a_check_ends_whatever_wait_it_is_called_in() -> None:
    """Also the start: both nodes are ended, and the exception of the check comes out."""
    calls: list[None] = []

    def check() -> None:
        calls.append(None)
        if len(calls) == 5:
            raise ZeroDivisionError

    rig = RigSession(check=check)
    with pytest.raises(ZeroDivisionError):
        rig.__enter__()
    assert None not in rig.exit_codes.values()


def test_the_old_name_of_the_timeout_goes_on_working(rig_session: StartSession) -> None:
    """patience= bounds the same waits, with a warning that names the new option."""
    with pytest.warns(DeprecationWarning, match="timeout="):
        rig = rig_session(patience=60.0)
    for wait in (
        lambda **options: rig.wait_until(lambda: False, "a sign", **options),
        lambda **options: rig.run_until(1e5, **options),
        lambda **options: rig.run_for(1e5, **options),
    ):
        with pytest.warns(DeprecationWarning, match="timeout="), pytest.raises(PatienceError):
            wait(patience=0.05)
        with pytest.raises(TypeError, match="old name"):
            wait(patience=0.05, timeout=0.05)
    assert PatienceError is WaitTimeoutError


@pytest.mark.parametrize("mode", [also("lockstep"), "realtime"])
def test_what_follows_a_command_goes_by_samples_from_then_on(
    rig_session: StartSession, mode: Mode
) -> None:
    """A rig that ran for seconds while the test was busy with another one has not been heard of.

    Two seconds after a set-point the carriage is there, by the samples that `run_for` counts; after
    a change of parameters and a pause the newest sample is from after it, too.
    """
    rig = rig_session(mode, plant={"time.period": 5e-3})
    with RigSession("lockstep", plant={"time.period": 5e-3}) as other:
        other.run_until(0.1)
    sent = time.time_ns()
    rig.setpoint(0.05)
    assert rig._received.last_complete_sent >= sent
    assert rig.run_for(2.0).position == pytest.approx(0.05, abs=2e-4)
    until = time.monotonic() + 0.5
    while time.monotonic() < until:
        pass  # a test that computes
    sent = time.time_ns()
    rig.set_parameters("plant", {"supply.pressure": 5e5})
    assert rig._received.last_complete_sent >= sent
    assert rig.latest.supply_pressure == pytest.approx(5e5, rel=1e-3)
    rig.pause()
    stands = rig.latest.time
    assert rig.step().time == pytest.approx(stands + 5e-3)


def test_sessions_side_by_side_do_not_hear_each_other(rig_session: StartSession) -> None:
    """Two rigs in one test are in two domains, and each follows its own set-point only."""
    rigs = [rig_session(plant={"time.period": 5e-3}) for _ in range(2)]
    assert len({rig.environment["ROS_DOMAIN_ID"] for rig in rigs}) == 2
    rigs[0].setpoint(0.005)
    rigs[0].run_until(lambda sample: sample.position > 0.004, "the first to move")
    assert rigs[1].run_until(rigs[0].latest.time).position < 1e-4


def test_nothing_of_a_session_shows_outside(rig_session: StartSession) -> None:
    """The environment of the test's own process stays as it was."""
    before = dict(os.environ)
    rig = rig_session(plant={"time.period": 5e-3})
    assert dict(os.environ) == before
    assert any(name.endswith("_DEFAULT_PROFILES_FILE") for name in rig.environment)


def test_a_law_that_fails_leaves_its_sample_to_the_next(rig_session: StartSession) -> None:
    """In lock-step one that raises, or answers nothing, is named; with another the run goes on."""
    rig = rig_session("lockstep", controller=None, duration=0.2)
    rig.drive(lambda _: 5.2)
    rig.run_until(0.01)
    for law, error, words in (
        (lambda _: 1 / 0, ZeroDivisionError, "division"),
        (lambda _: None, HarnessError, "at 0.01 s is None, and a lock-step plant waits for a"),
        (lambda _: [5.0], HarnessError, r"at 0\.01 s \[5\.0\] refused: must be a number of V"),
    ):
        rig.drive(law)
        with pytest.raises(error, match=words):
            rig.run_for(0.01)
    rig.drive(lambda _: np.where(True, 6.0, 5.0))
    assert rig.run_until(0.2).time == pytest.approx(0.2)
    expected = simulate(RigParameters.preset("paper"), [5.2] * 10 + [6.0] * 190, 1e-3)
    assert np.array_equal(rig.samples().position, expected.position)


def test_a_wait_beyond_the_duration_ends_with_the_run(rig_session: StartSession) -> None:
    """For a plant time or for anything else; after a reset there is another run.

    The duration is a sum of decimals, a little more than the last sample's time.
    """
    rig = rig_session("lockstep", controller=None, duration=0.1 + 0.2)
    rig.drive(5.08)
    for condition, what in ((0.5, "plant time 0.5 s"), (lambda _: False, "the condition of")):
        with pytest.raises(HarnessError, match=f"{what}.* has not come, and the run is over: the"):
            rig.run_until(condition)
        assert rig.latest.time == pytest.approx(0.3)
        rig.reset()
    assert rig.run_until(0.3).time == pytest.approx(0.3)
