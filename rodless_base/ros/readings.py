# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Readings out of messages as they come over the wire: stamp and number, and nothing else.

Messages of one publisher begin alike, stamp aside: from the second on only two fields are looked
at. One that begins otherwise is deserialised by rclpy.
"""

import math
from typing import Any, NamedTuple

from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.ros.cdr import ENCAPSULATION, deserialised, unpack_number, unpack_stamp
from rodless_base.ros.joint import joint_position
from rodless_base.ros.topics import stamp_nanoseconds

# Where the stamp of a header ends.
_AFTER_STAMP = len(ENCAPSULATION) + 8


class Reading(NamedTuple):
    """A number of a message, and its stamp (ns)."""

    stamp: int
    value: float


class _Remembered:
    """Where the number stands in messages that begin like the last that was deserialised."""

    def __init__(self) -> None:
        """Know of none."""
        self._head = b""
        self._offset = self._start = self._length = 0

    def find(self, data: bytes) -> Reading | None:
        """Return the reading of a message that begins like that one."""
        if (
            len(data) != self._length
            or data[_AFTER_STAMP : self._start] != self._head
            or not data.startswith(ENCAPSULATION)
        ):
            return None
        return Reading(unpack_stamp(data), unpack_number(data, self._offset))

    def remember(self, data: bytes, reading: Reading, start: int, index: int = 0) -> None:
        """Take note that the numbers of ``data`` begin at ``start``, the reading's at ``index``."""
        self._head = data[_AFTER_STAMP:start]
        self._start, self._offset, self._length = start, start + 8 * index, len(data)
        # What is not where it should be is deserialised each time.
        if self._length < self._offset + 8 or not _same(self.find(data), reading):
            self._length = 0


class PressureReader:
    """Reads sensor_msgs/FluidPressure, in Pa."""

    def __init__(self) -> None:
        """Expect messages of any publisher."""
        self._remembered = _Remembered()

    def read(self, data: bytes) -> Reading | None:
        """Return the reading of a message, or None for bytes that are none."""
        found = self._remembered.find(data)
        if found is not None:
            return found
        message = deserialised(data, FluidPressure)
        if message is None:
            return None
        found = Reading(stamp_nanoseconds(message.header.stamp), float(message.fluid_pressure))
        self._remembered.remember(data, found, _numbers_start(message))
        return found


class PositionReader:
    """Reads the position of one joint in sensor_msgs/JointState, in m."""

    def __init__(self) -> None:
        """Expect messages of any publisher."""
        self._remembered = _Remembered()
        self._joint: str | None = None

    def read(self, data: bytes, joint: str) -> Reading | None:
        """Return the reading of ``joint``, or None for a message that does not have it."""
        if joint != self._joint:
            self._joint, self._remembered = joint, _Remembered()
        found = self._remembered.find(data)
        if found is not None:
            return found
        message = deserialised(data, JointState)
        position = None if message is None else joint_position(message, joint)
        if position is None:
            return None
        found = Reading(stamp_nanoseconds(message.header.stamp), position)
        start = _numbers_start(message, message.name)
        self._remembered.remember(data, found, start, list(message.name).index(joint))
        return found


def _numbers_start(message: Any, names: Any = None) -> int:
    """Return the offset of the first number behind a header, or behind ``names`` and a length."""
    size = 8 + _text_size(message.header.frame_id)
    if names is not None:
        size = _aligned(size, 4) + 4
        for name in names:
            size = _aligned(size, 4) + _text_size(name)
        size = _aligned(size, 4) + 4
    return len(ENCAPSULATION) + _aligned(size, 8)


def _text_size(text: str) -> int:
    return 4 + len(text.encode()) + 1


def _aligned(size: int, alignment: int) -> int:
    return size + -size % alignment


def _same(found: Reading | None, reading: Reading) -> bool:
    if found is None or found.stamp != reading.stamp:
        return False
    return found.value == reading.value or (math.isnan(found.value) and math.isnan(reading.value))
