# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller together: two processes, DDS between them, time paced by the wall clock."""

import itertools
import signal
from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Clock
from running import StartRig
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_control import ControllerParameters, PidParameters
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import SessionProcesses

PERIOD = 1_000_000

CLOSED = ControllerParameters().number("controller.neutral_voltage")

# The paper's tolerance.
WITHIN = 2e-4


@dataclass
class Rig:
    """The paper's rig at 1 kHz, and what its topics carry."""

    observer: Observer
    samples: list[JointState]
    commands: list[Float64]
    processes: SessionProcesses

    def __post_init__(self) -> None:
        self._setpoint = self.observer.publisher(Float64, "/setpoint")

    @property
    def time(self) -> float:
        """Plant time of the last sample in s."""
        return stamp_nanoseconds(self.samples[-1].header.stamp) * 1e-9

    @property
    def position(self) -> float:
        """Position of the carriage in m."""
        return float(self.samples[-1].position[0])

    def send(self, setpoint: float) -> None:
        """Send a set-point (m)."""
        self._setpoint.publish(Float64(data=setpoint))

    def wait(self, seconds: float) -> None:
        """Let ``seconds`` of plant time pass."""
        end = self.time + seconds
        self.observer.wait(lambda: self.time >= end, f"{seconds} s of plant time")

    def go(self, setpoint: float) -> None:
        """Send the carriage there, and wait until it has come."""
        self.send(setpoint)
        self.observer.wait(lambda: abs(self.position - setpoint) < WITHIN, "the carriage to come")

    def pause(self, paused: bool) -> None:
        """Stop plant time and wait until nothing is under way; or let it run."""
        assert self.observer.call(SetBool, "/plant/pause", data=paused).success
        if paused:
            self.observer.diagnostic("/plant", fresh=True)
            self.observer.diagnostic("/controller", fresh=True)


@pytest.fixture(scope="module")
def rig(observer: Observer, start_rig: StartRig) -> Iterator[Rig]:
    """Run the rig."""
    with start_rig() as processes:
        samples = observer.collect(JointState, "/joint_states")
        commands = observer.collect(Float64, "/valve/voltage")
        observer.more(samples, 1)
        # The controller speaks only when it is spoken to: from then on the loop is closed.
        observer.more(commands, 10)
        yield Rig(observer, samples, commands, processes)


def test_the_carriage_reaches_58_mm_with_one_command_per_sample(rig: Rig) -> None:
    """The paper's step: within 0.2 mm after 5 s of plant time, and as many commands as samples.

    The plant is paused before and after, so that no sample is without its answer when they are
    counted; the pause itself brings no command, so none comes from a timer.
    """
    rig.pause(True)
    counts = len(rig.samples), len(rig.commands)
    rig.send(0.058)
    rig.pause(False)
    rig.wait(5.0)
    rig.pause(True)
    samples, commands = rig.samples[counts[0] :], rig.commands[counts[1] :]
    rig.pause(False)
    stamps = [stamp_nanoseconds(sample.header.stamp) for sample in samples]
    assert stamps == list(range(stamps[0], stamps[0] + len(stamps) * PERIOD, PERIOD))
    assert len(commands) == len(samples) >= 5000
    assert all(abs(sample.position[0] - 0.058) <= WITHIN for sample in samples[-1000:])
    assert all(0.0 <= command.data <= 10.0 for command in commands)


def test_diagnostics_tell_that_both_are_at_work(rig: Rig) -> None:
    """Neither is in error; what the machine was too slow for is a warning at most."""
    rig.go(0.05)
    arrays = rig.observer.collect(DiagnosticArray, "/diagnostics")
    plant = rig.observer.diagnostic("/plant", fresh=True)
    controller = rig.observer.diagnostic("/controller", fresh=True)
    rig.observer.more(arrays, 2)
    assert {status.hardware_id for array in arrays for status in array.status} == {
        "rig",
        "rig, cylinder 25-200 mm",
    }
    for status in (plant, controller):
        assert status.level in (DiagnosticStatus.OK, DiagnosticStatus.WARN), status.message
    if plant.level == DiagnosticStatus.OK:
        assert plant.message == "running"
    if controller.level == DiagnosticStatus.OK:
        assert controller.message == "controlling"
    assert rig.observer.counter("/plant", "commands not finite") == 0
    assert rig.observer.counter("/plant", "commands clamped") == 0
    assert rig.observer.counter("/controller", "positions not finite") == 0
    assert rig.observer.counter("/controller", "samples without the joint") == 0


def test_a_new_gain_in_mid_move_does_not_jump(rig: Rig) -> None:
    """Twice kp while the carriage follows a ramp: the voltage takes no step.

    The terms change places instead: what the proportional term gains, the integral gives.
    """
    kp = PidParameters().number("controller.kp")
    terms = {name: rig.observer.collect(Float64, f"/controller/{name}") for name in ("p", "i")}
    ramp = {"reference.type": "ramp", "reference.velocity": 0.02}
    rig.go(0.03)
    rig.observer.set_parameters("/controller", ramp)
    try:
        rig.send(0.09)
        rig.observer.wait(lambda: rig.position > 0.05, "the carriage in mid-move")
        start = {name: len(messages) - 20 for name, messages in terms.items()}
        first = len(rig.commands) - 20
        rig.observer.set_parameters("/controller", {"controller.kp": 2.0 * kp})
        for name, values in terms.items():
            rig.observer.wait(
                lambda values=values, name=name: largest_step(values[start[name] :]) > 0.02,
                f"a step of the term {name}",
            )
        exchanged = largest_step(terms["i"][start["i"] :])
        assert largest_step(terms["p"][start["p"] :]) == pytest.approx(exchanged, rel=0.2)
        assert largest_step(rig.commands[first:]) < 0.2 * exchanged
    finally:
        back = {"controller.kp": kp, "reference.type": "setpoint"}
        rig.observer.set_parameters("/controller", back)


def largest_step(messages: list[Float64]) -> float:
    """Largest change from one message to the next."""
    values = [message.data for message in messages]
    return max(abs(b - a) for a, b in itertools.pairwise(values))


def test_a_pause_in_mid_move_is_no_loss(rig: Rig) -> None:
    """The controller keeps the plant's time: paused for seconds, it waits, and the move goes on."""
    rig.go(0.02)
    lost = rig.observer.counter("/controller", "positions lost", fresh=True)
    rig.send(0.1)
    rig.observer.wait(lambda: rig.position > 0.04, "the carriage in mid-move")
    rig.pause(True)
    held = rig.position
    rig.observer.diagnostic("/controller", fresh=True)
    assert rig.position == held < 0.1
    assert rig.observer.counter("/controller", "positions lost") == lost
    rig.pause(False)
    rig.go(0.1)


def test_a_plant_that_is_stopped_is_lost_and_one_that_goes_on_is_followed(rig: Rig) -> None:
    """SIGSTOP in mid-move: the valve is commanded closed and that is said; SIGCONT: it goes on."""
    processes = rig.processes
    rig.go(0.02)
    lost = rig.observer.counter("/controller", "positions lost", fresh=True)
    rig.send(0.12)
    rig.observer.wait(lambda: rig.position > 0.04, "the carriage in mid-move")
    processes["plant"].signal(signal.SIGSTOP)
    try:
        rig.observer.wait(lambda: tail(rig.commands, 10) == {CLOSED}, "a closed valve")
        status = rig.observer.diagnostic("/controller", fresh=True)
        assert status.level == DiagnosticStatus.ERROR
        assert status.message == "no position: valve closed"
        assert float(status.values["positions lost"]) == lost + 1
    finally:
        processes["plant"].signal(signal.SIGCONT)
    rig.go(0.12)
    status = rig.observer.diagnostic("/controller", fresh=True)
    assert status.level != DiagnosticStatus.ERROR
    assert "positions have stopped coming: commanding a closed valve" in (
        processes["controller"].output
    )
    assert "positions come again" in processes["controller"].output


def tail(commands: list[Float64], count: int) -> set[float]:
    """Return the values of the last commands."""
    return {command.data for command in commands[-count:]}


def test_a_long_pause_and_single_steps_are_no_loss(rig: Rig) -> None:
    """Longer than any timeout of the controller; /clock goes on with the time that stands still."""
    clocks = rig.observer.collect(Clock, "/clock")
    lost = rig.observer.counter("/controller", "positions lost", fresh=True)
    rig.pause(True)
    del clocks[:]
    for _ in range(3):
        rig.observer.more(clocks, 100)
        assert rig.observer.call(Trigger, "/plant/step").success
    rig.observer.more(clocks, 100)
    times = [stamp_nanoseconds(message.clock) for message in clocks]
    assert sorted(times) == times
    assert len(set(times)) == 4
    assert rig.observer.diagnostic("/controller", fresh=True).level != DiagnosticStatus.ERROR
    assert rig.observer.counter("/controller", "positions lost") == lost
    rig.pause(False)
    rig.go(0.04)


def test_a_reset_leaves_the_loop_working(rig: Rig) -> None:
    """Plant time goes back to 0, the carriage to its start, and from there to the set-point."""
    rig.go(0.04)
    start = len(rig.samples)
    assert rig.observer.call(Trigger, "/plant/reset").success
    rig.observer.wait(
        lambda: any(stamp_nanoseconds(s.header.stamp) == 0 for s in rig.samples[start:]), "sample 0"
    )
    zero = next(s for s in rig.samples[start:] if stamp_nanoseconds(s.header.stamp) == 0)
    assert zero.position[0] == 0.0
    rig.observer.wait(lambda: rig.time < 5.0 and rig.position > 0.039, "the carriage to return")
    rig.wait(2.0)
    assert abs(rig.position - 0.04) <= WITHIN
    restarts = "restarts by time running backwards"
    assert rig.observer.counter("/controller", restarts, fresh=True) == 1


def test_a_disabled_controller_stops_the_carriage_and_enabled_goes_on(rig: Rig) -> None:
    """In mid-move ~/enable false closes the valve; true holds until there is a new set-point."""
    rig.go(0.02)
    rig.send(0.15)
    rig.observer.wait(lambda: rig.position > 0.04, "the carriage in mid-move")
    assert rig.observer.call(SetBool, "/controller/enable", data=False).success
    rig.wait(0.5)
    rig.observer.wait(
        lambda: len({sample.position[0] for sample in rig.samples[-200:]}) == 1, "rest"
    )
    stopped = rig.position
    assert stopped < 0.149
    assert rig.observer.call(SetBool, "/controller/enable", data=True).success
    rig.wait(0.5)
    assert abs(rig.position - stopped) < WITHIN
    rig.go(0.15)
