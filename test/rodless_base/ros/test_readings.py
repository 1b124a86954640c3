# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Readings taken from bytes against rclpy's deserialised messages."""

import math
import random
import struct
from unittest.mock import patch

import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from rodless_base.ros import readings
from rodless_base.ros.cdr import Field, Layout, deserialised
from rodless_base.ros.joint import joint_position
from rodless_base.ros.readings import PositionReader, PressureReader, Reading


def header(k: int, frame: str = "") -> Header:
    """A header of sample ``k`` at 1 kHz."""
    return Header(stamp=Time(sec=k // 1000, nanosec=k % 1000 * 1_000_000), frame_id=frame)


def random_joints(generator: random.Random, k: int) -> JointState:
    """A message with names, positions and the rest of any number and length."""
    names = generator.sample(["carriage", "a", "left/carriage", "gripper", "ü"], k=3)
    count = generator.choice([0, 1, 3])
    positions = [generator.uniform(-1.0, 1.0) for _ in range(generator.choice([count, 3]))]
    return JointState(
        header=header(k, generator.choice(["", "base", "world"])),
        name=names[:count],
        position=positions,
        velocity=positions[: generator.choice([0, len(positions)])],
    )


def test_positions_are_those_of_rclpy_whatever_comes() -> None:
    """Publishers of several kinds in turn; each message twice, the second time remembered."""
    generator = random.Random(7)
    reader = PositionReader()
    found = 0
    for k in range(500):
        message = random_joints(generator, k)
        expected = joint_position(message, "carriage")
        for _ in range(2):
            reading = reader.read(serialize_message(message), "carriage")
            assert reading == (None if expected is None else Reading(k * 1_000_000, expected))
        found += expected is not None
    assert 50 < found < 450


@pytest.mark.parametrize("names", [["carriage"], ["a", "carriage"], ["left/a", "b", "carriage"]])
def test_messages_that_begin_alike_are_deserialised_once(names: list[str]) -> None:
    """The other joints move as well; stamps, NaN and infinity arrive as they are.

    Padding is always 0 here; what rclpy leaves there may differ from message to message.
    """
    reader = PositionReader()
    with patch.object(readings, "deserialised", wraps=deserialised) as slow:
        for k, value in enumerate([0.1, 0.2, math.nan, math.inf, -0.0]):
            positions = [float(k)] * (len(names) - 1) + [value]
            numbers = [Field.NUMBER] * len(names)
            layout = Layout(Field.STAMP, "", len(names), *names, len(names), *numbers, 0, 0)
            reading = reader.read(layout.pack(0, k * 1_000_000, *positions), "carriage")
            assert reading is not None
            assert reading.stamp == k * 1_000_000
            assert struct.pack("d", reading.value) == struct.pack("d", value)
        assert slow.call_count == 1


def test_another_joint_is_looked_for_anew() -> None:
    """The name of the joint is a parameter."""
    data = serialize_message(JointState(name=["a", "b"], position=[1.0, 2.0]))
    reader = PositionReader()
    wanted = ["a", "b", "c", "a"]
    assert [reader.read(data, name) for name in wanted] == [(0, 1.0), (0, 2.0), None, (0, 1.0)]


def test_pressures_are_those_of_rclpy() -> None:
    """With frames of any length, and deserialised only where the frame changes."""
    reader = PressureReader()
    with patch.object(readings, "deserialised", wraps=deserialised) as slow:
        for frame in ("", "a", "abc", "chamber_a", "abc"):
            for k in range(3):
                layout = Layout(Field.STAMP, frame, Field.NUMBER, Field.NUMBER)
                data = layout.pack(0, k * 1_000_000, 1e5 + k, 0.0)
                assert deserialize_message(data, FluidPressure).fluid_pressure == 1e5 + k
                assert reader.read(data) == Reading(k * 1_000_000, 1e5 + k)
        assert slow.call_count == 5


def test_the_other_byte_order_is_left_to_rclpy() -> None:
    """Every time: nothing of it is taken for a message that begins alike."""
    reader = PressureReader()
    for k in range(3):
        text = struct.pack(">IB3x", 1, 0)
        data = (
            b"\x00\x00\x00\x00" + struct.pack(">iI", 0, k) + text + struct.pack(">dd", 1e5 + k, 0)
        )
        assert reader.read(data) == Reading(k, 1e5 + k)


@pytest.mark.parametrize(
    "data", [b"", b"\x00", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + b"\xff" * 9]
)
def test_bytes_that_are_no_message_have_no_reading(data: bytes) -> None:
    """Cut off or with lengths that lead nowhere; the next good message is read as ever."""
    pressures, positions = PressureReader(), PositionReader()
    assert pressures.read(data) is None
    assert positions.read(data, "carriage") is None
    good = FluidPressure(header=header(0, "chamber_a"), fluid_pressure=1e5)
    assert pressures.read(serialize_message(good)) == Reading(0, 1e5)
