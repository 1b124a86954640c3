# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs that another launch file includes below a PushRosNamespace, which launch_ros keeps aside."""

from pathlib import Path

import pytest
from launch_stand_in import Node, launch_nodes

from rodless_base.parameter_file import read_parameter_file
from rodless_sim import RigParameters

# A section for each namespace that the rig might be taken to be in.
SECTIONS = """
/left/plant: {ros__parameters: {supply.pressure: 500000.0}}
/right/plant: {ros__parameters: {supply.pressure: 450000.0}}
/cell/plant: {ros__parameters: {supply.pressure: 350000.0}}
/cell/left/plant: {ros__parameters: {supply.pressure: 400000.0, sensors.publish_raw: true}}
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "cells.yaml"
    path.write_text(SECTIONS, encoding="utf-8")
    return str(path)


def plant(nodes: list[Node]) -> RigParameters:
    """Return what the plant makes of the files; later ones win."""
    found: dict[str, object] = {}
    for path in nodes[0].parameters:
        found.update(read_parameter_file(path, "plant"))
    return RigParameters(found)


@pytest.mark.parametrize(
    ("pushed", "given", "full", "pressure"),
    [
        ("/cell", "left", "/cell/left", 4e5),
        ("/cell", "left/", "/cell/left", 4e5),
        ("/cell", "/left", "/left", 5e5),
        ("/cell", "", "/cell", 3.5e5),
        ("/", "right", "/right", 4.5e5),
        ("", "left", "/left", 5e5),
    ],
)
def test_the_sections_are_those_of_the_full_namespace(
    file: str, pushed: str, given: str, full: str, pressure: float
) -> None:
    """A file holds for the namespace in which launch_ros starts the nodes; one from / on wins."""
    nodes = launch_nodes("rig.launch.py", ros_namespace=pushed, namespace=given, parameters=file)
    assert {node.namespace for node in nodes} == {full}
    assert plant(nodes)["supply.pressure"] == pressure


def test_a_recorder_takes_what_the_plant_of_the_full_namespace_publishes(file: str) -> None:
    """The raw voltages, which only the section of that namespace switches on."""
    given = {"namespace": "left", "parameters": file, "record": "true"}
    (*_, recorder) = launch_nodes("rig.launch.py", ros_namespace="/cell", **given)
    assert "raw/voltages" in recorder.command
    (*_, recorder) = launch_nodes("rig.launch.py", **given)
    assert "raw/voltages" not in recorder.command


def test_both_of_two_rigs_below_a_pushed_namespace_have_their_sections(file: str) -> None:
    """The one that the file does not name there is refused, with its full namespace."""
    nodes = launch_nodes("two_rigs.launch.py", ros_namespace="/cell", left_parameters=file)
    assert [node.namespace for node in nodes] == ["/cell/left"] * 2 + ["/cell/right"] * 2
    assert plant(nodes[:2])["supply.pressure"] == 4e5
    with pytest.raises(RuntimeError, match="is for the plant or controller of namespace /cell/ri"):
        launch_nodes("two_rigs.launch.py", ros_namespace="/cell", right_parameters=file)


@pytest.mark.parametrize(
    ("pushed", "given", "its_own"),
    [
        ("/left", {}, True),
        ("/cell", {"namespace": "left"}, True),
        ("/left", {"publish_clock": "true"}, False),
        ("/cell", {"namespace": "/"}, False),
        ("/", {}, False),
    ],
)
@pytest.mark.parametrize("composition", ["false", "true"])
def test_a_rig_in_a_pushed_namespace_leaves_the_common_clock_alone(
    pushed: str, given: dict[str, str], its_own: bool, composition: str
) -> None:
    """Two such rigs would mix their times there; their bags have each its own clock."""
    nodes = launch_nodes(
        "rig.launch.py",
        ros_namespace=pushed,
        record="true",
        use_composition=composition,
        **given,
    )
    assert plant(nodes)["time.publish_clock"] is not its_own
    assert ("recorder:/clock:=clock" in nodes[-1].command) is its_own
