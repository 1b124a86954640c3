# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lock-step without DDS: whatever comes first, the run is that of the law and the rig alone."""

import random
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from outgoing import Outgoing
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.measurement import Measurement
from rodless_base.ros.cdr import unpack_float64
from rodless_base.ros.message_info import delivered_now
from rodless_base.ros.topics import set_stamp
from rodless_control import ControllerParameters
from rodless_control.loop import ControlLoop
from rodless_control.node.controller_node import ControllerNode
from rodless_lab.session.observer import Observer
from rodless_sim import Rig, RigParameters
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.physics.state import State

pytestmark = pytest.mark.ros

TIMEOUT = 1.0
PERIOD = 1e-3
POSITION = "position"

# What the controller is told in a run, in this order.
CHANGES: list[dict[str, Any]] = [
    {"controller.kp": 900.0},
    {"controller.law": "state_feedback"},
    {"state_feedback.velocity_gain": 60.0},
    {"controller.law": "pid", "controller.kp": 900.0},
]


def message_of(seen: Measurement, field: str) -> bytes:
    """Return the message that the plant sends of a reading."""
    value = getattr(seen, field)
    if field == POSITION:
        message = JointState(name=["carriage"], position=[value])
    else:
        message = FluidPressure(fluid_pressure=value)
    set_stamp(message.header.stamp, seen.stamp)
    return bytes(serialize_message(message))


class Wires:
    """A plant and a controller, and what is on its way between them, topic by topic."""

    def __init__(self, controller: ControllerNode) -> None:
        self.controller = controller
        self.clock = 0.0
        self.held: list[float] = []  # the command of each step, V
        self.asked: list[int] = []  # the stamps that the law was asked for, ns
        self.on_its_way: dict[str, deque[bytes]] = {POSITION: deque()}
        self.commands: deque[float] = deque()
        self.sent = 0
        answers = controller._answers
        answers._plant_waits = lambda: True
        answers._outbox.send = lambda _to, data: self.commands.append(unpack_float64(data))
        self._watch(controller._loop)
        self.engine = Engine(RigParameters({"time.mode": "lockstep"}), self._publish)
        self.plant = Lockstep(
            self.engine,
            TIMEOUT,
            lambda: True,
            lambda: {b"1": "/controller"},
            lambda: 1,
            Outgoing(),
            lambda: self.clock,
        )

    def _watch(self, loop: ControlLoop) -> None:
        sample = loop.sample

        def noted(measurement: Measurement) -> Any:
            self.asked.append(measurement.stamp)
            return sample(measurement)

        loop.sample = noted  # type: ignore[method-assign]

    def _publish(self, seen: Measurement, state: State) -> None:
        if seen.stamp > self.stamp_of_steps:
            self.held.append(state.voltage)
        for field, waiting in self.on_its_way.items():
            waiting.append(message_of(seen, field))

    @property
    def stamp_of_steps(self) -> int:
        """The time of the last step that has been noted, in ns."""
        return round(len(self.held) * PERIOD * 1e9)

    def change(self, changes: dict[str, Any]) -> None:
        """Tell the controller; what it subscribes to or gives up is connected at once, or not."""
        node = self.controller.node
        wanted = [Parameter(name, value=value) for name, value in changes.items()]
        assert all(result.successful for result in node.set_parameters(wanted))

    def connect(self) -> None:
        """Let the plant find what the controller subscribes to by now."""
        fields = {POSITION, *self.controller._inputs._pressures}
        self.on_its_way = {field: self.on_its_way.get(field, deque()) for field in fields}

    def deliver(self, field: str) -> None:
        """Bring the next message of a topic."""
        message = self.on_its_way[field].popleft()
        inputs = self.controller._inputs
        if field == POSITION:
            inputs._take_joint(message, delivered_now(1))
        else:
            inputs._pressure_taker(field)((message, delivered_now(1)))

    def answer(self) -> None:
        """Bring the next command."""
        self.sent += 1
        self.plant.receive(self.commands.popleft(), self.sent)

    def may_wait(self, since: int) -> bool:
        """Whether time may pass: not where an answer is on its way, or one of two has come.

        So long apart they are no answers to one sample any more, see docs/reliability.md. What the
        plant has sent may be late once for each sample; ``since`` is that of the last time.
        """
        is_quiet = not any(self.on_its_way.values())
        may_be_late = since < len(self.held) and not self.plant._is_between_answers
        return not self.commands and (is_quiet or may_be_late)

    def wait(self, seconds: float) -> None:
        """Let nothing come for a while; the plant looks around every 20 ms."""
        for _ in range(round(seconds / 0.02)):
            self.clock += 0.02
            self.plant.poll()


@pytest.fixture
def wires(observer: Observer) -> Iterator[Wires]:
    """Return them with the paper's PID."""
    controller = ControllerNode(
        context=observer.context,
        namespace="/any_order",
        parameter_overrides=[Parameter("use_sim_time", value=True)],
    )
    controller._inputs.subscribe()
    yield Wires(controller)
    controller.node.destroy_node()


def alone(changes_at: list[int], count: int) -> list[float]:
    """Return the commands (V) of ``count`` samples, each change made before that of its place."""
    values = ControllerParameters()
    loop, rig = ControlLoop(values), Rig(RigParameters())
    loop.setpoints.receive(0.1)
    commands: list[float] = []
    for k in range(count):
        for change in (one for one, at in zip(CHANGES, changes_at, strict=True) if at == k):
            law = change.get("controller.law")
            values = (
                ControllerParameters.for_law(str(law))(change)
                if law
                else values.with_values(change)
            )
            apply: Callable[[ControllerParameters], None] = (
                loop.change_law if law else loop.configure
            )
            apply(values)
        output = loop.sample(rig.read())
        assert output is not None
        commands.append(output.voltage)
        rig.advance(output.voltage, PERIOD)
    return commands


@pytest.mark.parametrize("seed", range(20))
def test_each_sample_is_answered_once_by_the_law_in_whatever_order_messages_come(
    wires: Wires, seed: int
) -> None:
    """Topics overtake each other, samples are offered again, gains and law change anywhere.

    Each step is made with the law's answer to its own sample, to the bit that of a loop without
    messages that is changed before the same sample.
    """
    chance = random.Random(seed)
    wires.controller._loop.setpoints.receive(0.1)
    wires.plant.poll()
    changes_at: list[int] = []
    waited_at = -1
    while len(wires.held) < 60:
        waiting = [field for field, messages in wires.on_its_way.items() if messages]
        draw = chance.random()
        if draw < 0.5 and waiting:
            wires.deliver(chance.choice(waiting))
        elif draw < 0.8 and wires.commands:
            wires.answer()
        elif draw < 0.85:
            wires.connect()
        elif draw < 0.9 and len(wires.held) >= 10 * (len(changes_at) + 1):
            if len(changes_at) < len(CHANGES):
                wires.change(CHANGES[len(changes_at)])
                changes_at.append(len(wires.asked))
        elif wires.may_wait(since=waited_at):
            waited_at = len(wires.held)
            wires.wait(chance.choice([0.1, 1.2, 2.5]))
    assert len(changes_at) == len(CHANGES)
    assert wires.asked[:60] == [round(k * PERIOD * 1e9) for k in range(60)]
    assert wires.held[:60] == alone(changes_at, 60)
