# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The definition of a ROS message type, as a bag carries it: full text and type hash."""

import importlib
import json
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from rodless_base.ros.share import share_directories

_TYPE_NAME = re.compile(r"(\w+)/(?:msg/)?(\w+)")
_FIELD_TYPE = re.compile(r"^[ \t]*([\w/]+)(?:\[[^\]]*\])?[ \t]+\w", re.MULTILINE)
_PRIMITIVE = re.compile(r"bool|byte|char|w?string|float(32|64)|u?int(8|16|32|64)")


@dataclass(frozen=True)
class MessageDefinition:
    """A message type: its text with every type it contains, and its hash (REP-2016)."""

    type_name: str
    encoding: str
    text: str
    type_hash: str


def message_class(type_name: str) -> type[Any]:
    """Return the Python class of a type; raises ModuleNotFoundError or AttributeError."""
    match = _TYPE_NAME.fullmatch(type_name)
    # A type name may come from anywhere; importing a module that is no ROS package runs it.
    if match is None or not any(map(Path.is_dir, share_directories(match[1]))):
        raise ModuleNotFoundError(f"{type_name} is no message type of an installed package")
    package, name = match.groups()
    found: type[Any] = getattr(importlib.import_module(f"{package}.msg"), name)
    return found


@cache
def message_definition(type_name: str) -> MessageDefinition:
    """Find the definition of e.g. ``sensor_msgs/msg/JointState`` among the installed packages.

    A type without an installed ``.msg`` file gets encoding ``unknown`` and no text, one without
    a ``.json`` file no hash: that is what rosbag2 records for them too.
    """
    try:
        encoding, text = "ros2msg", _full_text(type_name, set())
    except FileNotFoundError:
        encoding, text = "unknown", ""
    return MessageDefinition(type_name, encoding, text, _type_hash(type_name))


def _full_text(type_name: str, seen: set[str]) -> str:
    """Text of a type, followed by those of the types in it, each once, as rosbag2 joins them."""
    own = _installed_file(type_name, ".msg").read_text(encoding="utf-8")
    package = type_name.partition("/")[0]
    parts = [own]
    for contained in sorted(_contained_types(own, package)):
        if contained not in seen:
            seen.add(contained)
            parts.append(f"\n{'=' * 80}\nMSG: {contained}\n{_full_text(contained, seen)}")
    return "".join(parts)


def _contained_types(text: str, package: str) -> set[str]:
    names = {name for name in _FIELD_TYPE.findall(text) if not _PRIMITIVE.fullmatch(name)}
    return {name if "/" in name else f"{package}/{name}" for name in names}


def _type_hash(type_name: str) -> str:
    try:
        content = json.loads(_installed_file(type_name, ".json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return ""
    hashes = {entry["type_name"]: entry["hash_string"] for entry in content["type_hashes"]}
    return str(hashes.get(type_name, ""))


def _installed_file(type_name: str, suffix: str) -> Path:
    match = _TYPE_NAME.fullmatch(type_name)
    if match is None:
        raise FileNotFoundError(f"{type_name} is no message type")
    package, name = match.groups()
    for share in share_directories(package):
        path = share / "msg" / f"{name}{suffix}"
        if path.is_file():
            return path
    raise FileNotFoundError(f"no {suffix} file of {type_name} is installed")
