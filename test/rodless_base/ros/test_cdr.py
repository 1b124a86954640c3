# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""CDR written and read by hand against rclpy's own."""

import math
import random
import struct

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header

from rodless_base.ros.cdr import (
    ENCAPSULATION,
    Field,
    Layout,
    pack_float64,
    unpack_float64,
    unpack_number,
    unpack_stamp,
)

VALUES = (0.0, -0.0, 5.05, -1e-300, 1e300, math.inf, -math.inf, math.nan)


@pytest.mark.parametrize("value", VALUES)
def test_a_float64_is_rclpys_to_the_byte_and_back(value: float) -> None:
    """Negative zero, infinities and NaN too."""
    data = pack_float64(value)
    assert data == serialize_message(Float64(data=value))
    assert struct.pack("<d", unpack_float64(data)) == struct.pack("<d", value)


def test_a_float64_of_the_other_byte_order_is_read_too() -> None:
    """A publisher on another machine may send big-endian."""
    data = b"\x00\x00\x00\x00" + struct.pack(">d", 5.5)
    assert deserialize_message(data, Float64).data == 5.5
    assert unpack_float64(data) == 5.5


@pytest.mark.parametrize("data", [b"", b"\x00\x01", b"\x00\x01\x00\x00\x00\x00"])
def test_bytes_that_are_no_float64_are_no_number(data: bytes) -> None:
    """A command that is cut off closes the valve, as one that is no number does."""
    assert math.isnan(unpack_float64(data))


@pytest.mark.parametrize("frame", ["", "a", "ab", "abc", "abcd", "left/chamber_a", "ü"])
@pytest.mark.parametrize("joint", ["", "j", "jo", "joi", "join", "left/carriage"])
def test_texts_of_all_lengths_are_padded_as_rclpy_pads_them(frame: str, joint: str) -> None:
    """What is packed means what was put in; only padding may differ, and is 0.

    rclpy leaves room behind some messages, as where a sequence is empty; this does not.
    """
    number = Field.NUMBER
    layout = Layout(Field.STAMP, frame, 1, joint, 2, number, number, 0, 1, number)
    generator = random.Random(frame + joint)
    for _ in range(20):
        seconds, nanoseconds = generator.randrange(-(2**31), 2**31), generator.randrange(2**32)
        first, second, third = (generator.uniform(-1e9, 1e9) for _ in range(3))
        data = layout.pack(seconds, nanoseconds, first, second, third)
        header = Header(frame_id=frame)
        header.stamp.sec, header.stamp.nanosec = seconds, nanoseconds
        message = JointState(header=header, name=[joint], position=[first, second], effort=[third])
        assert deserialize_message(data, JointState) == message
        expected = serialize_message(message)
        assert len(data) <= len(expected)
        assert all(ours in (theirs, 0) for ours, theirs in zip(data, expected, strict=False))
        assert unpack_stamp(data) == seconds * 10**9 + nanoseconds
        assert unpack_number(data, len(data) - 8) == third


def test_what_never_changes_may_come_last() -> None:
    """As the lengths of empty sequences do."""
    data = Layout(Field.STAMP, "", 0, 0, 0, 0).pack(1, 2)
    assert data.startswith(ENCAPSULATION)
    message = deserialize_message(data, JointState)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 2)
    assert not any((message.name, message.position, message.velocity, message.effort))


def test_another_number_of_values_is_refused() -> None:
    """Rather than written into the wrong fields."""
    for values in ((1, 2), (1, 2, 3.0, 4.0)):
        with pytest.raises(ValueError, match="size"):
            Layout(Field.STAMP, "air", Field.NUMBER).pack(*values)
