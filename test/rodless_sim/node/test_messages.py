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
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.measurement import Measurement
from rodless_sim.node import messages


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
