# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ROS messages of any type, with odd contents of the right types."""

import re
from collections.abc import Sequence
from functools import cache
from typing import Any

from draw import Draw

from rodless_lab.bags import message_definition

_SEQUENCE = re.compile(r"(?:sequence<(?P<many>[^,>]+).*>|(?P<some>[^\[]+)\[(?P<count>\d+)\])")
_INTEGER = re.compile(r"(?P<sign>u?)int(?P<bits>\d+)")

# Which looks for the type's file each time.
message_class = cache(message_definition.message_class)


def odd_message(draw: Draw, kind: Any, texts: Sequence[str]) -> Any:
    """Return a message or request of ``kind``; ``texts`` mean something to who receives it."""
    message = kind()
    for name, type_name in kind.get_fields_and_field_types().items():
        # What is left as it was is what most senders leave.
        if draw.random() < 0.75:
            setattr(message, name, _value(draw, type_name, texts))
    return message


def _value(draw: Draw, type_name: str, texts: Sequence[str]) -> Any:
    if found := _SEQUENCE.fullmatch(type_name):
        count = int(found["count"] or draw.choice((0, 1, 1, 1, 2, 3, 9)))
        return [_value(draw, found["many"] or found["some"], texts) for _ in range(count)]
    if integer := _INTEGER.fullmatch(type_name):
        return _integer(draw, int(integer["bits"]), signed=not integer["sign"])
    if type_name.startswith("string"):
        text = draw.text(texts)
        return text.encode("utf-8", "replace").decode("utf-8").replace("\0", "")
    simple = {
        "double": draw.float,
        "float": lambda: draw.float() % 1e30,
        "boolean": lambda: draw.random() < 0.5,
        "octet": lambda: draw.randbytes(1),
    }
    if type_name in simple:
        return simple[type_name]()
    package, name = type_name.split("/")
    return odd_message(draw, message_class(f"{package}/msg/{name}"), texts)


def _integer(draw: Draw, bits: int, signed: bool) -> int:
    if bits == 8 and draw.random() < 0.7:
        return draw.randrange(11)  # most are codes
    low = -(2 ** (bits - 1)) if signed else 0
    return draw.integer(low, low + 2**bits - 1)
