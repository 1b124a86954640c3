# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages as CDR, the bytes that go over the wire, written and read without rclpy's conversion.

From Python a conversion costs several times the rest of publishing or taking a small message.
"""

import math
import struct
from enum import Enum
from typing import Any

from rclpy.serialization import deserialize_message
from std_msgs.msg import Float64

from rodless_base.constants import NANOSECONDS_PER_SECOND

# What a message begins with: it is in plain CDR, in little-endian order.
ENCAPSULATION = b"\x00\x01\x00\x00"

_STAMP = struct.Struct("<iI")
_NUMBER = struct.Struct("<d")


class Field(Enum):
    """What changes from message to message, by its format."""

    STAMP = "iI"  # a builtin_interfaces/Time: s and ns
    NUMBER = "d"


class Layout:
    """Messages that differ in a few fields only.

    Its padding is zero, where rclpy leaves what was in memory.

    Examples
    --------
    >>> Layout(Field.STAMP, "air", Field.NUMBER).pack(1, 2, 0.5).hex(" ", 4)
    '00010000 01000000 02000000 04000000 61697200 0000e03f'
    """

    def __init__(self, *parts: Field | str | int) -> None:
        """Describe the fields of a message, one after the other.

        A text and an integer, such as the length of a sequence, are the same in every message.
        """
        self._constants: list[bytes | float] = []
        self._format = "<"
        self._size = 0
        constant = ENCAPSULATION
        for part in parts:
            if isinstance(part, Field):
                constant += self._padding(constant, 8 if part is Field.NUMBER else 4)
                for kind in part.value:
                    self._append(constant, kind)
                    constant = b""
            else:
                constant += self._padding(constant, 4)
                constant += _constant(part)
        if constant:
            self._append(constant, "")
        self._struct = struct.Struct(self._format)

    def _padding(self, constant: bytes, alignment: int) -> bytes:
        # Counted from behind the encapsulation.
        return bytes(-(self._size + len(constant) - len(ENCAPSULATION)) % alignment)

    def _append(self, constant: bytes, kind: str) -> None:
        self._format += f"{len(constant)}s{kind}"
        self._constants += [constant, 0.0] if kind else [constant]
        self._size = struct.calcsize(self._format)

    def pack(self, *values: float) -> bytes:
        """Return the message with these ``values``; a stamp is two, s and ns."""
        fields = self._constants.copy()
        fields[1::2] = values
        return self._struct.pack(*fields)


def _constant(part: str | int) -> bytes:
    if isinstance(part, int):
        return struct.pack("<I", part)
    text = part.encode() + b"\x00"
    return struct.pack("<I", len(text)) + text


_FLOAT64 = Layout(Field.NUMBER)


def pack_float64(value: float) -> bytes:
    """Return a std_msgs/Float64."""
    return _FLOAT64.pack(value)


def unpack_float64(data: bytes) -> float:
    """Return what a std_msgs/Float64 holds, NaN for bytes that are no such message."""
    if len(data) == len(ENCAPSULATION) + _NUMBER.size and data.startswith(ENCAPSULATION):
        return unpack_number(data, len(ENCAPSULATION))
    message = deserialised(data, Float64)
    return math.nan if message is None else float(message.data)


def deserialised(data: bytes, kind: Any) -> Any:
    """Return the message of type ``kind``, or None for bytes that are none.

    rclpy does not say which errors it raises for those.
    """
    try:
        return deserialize_message(data, kind)
    except Exception:
        return None


def unpack_number(data: bytes, offset: int) -> float:
    """Return the number at ``offset`` of a message with the ``ENCAPSULATION`` of this module."""
    number: float = _NUMBER.unpack_from(data, offset)[0]
    return number


def unpack_stamp(data: bytes) -> int:
    """Return the stamp (ns) that such a message begins with."""
    seconds, nanoseconds = _STAMP.unpack_from(data, len(ENCAPSULATION))
    return int(seconds * NANOSECONDS_PER_SECOND + nanoseconds)
