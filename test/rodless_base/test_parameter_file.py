# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ROS parameter files: which sections count, and what is wrong with a bad one."""

import itertools
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rodless_base.parameter_file import number_meant, read_parameter_file, section_names
from rodless_base.parameters import ParameterError
from rodless_control import ControllerParameters
from rodless_sim import RigParameters

Write = Callable[[str], Path]


@pytest.fixture
def written(tmp_path: Path) -> Write:
    """Write a text as a parameter file."""

    def write(text: str) -> Path:
        path = tmp_path / "some.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def section(name: str, line: str = "a: 1") -> str:
    """Return one section with one parameter."""
    return f"{name}:\n  ros__parameters:\n    {line}\n"


@pytest.mark.parametrize(
    "name",
    ["plant", "/plant", "/rig/plant", "/left/rig/plant", "/**/plant", "/*/plant", "/**", '"*"'],
)
def test_sections_of_the_node_count_in_every_namespace(written: Write, name: str) -> None:
    """The node by name in any namespace, and sections for all nodes."""
    assert read_parameter_file(written(section(name)), "plant") == {"a": 1}


@pytest.mark.parametrize(
    "head",
    ["left: {plant: ", "/left: {plant: ", "left/: {plant: ", "'*': {plant: ", "left: {'**': "],
)
def test_namespaces_may_be_nested(written: Write, head: str) -> None:
    """As ROS has it: what is nested is joined by slashes, wildcards and all."""
    path = written(f"{head}{{ros__parameters: {{a: 1}}}}}}\n" + section("/**/controller", "b: 2"))
    assert read_parameter_file(path, "plant", namespace="/left") == {"a": 1}
    elsewhere = {"a": 1} if "'*'" in head else {}
    assert read_parameter_file(path, "plant", namespace="/right") == elsewhere
    assert read_parameter_file(path, "controller") == {"b": 2} | ({"a": 1} if "**'" in head else {})


def test_namespaces_nest_as_deep_as_they_are(written: Write) -> None:
    """Several in one file, beside sections of one name; of the same node the later wins."""
    path = written(
        "lab:\n  left/rig: {plant: {ros__parameters: {a: 1, b: 2}}}\n"
        "  right: {rig: {plant: {ros__parameters: {a: 3}}}}\n"
        + section("/lab/left/rig/plant", "a: 4")
    )
    assert section_names(path) == [
        "lab/left/rig/plant",
        "lab/right/rig/plant",
        "/lab/left/rig/plant",
    ]
    assert read_parameter_file(path, "plant", namespace="/lab/left/rig") == {"a": 4, "b": 2}
    assert read_parameter_file(path, "plant", namespace="/lab/right/rig") == {"a": 3}


@pytest.mark.parametrize("name", ["controller", "/rig/controller", "/plant/controller"])
def test_sections_of_other_nodes_are_ignored(written: Write, name: str) -> None:
    """What belongs to another node is not this one's, even if it is nonsense here."""
    assert read_parameter_file(written(section(name)), "plant") == {}


@pytest.mark.parametrize("name", ["Plant", "plants", "/plant/arm", "/left/rig_plant"])
def test_a_file_without_a_section_for_the_rig_is_refused(written: Write, name: str) -> None:
    """Nodes of others or a name misspelt: its values would be left out without a word."""
    path = written(section(name, "friction.forward.viscous: 9000.0"))
    expected = f"{path}: no section is for the plant or controller; it has {name}"
    for kind in (RigParameters, ControllerParameters):
        with pytest.raises(ParameterError) as refusal:
            kind.from_file(path)
        assert str(refusal.value) == expected
    beside = written(section(name) + section("plant", "b: 2"))
    assert read_parameter_file(beside, "plant") == {"b": 2}


def test_a_file_for_another_namespace_is_refused(written: Write) -> None:
    """Where one is given; the line says which, and what the file has."""
    path = written(section("/left/plant") + section("/right/*", "b: 2"))
    said = "controller of namespace /middle; it has /left/plant, /right/"
    with pytest.raises(ValueError, match=said):
        read_parameter_file(path, "plant", namespace="/middle")
    with pytest.raises(ValueError, match="controller of namespace /; it has"):
        read_parameter_file(path, "plant", namespace="")


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("/left/plant", "/right/plant"), "/left/plant and /right/plant"),
        (("/left/plant", "/right/*"), "/left/plant and /right/*"),
        (("/right*/plant", "/left/plant"), "/left/plant and /right*/plant"),
        (("/a/b/plant", "/a/plant", "a/c/plant"), "/a/b/plant and /a/plant, a/c/plant"),
    ],
)
def test_sections_of_different_rigs_are_not_mixed(
    written: Write, names: tuple[str, ...], said: str
) -> None:
    """Nothing says which rig is meant: refused in one line that names the sections."""
    path = written("".join(section(f"'{name}'", "supply.pressure: 5e5") for name in names))
    with pytest.raises(ParameterError) as refusal:
        RigParameters.from_file(path)
    assert str(refusal.value) == (
        f"{path}: {said} are for different rigs; keep the sections of one"
    )


def test_all_sections_that_one_rig_has_are_joined(written: Write) -> None:
    """Those that name it, however it is spelt, and patterns; another rig's controller is none."""
    path = written(
        section("/left/plant", "a: 1")
        + "left: {plant: {ros__parameters: {b: 2}}}\n"
        + section("'/*/plant'", "c: 3")
        + section("/**", "d: 4")
        + section("/right/controller", "e: 5")
    )
    assert read_parameter_file(path, "plant") == {"a": 1, "b": 2, "c": 3, "d": 4}


def test_what_every_ros_node_has_is_no_parameter_of_the_rig(written: Write) -> None:
    """A file for a whole system may set use_sim_time for all; the rest of it counts."""
    text = section("/**", "{use_sim_time: true, start_type_description_service: false}")
    text += section("plant", "{qos_overrides./clock.depth: 1, supply.pressure: 5.0e+5}")
    assert read_parameter_file(written(text), "plant") == {"supply.pressure": 5e5}
    assert RigParameters.from_file(written(text)).number("supply.pressure") == 5e5


def test_later_sections_win(written: Write) -> None:
    """A value named twice is the last one; the others of both sections stay."""
    text = section("/**", "{a: 1, b: 2}") + section("plant", "{b: 3, c: 4}")
    assert read_parameter_file(written(text), "plant") == {"a": 1, "b": 3, "c": 4}
    turned = section("plant", "{b: 3, c: 4}") + section("/**", "{a: 1, b: 2}")
    assert read_parameter_file(written(turned), "plant") == {"a": 1, "b": 2, "c": 4}


def test_nested_names_are_joined_by_dots(written: Write) -> None:
    """Nested and dotted spellings of a name are the same; lists stay values."""
    text = (
        "plant:\n  ros__parameters:\n    friction:\n      forward: {static: 30.0, coulomb: 12.0}\n"
        "      reverse.static: 40.0\n    valve.curve: [1, 2.5]\n    supply.pressure: 6.0e+5\n"
    )
    assert read_parameter_file(written(text), "plant") == {
        "friction.forward.static": 30.0,
        "friction.forward.coulomb": 12.0,
        "friction.reverse.static": 40.0,
        "valve.curve": [1, 2.5],
        "supply.pressure": 6e5,
    }


@pytest.mark.parametrize(
    ("spelling", "value"),
    [("1e-5", 1e-5), ("6E5", 6e5), ("-.5e+2", -50.0), ("2.e-3", 2e-3), ("+3e0", 3.0)],
)
def test_numbers_with_exponents_are_numbers(written: Write, spelling: str, value: float) -> None:
    """Spellings that ROS reads as reals, and YAML 1.1 as texts."""
    found = read_parameter_file(written(section("plant", f"a: {spelling}")), "plant")["a"]
    assert isinstance(found, float)
    assert found == value


@pytest.mark.parametrize("spelling", ["e5", "1e", "12e3abc", '"1e5"', "v1e5"])
def test_texts_stay_texts(written: Write, spelling: str) -> None:
    """What only looks like a number is left alone."""
    found = read_parameter_file(written(section("plant", f"a: {spelling}")), "plant")["a"]
    assert found == spelling.strip('"')


@pytest.mark.parametrize("spelling", ["{}e", "{}.", ".{}", "{0}.{0}", "{}x", "-{}e+x"])
def test_a_text_of_many_digits_is_read_as_fast_as_one_of_other_letters(
    written: Write, spelling: str
) -> None:
    """In one look, not in one for each way to share its digits out, which would take an hour."""
    text = spelling.format("1" * 200_000)
    found = read_parameter_file(written(section("plant", f"a: {text}")), "plant")["a"]
    assert str(found) == text or found == float(text)


def test_an_empty_section_gives_nothing(written: Write) -> None:
    """All of its lines may be commented out."""
    assert read_parameter_file(written("plant:\n  ros__parameters:\n    # a: 1\n"), "plant") == {}


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("a: [1, 2", "not YAML"),
        ("a: 1\n  b: 2", "not YAML"),
        ("!!python/object/apply:os.getcwd []", "not YAML"),
        ("", "no node sections"),
        ("just a text", "no node sections"),
        ("- a\n- b", "no node sections"),
        ("plant:\n  a: 1", "'plant' must hold ros__parameters"),
        ("plant:\n  ros_parameters:\n    a: 1", "'plant' must hold ros__parameters"),
        ("plant:\n  ros__parameters:\n    a: 1\n  b: 2", "'plant' must hold ros__parameters"),
        ("left: {plant: {a: 1}}", "'left/plant' must hold ros__parameters and nothing else"),
        ("left: {plant: {ros_parameters: {a: 1}}}", "'left/plant' must hold ros__parameters"),
        ("left: {plant: {ros__parameters: {}, b: {}}}", "'left/plant' must hold ros__parameters"),
        ("left: {plant: {}}", "'left/plant' must hold ros__parameters"),
        ("left:", "'left' must hold ros__parameters"),
        ("left: {/plant: {ros__parameters: {}}}", "'left//plant' has two slashes in a row"),
        ("plant: 3", "'plant' must hold ros__parameters"),
        ("controller: 3", "'controller' must hold ros__parameters"),
        ("plant:\n  ros__parameters: 3", "ros__parameters: 3 refused: expected names and values"),
        (
            "plant:\n  ros__parameters:\n    supply.pressure 600000.0",
            "'supply.pressure 600000.0' refused: .* each as `name: value`",
        ),
        ("plant:\n  ros__parameters: [1, 2]", "expected names and values"),
    ],
)
def test_files_that_are_none_are_refused(written: Write, text: str, complaint: str) -> None:
    """The message says what is wrong; through from_file it names the file as well."""
    path = written(text)
    with pytest.raises(ValueError, match=complaint):
        read_parameter_file(path, "plant")
    with pytest.raises(ParameterError, match=complaint) as refusal:
        RigParameters.from_file(path)
    assert str(refusal.value).startswith(f"{path}: ")


def test_a_file_gives_each_node_its_own(written: Write) -> None:
    """One file starts both nodes; names of the one are no typos of the other."""
    path = written(
        section("/**/plant", "supply.pressure: 600000")
        + section("/**/controller", "controller: {kp: 500, joint: slide}")
    )
    rig, pid = RigParameters.from_file(path), ControllerParameters.from_file(path)
    assert rig.number("supply.pressure") == 6e5
    assert (pid.number("controller.kp"), pid.text("controller.joint")) == (500.0, "slide")
    assert rig == RigParameters({"supply.pressure": 6e5})


def test_a_section_for_all_nodes_may_hold_the_other_nodes_parameters(written: Write) -> None:
    """Each takes its own of it; in a section of its own another's parameter is a mistake."""
    path = written(section("/**", "{supply.pressure: 6e5, controller.kp: 500}"))
    assert RigParameters.from_file(path) == RigParameters({"supply.pressure": 6e5})
    assert ControllerParameters.from_file(path).number("controller.kp") == 500.0
    path = written(section("plant", "{supply.pressure: 6e5, controller.kp: 500}"))
    with pytest.raises(ParameterError, match=r"controller\.kp: .* it is the controller's"):
        RigParameters.from_file(path)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("1e-05", 1e-5),
        ("[2e-06, 1]", [2e-6, 1]),
        ("3", 3),
        ("high", "high"),
        ("true", "true"),
        ("[1.0, high]", "[1.0, high]"),
        ("[[1e-5]]", "[[1e-5]]"),
        ("{a: 1}", "{a: 1}"),
        ("[", "["),
        ("", ""),
    ],
)
def test_texts_that_are_numbers_for_ros_are_told_from_others(text: str, meant: object) -> None:
    """Only a number, or a list of numbers and nothing else."""
    found = number_meant(text)
    assert type(found) is type(meant)
    assert found == meant


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("friction.forward.statik: 30.0", "friction.forward.statik: no such parameter"),
        ("supply.presure: 6e5", "did you mean supply.pressure"),
        ("supply.pressure: high", "supply.pressure: 'high' refused"),
        ("supply.pressure: .nan", "supply.pressure: nan refused"),
        ("supply.pressure: 5.0e4", "supply.pressure: 50000 Pa refused"),
        ("supply.pressure:", "supply.pressure: None refused"),
    ],
)
def test_bad_lines_are_refused_with_file_and_name(
    written: Write, line: str, complaint: str
) -> None:
    """A typo or bad value in a file is an error that says where it is."""
    path = written(section("plant", line))
    with pytest.raises(ParameterError, match=complaint) as refusal:
        RigParameters.from_file(path)
    assert str(refusal.value).startswith(f"{path}: ")


@pytest.mark.parametrize("kind", [ParameterError, OSError])
def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, kind: type[Exception]) -> None:
    """Missing, or a folder: one line says which and why, for whoever waits for either error."""
    with pytest.raises(kind, match=r"nowhere\.yaml: cannot be read: No such file") as missing:
        RigParameters.from_file(tmp_path / "nowhere.yaml")
    with pytest.raises(kind, match="cannot be read: Is a directory"):
        RigParameters.from_file(tmp_path)
    assert "\n" not in str(missing.value)


def test_a_pipe_without_a_writer_is_refused_at_once(tmp_path: Path) -> None:
    """Opened as a file it would be waited for without end."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ParameterError, match="pipe or device; save what it gives to a file"):
        RigParameters.from_file(tmp_path / "pipe")


def test_a_file_larger_than_any_of_parameters_is_not_read(tmp_path: Path) -> None:
    """100 MB, all of them sound YAML, are refused without being parsed."""
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.write(section("plant").encode())
        file.truncate(100_000_000)
    with pytest.raises(ParameterError, match="larger than 1000 kB"):
        RigParameters.from_file(path)


BOMB = "a: &a [1, 1]\n" + "".join(
    f"{after}: &{after} [*{before}, *{before}]\n" for before, after in itertools.pairwise("abcdefg")
)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (BOMB, "line 2: aliases (*name) are not for ROS"),
        ("plant: &p\n  ros__parameters: *p\n", "line 2: aliases"),
        (section("plant", "{<<: {a: 1}, b: 2}"), "line 3: merging (<<) is not for ROS"),
        ("plant: " + "[" * 100_000, "nested more than 20 levels deep"),
        ("plant: " + "{a: " * 100_000, "nested more than 20 levels deep"),
        (section("plant", "{a: 1, a: 2}"), "line 3: 'a' stands twice"),
        (section("plant") + section("plant"), "line 4: 'plant' stands twice"),
        (section("plant", "{a.b: 1, a: {b: 2}}"), "a.b: stands twice, nested and dotted"),
        (
            section("plant", "{supply: {}}"),
            "supply: holds nothing; leave it out or give it a value",
        ),
        ("plant: \udcff", "UTF-8"),
        (section("plant", "a: !!float abc"), "line 3: 'abc' cannot be read as float"),
        (section("plant", f"a: {'9' * 5000}"), "cannot be read as int"),
        (section("plant", "a: !!timestamp soon"), "line 3: 'soon' cannot be read as timestamp"),
    ],
)
def test_hostile_files_are_refused_in_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    """What would fill the memory, end in a traceback, or lose a value without a word."""
    path = tmp_path / "some.yaml"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ParameterError, match=re.escape(complaint)) as refusal:
        RigParameters.from_file(path)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 700


@pytest.mark.parametrize(
    "text", ["*a", "&a [*a]", "[" * 100, "!!float abc", "9" * 5000, "{a", f"[{'1,' * 1000}1]"]
)
def test_a_text_that_is_no_yaml_stays_a_text(text: str) -> None:
    """It comes from a parameter request; the parameter that is no text refuses it then.

    So does one too long for any parameter: it would take a node seconds to read.
    """
    assert number_meant(text) == text


def test_a_file_name_with_a_line_break_is_refused_in_one_line(tmp_path: Path) -> None:
    """As any other that is not there."""
    with pytest.raises(ParameterError, match="cannot be read") as refusal:
        RigParameters.from_file(tmp_path / "two\nlines.yaml")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("spelling", ["190:20:30", "1:30", "190:20:30.15", "600_000", "6_0.0"])
def test_what_is_a_number_in_yaml_alone_is_a_text(written: Write, spelling: str) -> None:
    """YAML 1.1 reads 685230 from 190:20:30; ROS does not, and no rig has such a pressure."""
    path = written(section("plant", f"supply.pressure: {spelling}"))
    assert read_parameter_file(path, "plant") == {"supply.pressure": spelling}
    with pytest.raises(ParameterError, match=f"supply.pressure: '{spelling}' refused"):
        RigParameters.from_file(path)
