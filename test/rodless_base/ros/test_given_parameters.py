# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a node takes of the files it is given: by name, under another name, and for all nodes."""

from pathlib import Path

import pytest
from extent import some_of
from running import StartProcess

from rodless_base.parameter_file import preset_file
from rodless_base.ros.given import asked_for, parameter_files
from rodless_control import ControllerParameters
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import node_command
from rodless_sim import RigParameters


@pytest.mark.parametrize(
    ("arguments", "files"),
    [
        ([], []),
        (["--params-file", "a"], []),
        (["--ros-args", "--params-file", "a", "-p", "x:=1", "--params-file", "b"], ["a", "b"]),
        (["--ros-args", "--", "--params-file", "a"], []),
        (["--ros-args", "--", "x", "--ros-args", "--params-file", "a"], ["a"]),
        (["--ros-args", "--params-file"], []),
    ],
)
def test_files_are_read_from_the_arguments_for_ros(arguments: list[str], files: list[str]) -> None:
    """Those between --ros-args and --, in their order."""
    assert parameter_files(["plant", *arguments]) == files


def test_a_renamed_node_takes_the_preset_of_its_kind(
    start_process: StartProcess, observer: Observer
) -> None:
    """`-r __node:=cyl1` with a preset: cyl1 has the preset's values, and says whence."""
    command = [*node_command("plant", [preset_file("calibrated")]), "-r", "__node:=cyl1"]
    with start_process(command, "cyl1") as process:
        names = ["friction.form", "cylinder.stroke"]
        found = observer.get_parameters("/cyl1", names)
        preset = RigParameters.preset("calibrated")
        assert found == {name: preset[name] for name in names}
        assert found["friction.form"] != RigParameters()["friction.form"]
        assert "has no section cyl1: taking /**/plant" in process.output


def test_a_section_of_the_new_name_counts_alone(
    start_process: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """A file that names the renamed node means `plant` for another node; -p counts most."""
    file = tmp_path / "two.yaml"
    file.write_text(
        "plant: {ros__parameters: {supply.pressure: 500000.0, friction.form: saturating}}\n"
        "cyl2: {ros__parameters: {supply.pressure: 550000.0, cylinder.moving_mass: 2.0}}\n"
    )
    command = [*node_command("plant", [file]), "-r", "__node:=cyl2"]
    with start_process([*command, "-p", "cylinder.moving_mass:=3.0"], "cyl2") as process:
        names = ["supply.pressure", "friction.form", "cylinder.moving_mass"]
        assert list(observer.get_parameters("/cyl2", names).values()) == [5.5e5, "stribeck", 3.0]
        assert "taking" not in process.output


@pytest.mark.parametrize(
    ("arguments", "simulated"), [([], True), (["-p", "use_sim_time:=false"], False)]
)
def test_a_renamed_node_takes_the_time_base_of_its_kind(
    start_process: StartProcess,
    observer: Observer,
    tmp_path: Path,
    arguments: list[str],
    simulated: bool,
) -> None:
    """Of its kind's section, as all else there; what the command line says counts most."""
    file = tmp_path / "controller.yaml"
    file.write_text("controller: {ros__parameters: {use_sim_time: true, controller.kp: 321.0}}\n")
    command = [*node_command("controller", [file]), "-r", "__node:=ctl1", *arguments]
    with start_process(command, "ctl1"):
        found = observer.get_parameters("/ctl1", ["use_sim_time", "controller.kp"])
    assert found == {"use_sim_time": simulated, "controller.kp": 321.0}


@pytest.mark.parametrize(
    ("files", "pressure"),
    [
        # The more specific section after the one for all, as ROS has it within a file.
        ([{"/**": 6.0e5, "/**/plant": 6.5e5}], 6.5e5),
        ([{"/**": 6.0e5}, {"/**/plant": 6.5e5}], 6.5e5),
        # A later file wins, whomever it names.
        ([{"/**/plant": 6.5e5}, {"/**": 6.0e5}], 6.0e5),
        # Another namespace's section is another rig's.
        ([{"/left/plant": 6.0e5, "/right/plant": 6.5e5}], 6.0e5),
    ],
)
@pytest.mark.parametrize("name", some_of(["cyl3", "plant"], 2))
def test_a_renamed_node_reads_files_as_one_of_the_old_name(
    start_process: StartProcess,
    observer: Observer,
    tmp_path: Path,
    name: str,
    files: list[dict[str, float]],
    pressure: float,
) -> None:
    """Of several sections and files both take the same supply pressure: that of the last."""
    written = []
    for number, sections in enumerate(files):
        file = tmp_path / f"{number}.yaml"
        lines = [
            f"{node}: {{ros__parameters: {{supply.pressure: {value}}}}}"
            for node, value in sections.items()
        ]
        file.write_text("\n".join(lines))
        written.append(file)
    command = [*node_command("plant", written, "left"), "-r", f"__node:={name}"]
    with start_process(command, name):
        found = observer.get_parameters(f"/left/{name}", ["supply.pressure"])
    assert found == {"supply.pressure": pressure}


def test_a_section_for_all_nodes_gives_each_its_own(
    start_process: StartProcess, observer: Observer, tmp_path: Path
) -> None:
    """Plant and controller values under /**: both nodes start, each with what it has."""
    file = tmp_path / "all.yaml"
    file.write_text("/**: {ros__parameters: {supply.pressure: 500000.0, controller.kp: 321.0}}\n")
    with (
        start_process(node_command("plant", [file], "all"), "plant") as plant,
        start_process(node_command("controller", [file], "all"), "controller") as controller,
    ):
        given = observer.get_parameters("/all/plant", ["supply.pressure"])
        assert given == {"supply.pressure": 5e5}
        assert observer.get_parameters("/all/controller", ["controller.kp"]) == {
            "controller.kp": 321.0
        }
        assert "leaving out parameters of other nodes: controller.kp" in plant.output
        assert "leaving out parameters of other nodes: supply.pressure" in controller.output
    assert RigParameters.from_file(file)["supply.pressure"] == 5e5
    assert ControllerParameters.from_file(file)["controller.kp"] == 321.0


def test_a_misspelt_name_for_all_nodes_is_still_refused(
    start_process: StartProcess, tmp_path: Path
) -> None:
    """What is a typo stays one: the node it would be of refuses to start."""
    file = tmp_path / "all.yaml"
    file.write_text("/**: {ros__parameters: {supply.presure: 500000.0}}\n")
    with start_process(node_command("plant", [file], "typo"), "plant") as plant:
        assert plant.wait() == 1
        assert "did you mean supply.pressure" in plant.output


@pytest.mark.parametrize(
    ("arguments", "mode"),
    [
        (["-r", "__ns:=/left"], "realtime"),
        (["-r", "__ns:=/right"], "lockstep"),
        ([], None),
        (["-r", "__ns:=/left", "-p", "time.mode:='lockstep'"], "lockstep"),
        (["-r", "__node:=cyl1"], "lockstep"),
        (["-r", "__node:=cyl1", "--param", "cyl1:time.mode:=realtime"], "realtime"),
    ],
)
def test_what_is_asked_for_is_known_before_there_is_a_node(
    tmp_path: Path, arguments: list[str], mode: str | None
) -> None:
    """Of the node's own section: another rig's in the same file, or another node's, is none."""
    file = tmp_path / "two.yaml"
    file.write_text(
        "/left/plant: {ros__parameters: {time.mode: realtime}}\n"
        "/right/plant: {ros__parameters: {time.mode: lockstep}}\n"
        "cyl1: {ros__parameters: {time.mode: lockstep}}\n"
    )
    given = ["plant", "--ros-args", "--params-file", str(file), *arguments]
    assert asked_for(given, "plant", "time.mode") == mode
