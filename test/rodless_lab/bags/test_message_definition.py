# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Definitions that go into a bag are those of the installed messages, complete and hashed."""

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rodless_lab.bags.message_definition import message_definition

TYPES = (
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/FluidPressure",
    "std_msgs/msg/Float64",
    "rosgraph_msgs/msg/Clock",
    "diagnostic_msgs/msg/DiagnosticArray",
    "rcl_interfaces/msg/ParameterEvent",
)


@pytest.mark.parametrize("name", TYPES)
def test_an_independent_reader_derives_the_same_hash_from_the_text(name: str) -> None:
    """The text names every type inside the type, and our hash is the one that follows from it."""
    definition = message_definition(name)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition.text, name))
    assert definition.encoding == "ros2msg"
    assert definition.type_hash == store.hash_rihs01(name)


def test_types_inside_are_appended_once_each_in_the_manner_of_rosbag2() -> None:
    """A header and the time in it follow the joint state, behind the separators rosbag2 uses."""
    text = message_definition("sensor_msgs/msg/JointState").text
    separators = [line for line in text.splitlines() if line.startswith("MSG: ")]
    assert separators == ["MSG: std_msgs/Header", "MSG: builtin_interfaces/Time"]
    assert f"\n{'=' * 80}\nMSG: std_msgs/Header\n" in text


def test_an_unknown_type_is_recorded_as_unknown() -> None:
    """A type nobody installed here gets no text and no hash rather than an error."""
    definition = message_definition("no_such_package/msg/Thing")
    assert (definition.encoding, definition.text, definition.type_hash) == ("unknown", "", "")


def test_packages_are_found_by_ament_prefix_path(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package without a Python module beside it is found where a sourced workspace says."""
    folder = tmp_path / "share" / "somebodys_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Reading.msg").write_text("float64[<=3] values  # V\nstring<=5 name\nuint8 ON=1\n")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    definition = message_definition("somebodys_msgs/msg/Reading")
    assert definition.text.startswith("float64[<=3] values")
    assert "MSG:" not in definition.text
