# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the plant says of its instruments and its valve, as rclpy reads it."""

import random
from typing import Any

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState, Temperature

from rodless_base.measurement import Measurement
from rodless_sim import Rig, RigParameters
from rodless_sim.node import messages
from rodless_sim.node.further_publishers import joints
from rodless_sim.node.plant_diagnostics import carriage_lost
from rodless_sim.physics.state import piston_of


def stamped(message: Any, nanoseconds: int) -> Any:
    """Return ``message`` with a stamp, set field by field."""
    stamp = message.clock if isinstance(message, Clock) else message.header.stamp
    stamp.sec, stamp.nanosec = nanoseconds // 10**9, nanoseconds % 10**9
    return message


def means(data: bytes, message: Any) -> bool:
    """Whether ``data`` is ``message``, and no longer than rclpy makes it."""
    as_short = len(data) <= len(serialize_message(message))
    return as_short and bool(deserialize_message(data, type(message)) == message)


@pytest.mark.parametrize("prefix", ["", "left/", "x"])
def test_messages_hold_what_they_are_made_of(prefix: str) -> None:
    """Each field in its place, in every digit, for random values and names of all lengths."""
    generator = random.Random(prefix)
    joint_states = messages.joint_states(f"{prefix}carriage")
    valve_states = messages.valve_states(f"{prefix}valve_spool")
    pressures = messages.pressures(f"{prefix}chamber_a")
    for _ in range(100):
        time = generator.randrange(10**13)
        position, velocity, variance, voltage = (generator.uniform(-10.0, 10.0) for _ in range(4))
        a, b, supply = (generator.uniform(1e5, 7e5) for _ in range(3))
        joint = JointState(name=[f"{prefix}carriage"], position=[position], velocity=[velocity])
        joint.effort = [5e-4 * (a - b)]
        read = Measurement(time, position, a, b, supply)
        assert means(joint_states(read, velocity, 5e-4), stamped(joint, time))
        valve = valve_states(voltage, voltage, time)
        spool = JointState(name=[f"{prefix}valve_spool"], effort=[voltage])
        spool.position = deserialize_message(valve, JointState).position
        assert means(valve, stamped(spool, time))
        pressure = FluidPressure(fluid_pressure=supply, variance=variance)
        pressure.header.frame_id = f"{prefix}chamber_a"
        assert means(pressures(supply, variance, time), stamped(pressure, time))
        assert means(messages.clock(time), stamped(Clock(), time))


def test_a_piston_of_its_own_is_a_second_joint() -> None:
    """Behind the carriage, with its own place and speed and the same force of the air."""
    joint_states = messages.joint_states("carriage", "piston")
    read = Measurement(1_500_000_000, 0.1, 4e5, 3e5, 6e5)
    message = deserialize_message(joint_states(read, 0.02, 5e-4, 0.101, 0.03), JointState)
    assert list(message.name) == ["carriage", "piston"]
    assert list(message.position) == [0.1, 0.101]
    assert list(message.velocity) == [0.02, 0.03]
    assert list(message.effort) == pytest.approx([50.0, 50.0])
    magnetic = RigParameters({"coupling.kind": "magnetic", "frame_prefix": "left/"})
    assert joints(magnetic) == ("left/carriage", "left/piston")
    assert joints(RigParameters()) == ("carriage",)
    assert piston_of(Rig(magnetic).state) == (0.0, 0.0)
    assert piston_of(Rig().state) == ()


def test_temperatures_are_in_degrees_celsius() -> None:
    """As sensor_msgs/Temperature is defined; its variance is 0, unknown."""
    message = deserialize_message(
        messages.temperatures("chamber_a")(293.15, 2_000_000_001), Temperature
    )
    assert message.temperature == pytest.approx(20.0)
    assert message.variance == 0.0
    assert message.header.frame_id == "chamber_a"
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (2, 1)


def test_a_lost_carriage_is_said() -> None:
    """Where both are, once they have parted; nothing of a rig without magnets."""
    assert carriage_lost(Rig().state) is None
    rig = Rig(RigParameters({"coupling.kind": "magnetic"}))
    assert carriage_lost(rig.state) is None
    lost = rig.state._replace(coupled=0.0, position=0.05, piston_position=0.2)  # type: ignore[call-arg]
    assert carriage_lost(lost) == "carriage lost: it is at 50.0 mm, the piston at 200.0 mm"


def test_the_state_of_the_valve_is_in_metres_and_volts() -> None:
    """At 10 V the spool of eq. (24) stands 1.0635 mm from its middle; at 5.05 V it stands there."""
    valve_states = messages.valve_states()
    state = deserialize_message(valve_states(10.0, 10.0, 1_234_567_890), JointState)
    assert (state.header.stamp.sec, state.header.stamp.nanosec) == (1, 234_567_890)
    assert list(state.name) == ["valve_spool"]
    assert list(state.effort) == [10.0]
    assert abs(state.position[0] - 1.06351e-3) < 1e-12
    assert abs(deserialize_message(valve_states(5.05, 6.0, 0), JointState).position[0]) < 1e-8
    assert not state.velocity
