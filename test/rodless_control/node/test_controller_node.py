# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The controller answers each position with one command, and stays safe without one."""

import math
import signal
from collections.abc import Iterator

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from running import StartProcess
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_control import ControllerParameters, Measurement
from rodless_control.loop import ControlLoop
from rodless_lab.session.observer import Observer

NODE = "/controller"
NEUTRAL = ControllerParameters().number("controller.neutral_voltage")
PERIOD = 1_000_000
SETPOINT = 0.058

# The controller's own wall clock is out of the game: it never takes the test for lost.
PATIENT = {"controller.position_timeout": 0.0}


class Bench:
    """A controller whose plant is the test, beside the same control law without ROS."""

    def __init__(self, observer: Observer) -> None:
        """Start to publish and to collect."""
        self.observer = observer
        self.commands: list[Float64] = observer.collect(Float64, "/valve/voltage")
        self.references: list[Float64] = observer.collect(Float64, "/controller/reference")
        self._positions = observer.publisher(JointState, "/joint_states")
        self._setpoints = observer.publisher(Float64, "/setpoint")
        self._time = 0
        self.model = ControlLoop(ControllerParameters(PATIENT))

    def restart(self, setpoint: float = SETPOINT) -> None:
        """Give both the default parameters and a set-point, and begin anew with it.

        ``~/reset`` forgets the set-point too; time that begins anew does not.
        """
        defaults = {"controller.kp": ControllerParameters()["controller.kp"], **PATIENT}
        self.observer.set_parameters(NODE, defaults)
        assert self.observer.call(SetBool, f"{NODE}/enable", data=True).success
        assert self.observer.call(Trigger, f"{NODE}/reset").success
        self.setpoint(setpoint)
        self._time += PERIOD
        self.observer.wait(lambda: self._follows(setpoint), "the set-point to be followed")
        self._time = 0
        self.model = ControlLoop(ControllerParameters(PATIENT))
        self.model.setpoints.receive(setpoint)

    def _follows(self, setpoint: float) -> bool:
        self.command_for(0.0)
        return bool(self.references) and self.references[-1].data == setpoint

    def setpoint(self, value: float) -> None:
        """Send a set-point."""
        self._setpoints.publish(Float64(data=value))

    def send(self, message: JointState, time: int | None = None) -> int:
        """Send a sample, a period after the last or at ``time`` (ns); return its time."""
        self._time = self._time + PERIOD if time is None else time
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self._time, 10**9)
        self._positions.publish(message)
        return self._time

    def command_for(self, position: float, time: int | None = None) -> float:
        """Send a sample and return the one command that answers it."""
        start = len(self.commands)
        self.send(JointState(name=["carriage"], position=[position]), time)
        self.observer.wait(lambda: len(self.commands) > start, "a command")
        assert len(self.commands) == start + 1
        return self.commands[-1].data

    def agrees(self, position: float, time: int | None = None) -> None:
        """Check that a sample gets from the controller what the law without ROS commands."""
        command = self.command_for(position, time)
        output = self.model.sample(Measurement(self._time, position))
        assert command == (NEUTRAL if output is None else output.voltage)

    def count(self, key: str) -> float:
        """Return a number from a diagnostic that was sent after now."""
        return self.observer.counter(NODE, key, fresh=True)


@pytest.fixture(scope="module")
def bench(observer: Observer, start_node: StartProcess) -> Iterator[Bench]:
    """Run a controller whose plant is the test."""
    with start_node("controller", PATIENT):
        yield Bench(observer)


# Where the integral grows: within its zone of the set-point.
HELD = SETPOINT - 0.003

# A carriage that comes there and stays, long enough for the derivative to fade.
APPROACH = [HELD - 0.01 * 0.9**k for k in range(100)] + [HELD] * 100


def test_each_sample_gets_one_command_and_nothing_else_does(bench: Bench) -> None:
    """200 samples get 200 commands, those of the law without ROS; silence gets none."""
    bench.restart()
    start = len(bench.commands)
    for position in APPROACH:
        bench.agrees(position)
    bench.observer.diagnostic(NODE, fresh=True)
    bench.observer.diagnostic(NODE, fresh=True)
    assert len(bench.commands) == start + 200


def test_a_burst_of_samples_gets_a_command_for_each_in_order(bench: Bench) -> None:
    """Samples that pile up are answered one by one: none is skipped, none twice."""
    bench.restart()
    start = len(bench.commands)
    positions = [*APPROACH, *APPROACH]
    times = [bench.send(JointState(name=["carriage"], position=[x])) for x in positions]
    bench.observer.wait(lambda: len(bench.commands) >= start + 400, "400 commands")
    expected = [
        bench.model.sample(Measurement(time, position))
        for position, time in zip(positions, times, strict=True)
    ]
    assert [c.data for c in bench.commands[start:]] == [o.voltage for o in expected if o]


def test_telemetry_is_what_the_command_is_made_of(bench: Bench) -> None:
    """Reference and error in m, the terms in V, one of each per sample, as the law has them."""
    terms = ("reference", "error", "p", "i", "d", "feedforward")
    records = {term: bench.observer.collect(Float64, f"{NODE}/{term}") for term in terms}
    bench.observer.wait(lambda: bench.command_for(0.0) and all(records.values()), "telemetry")
    bench.restart()
    bench.observer.diagnostic(NODE, fresh=True)
    for messages in records.values():
        messages.clear()
    positions = APPROACH[:20]
    for position in positions:
        bench.command_for(position)
    bench.observer.wait(lambda: all(len(m) == 20 for m in records.values()), "telemetry")
    for k, position in enumerate(positions):
        output = bench.model.sample(Measurement((k + 1) * PERIOD, position))
        assert output is not None
        assert records["reference"][k].data == output.reference == SETPOINT
        for term in terms[1:]:
            # Another start of time, so another last digit of each interval.
            value = output.terms[term]
            assert records[term][k].data == pytest.approx(value, rel=1e-9, abs=1e-12)


def test_a_position_that_is_no_number_closes_the_valve(bench: Bench) -> None:
    """NaN and infinities get the neutral command; the integral waits, and no impulse follows."""
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    before = bench.commands[-1].data
    for bad in (math.nan, math.inf, -math.inf):
        bench.agrees(bad)
        assert bench.commands[-1].data == NEUTRAL
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.level == DiagnosticStatus.ERROR
    assert status.message == "position not finite: valve closed"
    bench.agrees(HELD)
    assert bench.commands[-1].data == pytest.approx(before, abs=0.01)
    assert bench.count("positions not finite") == 3


def test_a_sample_without_the_joint_is_none(bench: Bench) -> None:
    """It gets no command and is counted; the next good sample is answered as if it had not been."""
    bench.restart()
    for useless in (
        JointState(),
        JointState(name=["carriage"]),
        JointState(position=[0.01]),
        JointState(name=["other"], position=[0.01]),
        JointState(name=["other", "carriage"], position=[0.01]),
    ):
        bench.agrees(0.05)
        bench.send(useless)
    bench.agrees(0.05)
    assert bench.count("samples without the joint") == 5


def test_the_joint_is_found_by_its_name(bench: Bench) -> None:
    """Among several joints the position of the carriage counts, wherever it stands."""
    bench.restart()
    start = len(bench.commands)
    message = JointState(name=["left", "carriage", "right"], position=[1.0, 0.055, math.nan])
    output = bench.model.sample(Measurement(bench.send(message), 0.055))
    bench.observer.wait(lambda: len(bench.commands) > start, "a command")
    assert output is not None
    assert bench.commands[-1].data == output.voltage


def test_a_setpoint_that_is_no_number_is_refused(bench: Bench) -> None:
    """The old set-point stays in force, and the refusals are counted."""
    bench.restart()
    bench.setpoint(math.nan)
    bench.setpoint(math.inf)
    bench.observer.wait(
        lambda: bench.observer.counter(NODE, "set-points refused") == 2, "the refusals"
    )
    bench.agrees(0.05)
    assert bench.references[-1].data == SETPOINT


def test_time_that_runs_backwards_restarts_the_loop(bench: Bench) -> None:
    """A plant that was reset is controlled from its new start: no old integral, no impulse."""
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    counted = bench.count("restarts by time running backwards")
    for time in range(0, 50 * PERIOD, PERIOD):
        bench.agrees(HELD, time)
    assert bench.count("restarts by time running backwards") == counted + 1


def test_time_that_stands_still_is_answered(bench: Bench) -> None:
    """The same stamp twice, as of a plant that a step was refused, does no harm."""
    bench.restart()
    for time in (0, 0, PERIOD):
        bench.agrees(0.05, time)


def test_a_new_gain_does_not_jump(bench: Bench) -> None:
    """Twice kp, at an error of 3 mm: the command goes to its new value in steps of one per cent.

    It begins where it was, and each sample is answered as by the law without ROS.
    """
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    kp = ControllerParameters().number("controller.kp")
    change = {"controller.kp": 2.0 * kp}
    bench.observer.set_parameters(NODE, change)
    bench.model.configure(ControllerParameters({**PATIENT, **change}))
    for _ in range(20):
        before = bench.commands[-1].data
        bench.agrees(HELD)
        assert abs(bench.commands[-1].data - before) < 0.02 * kp * (SETPOINT - HELD)


def test_positions_that_stop_close_the_valve_and_come_back_without_an_impulse(
    bench: Bench,
) -> None:
    """After the timeout neutral commands come by themselves; then the integral is as it was.

    The diagnostics say whose the last command was.
    """
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.values["last command"] == "of the law"
    before = bench.commands[-1].data
    start = len(bench.commands)
    bench.observer.set_parameters(NODE, {"controller.position_timeout": 0.1})
    bench.observer.wait(lambda: len(bench.commands) >= start + 5, "neutral commands")
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.level == DiagnosticStatus.ERROR
    assert "valve closed" in status.message
    assert status.values["last command"] == "closed valve"
    bench.observer.set_parameters(NODE, PATIENT)
    assert bench.count("positions lost") == 1
    assert {command.data for command in bench.commands[start:]} == {NEUTRAL}
    bench.model.hold()
    bench.agrees(HELD)
    assert bench.commands[-1].data == pytest.approx(before, abs=0.01)
    bench.agrees(HELD)
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.level == DiagnosticStatus.WARN
    assert "positions lost" in status.message


def test_a_disabled_controller_keeps_the_valve_closed(bench: Bench) -> None:
    """Each sample gets the neutral command until ~/enable; then the loop starts as if new."""
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    answer = bench.observer.call(SetBool, f"{NODE}/enable", data=False)
    assert answer.success
    assert "disabled" in answer.message
    assert [bench.command_for(0.01) for _ in range(5)] == [NEUTRAL] * 5
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.level == DiagnosticStatus.WARN
    assert "disabled" in status.message
    assert bench.observer.call(SetBool, f"{NODE}/enable", data=True).success
    bench.model.reset()
    for position in APPROACH[:5]:
        bench.agrees(position)


def test_reset_holds_the_carriage_where_it_is_until_a_new_set_point(bench: Bench) -> None:
    """After ~/reset the loop is as at its first sample, and follows the set-point after it."""
    bench.restart()
    for position in APPROACH:
        bench.agrees(position)
    bench.send(JointState())
    answer = bench.observer.call(Trigger, f"{NODE}/reset")
    assert answer.success
    assert answer.message == "holds where it is until a new set-point comes"
    status = bench.observer.diagnostic(NODE, fresh=True)
    assert status.values["set-point (m)"] == "none"
    assert status.values["samples without the joint"] == "0", "counters begin anew"
    bench.model = ControlLoop(ControllerParameters(PATIENT))
    bench.agrees(0.03)
    bench.agrees(0.031)
    bench.observer.wait(lambda: bench.references[-1].data == 0.03, "the position it was found at")
    bench.setpoint(SETPOINT)
    bench.observer.wait(lambda: bench._follows(SETPOINT), "the new set-point to be followed")


def test_without_any_position_the_valve_is_kept_closed(
    observer: Observer, start_node: StartProcess
) -> None:
    """A controller without a plant says so, and commands 5.08 V over and over."""
    with start_node("controller", namespace="alone") as controller:
        commands = observer.collect(Float64, "/alone/valve/voltage")
        observer.more(commands, 10)
        status = observer.diagnostic("/alone/controller")
        assert status.level == DiagnosticStatus.ERROR
        assert status.message == "no position: valve closed"
        assert {command.data for command in commands} == {NEUTRAL}
        started = "started: law pid, reference setpoint; waiting for positions on"
        assert f"{started} /alone/joint_states\n" in controller.output
        assert "ready: " not in controller.output


@pytest.mark.parametrize(
    "values",
    [{}, {"controller.position_timeout": 0.0}, {"use_sim_time": True}],
    ids=["of a rig", "that never times out", "of a simulated plant"],
)
def test_the_last_command_of_a_controller_that_ends_closes_the_valve(
    observer: Observer, start_node: StartProcess, values: dict[str, object]
) -> None:
    """Ctrl-C in mid-move: whatever has been commanded before, 5.08 V arrives last.

    In real time; a plant in lock-step has asked for none.
    """
    report = DiagnosticStatus(name="/ending/plant")
    told = {"mode": "realtime", "Target frequency (Hz)": "1000"}
    report.values = [KeyValue(key=key, value=value) for key, value in told.items()]
    with start_node("controller", values, namespace="ending") as controller:
        diagnostics = observer.publisher(DiagnosticArray, "/diagnostics")
        commands = observer.collect(Float64, "/ending/valve/voltage")
        positions = observer.publisher(JointState, "/ending/joint_states")
        observer.publisher(Float64, "/ending/setpoint").publish(Float64(data=0.1))
        sample = JointState(name=["carriage"], position=[0.0])

        def moves() -> bool:
            if "use_sim_time" in values:
                diagnostics.publish(DiagnosticArray(status=[report]))
            sample.header.stamp.nanosec += PERIOD
            positions.publish(sample)
            return bool(commands) and commands[-1].data > NEUTRAL

        observer.wait(moves, "a command that moves the carriage")
        controller.signal(signal.SIGINT)
        observer.wait(lambda: commands[-1].data == NEUTRAL, "the last command")
        assert controller.wait() == 0
