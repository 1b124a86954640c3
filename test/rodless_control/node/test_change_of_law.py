# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Another law for a controller that runs: it starts anew, and what is refused changes nothing."""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_srvs.srv import SetBool, Trigger

from rodless_base.measurement import Measurement
from rodless_base.parameters import ParameterError
from rodless_base.ros.cdr import pack_float64
from rodless_base.ros.message_info import delivered_now
from rodless_base.ros.topics import set_stamp
from rodless_control import ControllerParameters, ReferencePoint
from rodless_control.laws import law_class
from rodless_control.node import telemetry
from rodless_control.node.controller_node import ControllerNode
from rodless_control.node.law_parameters import LawChoice
from rodless_lab.session.observer import Observer

pytestmark = pytest.mark.ros

LAW = "controller.law"
NEUTRAL = 5.08
SUPPLY_PRESSURE = "supply/pressure"
PRESSURES = {"pressure_a": 3.5e5, "pressure_b": 3.6e5, "supply_pressure": 6.2e5}

# What the node is given at its start, to the PID and to another law.
GIVEN = {"controller.kp": 700.0, "sliding_mode.boundary_layer": 1.5e-3}


class Bench:
    """A controller in this process that nothing spins, and the commands it sends."""

    def __init__(self, controller: ControllerNode) -> None:
        self.controller = controller
        self.commands: list[bytes] = []
        outbox = controller._answers._outbox
        outbox.send = lambda _publisher, message: self.commands.append(message)

    def change(self, changes: dict[str, Any]) -> str | None:
        """Set parameters as one change, as the service does; return why not, if it is refused."""
        wanted = [Parameter(name, value=value) for name, value in changes.items()]
        try:
            result = self.controller.node.set_parameters_atomically(wanted)
        except ParameterNotDeclaredException as error:
            return str(error)
        return None if result.successful else str(result.reason)

    @property
    def parameters(self) -> dict[str, object]:
        """What the node shows."""
        node = self.controller.node
        names = node.list_parameters([], 0).names
        return {one.name: one.value for one in node.get_parameters(names)}

    @property
    def topics(self) -> set[str]:
        """What the node publishes below its name."""
        own = "/changing/controller/"
        names = {publisher.topic_name for publisher in self.controller.node.publishers}
        return {name.removeprefix(own) for name in names if name.startswith(own)}

    def take(self, measurement: Measurement) -> None:
        """Give a whole measurement."""
        self.controller._answers.take(measurement, delivered_now(1))

    def take_position(self, stamp: int, position: float) -> None:
        """Give a message with the carriage's position."""
        message = JointState(name=["carriage"], position=[position])
        set_stamp(message.header.stamp, stamp)
        self.controller._inputs._take_joint(serialize_message(message), delivered_now(1))

    def take_pressures(self, stamp: int) -> None:
        """Give a message with each pressure."""
        for field, value in PRESSURES.items():
            message = FluidPressure(fluid_pressure=value)
            set_stamp(message.header.stamp, stamp)
            taker = self.controller._inputs._pressure_taker(field)
            taker((serialize_message(message), delivered_now(1)))


@pytest.fixture
def bench(observer: Observer) -> Iterator[Bench]:
    """Return a controller with the PID, which has begun to take positions."""
    given = [Parameter(name, value=value) for name, value in GIVEN.items()]
    controller = ControllerNode(
        context=observer.context, namespace="/changing", parameter_overrides=given
    )
    controller._inputs.subscribe()
    yield Bench(controller)
    controller.node.destroy_node()


def test_a_law_has_its_own_parameters_and_topics(bench: Bench) -> None:
    """Given with the law, given at the start, or default; the PID finds its gain as it was."""
    assert bench.change({"controller.kd": 50.0}) is None
    assert bench.change({LAW: "state_feedback", "state_feedback.velocity_gain": 60.0}) is None
    now = bench.parameters
    assert now[LAW] == "state_feedback"
    assert now["state_feedback.velocity_gain"] == 60.0
    assert not law_class("pid").PARAMETERS.keys() & now.keys()
    assert law_class("state_feedback").PARAMETERS.keys() <= now.keys()
    assert bench.topics == {"reference", *law_class("state_feedback").TERMS}
    assert bench.change({LAW: "sliding_mode"}) is None
    assert bench.parameters["sliding_mode.boundary_layer"] == 1.5e-3
    assert bench.change({LAW: "pid"}) is None
    now = bench.parameters
    assert (now["controller.kp"], now["controller.kd"]) == (700.0, 50.0)
    assert bench.topics == {"reference", *law_class("pid").TERMS}
    assert bench.change({"controller.kp": 800.0}) is None
    assert bench.controller._loop.law.parameters["controller.kp"] == 800.0


def test_another_law_starts_as_after_a_reset(bench: Bench) -> None:
    """It holds the carriage where it is, by commands that are those of the law in Python."""
    bench.controller._loop.setpoints.receive(0.09)
    positions = 0.05 + 1e-4 * np.sin(np.arange(50))
    for k, position in enumerate(positions[:20]):
        bench.take(Measurement(k * 1_000_000, float(position)))
    bench.commands.clear()
    assert bench.change({LAW: "adrc"}) is None
    # Loading a law takes a while: what the valve is left with closes it.
    assert bench.commands == [pack_float64(NEUTRAL)]
    law, held = law_class("adrc")(), ReferencePoint(float(positions[20]))
    for k, position in enumerate(positions[20:], 20):
        measurement = Measurement(k * 1_000_000, float(position))
        bench.take(measurement)
        expected: Any = law.update(measurement, held, 1e-3 if k > 20 else 0.0)
        assert bench.commands[-1] == pack_float64(expected.voltage), k
    assert len(set(bench.commands)) > 10


def test_in_lock_step_nobody_has_asked_for_a_command(bench: Bench) -> None:
    """A lock-step plant counts commands: one between two samples is one too many."""
    assert bench.change({"use_sim_time": True}) is None
    assert bench.change({LAW: "adrc"}) is None
    assert bench.commands == []


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({LAW: "os:path"}, "controller.law: 'os:path' refused, must be pid, state_feedback, "),
        ({LAW: 5}, "controller.law: 5 refused, must be pid, "),
        ({LAW: "adrc", "adrc.bandwidth": -1.0}, "adrc.bandwidth: -1.0 refused, must be from 1"),
        ({LAW: "adrc", "adrc.band": 20.0}, "adrc.band: no such parameter"),
        ({LAW: "adrc", "controller.kp": 20.0}, "controller.kp: belongs to the law pid"),
        ({LAW: "adrc", "controller.recorders": 5}, "controller.recorders: read-only"),
        ({LAW: "adrc", "reference.minimum": 1.0}, "reference.minimum: 1 m refused"),
        ({"adrc.bandwidth": 20.0}, "adrc.bandwidth: belongs to the law adrc"),
    ],
)
def test_what_is_refused_changes_nothing(
    bench: Bench, changes: dict[str, Any], reason: str
) -> None:
    """Parameters, topics and the law that controls are as before, and it goes on."""
    bench.take(Measurement(0, 0.05))
    before, topics, law = bench.parameters, bench.topics, bench.controller._loop.law
    refusal = bench.change(changes)
    assert refusal is not None
    assert refusal.startswith(reason)
    assert (bench.parameters, bench.topics) == (before, topics)
    assert bench.controller._loop.law is law
    assert len(bench.commands) == 1


def test_a_law_whose_pressures_cannot_be_had_is_refused(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a security policy: the law before goes on, and answers positions alone."""
    node = bench.controller.node
    create, before = node.create_subscription, bench.parameters
    topics = bench.topics, {one.topic_name for one in node.subscriptions}

    def without_supply(kind: Any, topic: str, *others: Any, **options: Any) -> Any:
        if topic == SUPPLY_PRESSURE:
            raise rclpy_implementation.RCLError("not permitted")
        return create(kind, topic, *others, **options)

    monkeypatch.setattr(node, "create_subscription", without_supply)
    refused = bench.change({LAW: "state_feedback"})
    assert refused == f"{SUPPLY_PRESSURE} cannot be subscribed to: not permitted"
    assert bench.parameters == before
    assert (bench.topics, {one.topic_name for one in node.subscriptions}) == topics
    assert isinstance(bench.controller._loop.law, law_class("pid"))
    bench.controller._loop.setpoints.receive(0.09)
    bench.take_position(1_000_000, 0.05)
    assert bench.controller._answers.by_law
    assert bench.change({LAW: "adrc"}) is None


def test_until_pressures_come_the_valve_stays_closed(bench: Bench) -> None:
    """As the change has left it; then one command of the law to each whole sample."""
    assert bench.change({LAW: "state_feedback"}) is None
    assert bench.commands == [pack_float64(NEUTRAL)]
    bench.commands.clear()
    bench.take_position(1, 0.05)
    bench.take_position(2, 0.05)
    assert bench.commands == []
    bench.take_pressures(2)
    assert len(bench.commands) == 1
    assert bench.controller._answers.by_law
    bench.take_position(3, 0.05)
    assert len(bench.commands) == 1
    bench.take_pressures(3)
    assert len(bench.commands) == 2
    assert bench.controller._inputs.incomplete == 1
    assert bench.change({LAW: "pid"}) is None
    bench.take_position(4, 0.05)
    assert len(bench.commands) == 4  # one by the change


def test_disabled_or_after_an_error_of_its_own_it_closes_the_valve_at_once(bench: Bench) -> None:
    """No sample need come first: its source may be what has gone."""
    bench.take(Measurement(1, 0.05))
    for make_safe in (
        lambda: bench.controller._enable(SetBool.Request(data=False), SetBool.Response()),
        lambda: bench.controller.node.make_safe("a test"),
    ):
        bench.commands.clear()
        make_safe()
        assert bench.commands == [pack_float64(NEUTRAL)]


def test_a_sample_that_is_offered_again_is_answered_again(bench: Bench) -> None:
    """By a lock-step plant whose answer was lost: without an answer it would stand for good."""
    assert bench.change({LAW: "state_feedback"}) is None
    for offer in range(4):
        bench.commands.clear()
        bench.take_position(0, 0.05)
        bench.take_pressures(0)
        assert len(bench.commands) == 1, offer


@pytest.mark.parametrize("last", [5, 0])
def test_the_law_answers_each_sample_of_a_lock_step_plant_once(bench: Bench, last: int) -> None:
    """That of the change was sent without pressures: it is answered as it is offered again.

    Whichever of its messages come first, by the law alone; so is the next, which completes no other
    with what has come twice.
    """
    assert bench.change({"use_sim_time": True}) is None
    assert bench.change({LAW: "state_feedback"}) is None
    bench.take_position(last, 0.05)
    assert bench.commands == []
    bench.take_pressures(last)
    bench.take_position(last, 0.05)
    assert len(bench.commands) == 1
    for sample in range(last + 1, last + 4):
        bench.commands.clear()
        bench.take_pressures(sample)
        assert bench.commands == [], sample
        bench.take_position(sample, 0.05)
        assert len(bench.commands) == 1, sample
        assert bench.controller._answers.by_law
    assert bench.controller._inputs.incomplete == 0


@pytest.mark.parametrize("last", [5, 0])
def test_a_reset_at_the_sample_of_a_change_stops_no_lock_step_plant(
    bench: Bench, last: int
) -> None:
    """Sample 0 of the new run has an answer once it is offered again, all others have one."""
    assert bench.change({LAW: "state_feedback"}) is None
    bench.take_position(last, 0.05)
    bench.commands.clear()
    for _ in range(2):
        bench.take_pressures(0)
        bench.take_position(0, 0.05)
    assert bench.commands
    for sample in range(1, 8):
        bench.commands.clear()
        bench.take_pressures(sample)
        bench.take_position(sample, 0.05)
        assert len(bench.commands) == 1, sample
        assert bench.controller._answers.by_law, sample


def test_signals_of_the_law_before_wait_for_their_readers(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reader that is behind would lose what it has not read; one that has stopped waits 5 s."""
    of_pid, reader = set(law_class("pid").TERMS), {"has all": False}
    monkeypatch.setattr(telemetry, "wait_for_readers", lambda *_: reader["has all"])
    assert bench.change({LAW: "adrc"}) is None
    bench.controller._poll()
    assert of_pid < bench.topics
    assert bench.change({LAW: "pid"}) is None
    assert bench.change({LAW: "adrc"}) is None
    reader["has all"] = True
    bench.controller._poll()
    assert bench.topics == {"reference", *law_class("adrc").TERMS}
    reader["has all"] = False
    assert bench.change({LAW: "pid"}) is None
    monkeypatch.setattr(telemetry, "monotonic", lambda: time.monotonic() + telemetry.LEAVING)
    bench.controller._poll()
    assert bench.topics == {"reference", *of_pid}


def test_a_term_has_both_its_topics_or_none(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """A policy permits the throttled one alone: what nobody publishes is not to be sent later."""
    create = bench.controller.node.create_publisher

    def permitted(kind: Any, topic: str, *options: Any) -> Any:
        if topic.startswith("~/"):
            raise rclpy_implementation.RCLError("not permitted")
        return create(kind, topic, *options)

    monkeypatch.setattr(bench.controller.node, "create_publisher", permitted)
    refusal = bench.change({LAW: "adrc"})
    assert refusal is not None
    assert "cannot be published" in refusal
    own = bench.controller._answers.telemetry
    assert own._throttled.keys() == own._publishers.keys()


def test_a_law_that_fails_again_is_reported_again_and_not_enabled(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the log and in the answers, each time that it is asked for; healed, it is enabled."""
    answers, reports = bench.controller._answers, []
    answers.on_failure = lambda: reports.append(answers.failure)
    assert not answers.enable(False)

    def ask() -> SetBool.Response:
        return bench.controller._enable(SetBool.Request(data=True), SetBool.Response())

    with monkeypatch.context() as patch:
        patch.setattr(type(bench.controller._loop.law), "reset", None)
        for asked in range(1, 3):
            answer = ask()
            assert not answer.success
            assert not answers.enabled
            assert len(reports) == asked
            assert reports[-1] == answer.message
        said = bench.controller._reset(Trigger.Request(), Trigger.Response())
        assert (said.success, said.message) == (True, answer.message)
        assert len(reports) == 3
        counts = bench.controller._diagnostics._diagnostics.count()
        assert counts["failures of the law"] == 1  # since the reset
    assert "failed: TypeError" in answer.message
    assert answer.message.endswith("; valve closed until ~/enable")
    # Nothing that was refused has switched it on: not even a reset of the healed law does.
    said = bench.controller._reset(Trigger.Request(), Trigger.Response())
    assert (said.success, said.message, answers.enabled) == (True, "disabled: valve closed", False)
    answer = ask()
    assert (answer.success, answers.enabled) == (True, True)


@pytest.mark.parametrize(
    ("kind", "says"),
    [
        ("sine", "begins its sine anew, from its centre"),
        ("step", "goes to 0.06 m, before plant time 2 s to 0.01 m"),
        ("move", "holds where it is until a new set-point comes"),
    ],
)
@pytest.mark.parametrize("second", [1, 7])
def test_a_reset_says_where_the_reference_goes(
    bench: Bench, kind: str, says: str, second: int
) -> None:
    """And there it is: at the centre whatever the phase by plant time, at the step's by that."""
    values = {"reference.start": 0.01, "reference.target": 0.06, "reference.at": 2.0}
    assert bench.change({"reference.type": kind, "reference.centre": 0.08, **values}) is None
    for k in range(second):
        bench.take(Measurement(k * 1_000_000_000, 0.05))
    answer = bench.controller._reset(Trigger.Request(), Trigger.Response())
    assert answer.message == says
    position, _ = bench.controller._loop.setpoints.sample(second, 0.05)
    assert position == {"sine": 0.08, "step": 0.06 if second > 2 else 0.01, "move": 0.05}[kind]


def test_a_law_of_the_users_own_is_imported_at_the_start_alone() -> None:
    """No message makes a node import a module; the law it was started with can come back."""
    own = "rodless_control.laws.adrc:Adrc"
    choice = LawChoice({LAW: own, "adrc.bandwidth": 20.0}, own)
    values = ControllerParameters.for_law(own)({"adrc.bandwidth": 20.0})
    pid = choice.next(values, {LAW: "pid"})
    assert pid is not None
    back = choice.next(pid, {LAW: own})
    assert back is not None
    assert (pid[LAW], back[LAW], back["adrc.bandwidth"]) == ("pid", own, 20.0)
    assert choice.next(pid, {LAW: "pid", "controller.kp": 5.0}) is None
    with pytest.raises(ParameterError, match="start it with another law"):
        LawChoice({}, "pid").next(pid, {LAW: own})
