# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A section for every node (`/**`) of a parameter file gives each node its own names."""

from pathlib import Path

import pytest

from rodless_base.parameter_file import read_parameter_file
from rodless_base.parameters import ParameterError
from rodless_control import ControllerParameters
from rodless_lab.identification.subjects import assumed_parameters
from rodless_sim import RigParameters

SHARED = (
    "/**:\n  ros__parameters:\n    use_sim_time: true\n    supply: {pressure: 6.0e+5}\n"
    "    controller.kp: 500.0\n    reference: {type: ramp}\n"
)


def written(folder: Path, text: str) -> Path:
    """Write a text as a parameter file."""
    path = folder / "some.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_each_node_takes_its_own_of_a_section_for_every_node(tmp_path: Path) -> None:
    """Plant names reach the plant alone and controller names the controller; the order stays."""
    text = "plant:\n  ros__parameters: {supply.pressure: 5.0e+5, time.period: 0.01}\n"
    path = written(tmp_path, f"{text}{SHARED}")
    plant = read_parameter_file(path, "plant", RigParameters.foreign)
    assert plant == {"supply.pressure": 6e5, "time.period": 0.01}
    controller = read_parameter_file(path, "controller", ControllerParameters.foreign)
    assert controller == {"controller.kp": 500.0, "reference.type": "ramp"}
    assert RigParameters.from_file(path)["supply.pressure"] == 6e5
    assert ControllerParameters.from_file(path)["reference.type"] == "ramp"


@pytest.mark.parametrize("name", ["supply.presure", "controler.kp"])
def test_a_name_of_nobody_is_refused(tmp_path: Path, name: str) -> None:
    """A misspelt name is no other node's: the plant refuses it."""
    path = written(tmp_path, f"{SHARED}    {name}: 1.0\n")
    with pytest.raises(ParameterError, match=f"{name}: no such parameter"):
        RigParameters.from_file(path)


def test_a_section_of_the_plant_by_name_is_not_forgiven(tmp_path: Path) -> None:
    """There a controller's name is a mistake."""
    path = written(tmp_path, "plant:\n  ros__parameters: {controller.kp: 500.0}\n")
    with pytest.raises(ParameterError, match=r"controller\.kp: no such parameter"):
        RigParameters.from_file(path)


def test_identification_takes_what_is_the_plants(tmp_path: Path) -> None:
    """Of a file for both nodes."""
    path = written(tmp_path, SHARED)
    assert assumed_parameters(str(path), "base")["supply.pressure"] == 6e5


def test_identification_takes_what_is_for_the_rig_of_the_bag(tmp_path: Path) -> None:
    """Of a file for two rigs; one that has nothing for the bag's is refused by name."""
    text = "/left/plant: {ros__parameters: {supply.pressure: 6.0e+5}}\n"
    path = written(tmp_path, text + "/right/plant: {ros__parameters: {supply.pressure: 5.0e+5}}\n")
    assert assumed_parameters(str(path), "base", "/left")["supply.pressure"] == 6e5
    assert assumed_parameters(str(path), "base", "/right")["supply.pressure"] == 5e5
    with pytest.raises(
        ParameterError, match=r"some\.yaml: no section is for .* namespace /; it has"
    ):
        assumed_parameters(str(path), "base")


@pytest.mark.parametrize("text", ["- 1", "/**: 3", "{"])
def test_what_is_no_parameter_file_is_refused_by_name(tmp_path: Path, text: str) -> None:
    """The path comes first."""
    path = written(tmp_path, text)
    with pytest.raises(ParameterError, match=r"some\.yaml: "):
        RigParameters.from_file(path)
