# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The node's whole set, and the part of it that is the law's."""

from pathlib import Path

import pytest

from rodless_base.parameter_file import preset_names
from rodless_control import ControllerParameters, ParameterError, PidParameters

FILE = """
/**/controller:
  ros__parameters:
    controller: {kp: 500.0, joint: slide, law: pid}
    reference: {type: move, velocity: 0.1}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a file of a whole controller."""
    path = tmp_path / "mine.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


def test_the_law_takes_its_own_from_a_file_and_the_node_takes_all(file: Path) -> None:
    """PidParameters reads the gain and leaves joint and reference to ControllerParameters."""
    assert PidParameters.from_file(file) == PidParameters({"controller.kp": 500.0})
    whole = ControllerParameters.from_file(file)
    assert (whole["controller.joint"], whole["reference.velocity"]) == ("slide", 0.1)
    assert whole.of_law() == PidParameters({"controller.kp": 500.0})


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ("kp: 500.0", "controller.kP: no such parameter; did you mean controller.kp"),
        ("velocity: 0.1", "reference.velocity: -1.0 refused"),
    ],
)
def test_what_a_file_spells_wrong_is_refused_by_the_law_too(
    file: Path, wrong: str, complaint: str
) -> None:
    """An unknown name gets its hint; a bad value of the rest of the node is seen."""
    changed = {"kp: 500.0": "kP: 500.0", "velocity: 0.1": "velocity: -1.0"}[wrong]
    file.write_text(FILE.replace(wrong, changed), encoding="utf-8")
    for kind in (PidParameters, ControllerParameters):
        with pytest.raises(ParameterError) as refusal:
            kind.from_file(file)
        assert complaint in str(refusal.value)


@pytest.mark.parametrize("name", ["reference.type", "controller.joint", "controller.law"])
def test_what_is_the_node_s_says_so_when_given_to_the_law(name: str) -> None:
    """PidParameters has none of references, joint and law; the message says who has."""
    value = ControllerParameters()[name]
    expected = f"{name}: belongs to the controller node, not to its law; use ControllerParameters"
    with pytest.raises(ParameterError) as refusal:
        PidParameters({name: value})
    assert str(refusal.value) == expected
    with pytest.raises(ParameterError) as refusal:
        PidParameters().with_values({name: value})
    assert str(refusal.value) == expected


def test_law_and_node_share_no_declaration_but_the_limits() -> None:
    """The node's set is the law's and the groups, each name once, defaults alike."""
    law, node = PidParameters(), ControllerParameters()
    assert law.keys() < node.keys()
    assert {name: node[name] for name in law} == dict(law)
    assert not [name for name in law if name.startswith("reference.")]


@pytest.mark.parametrize("name", preset_names())
def test_presets_read(name: str) -> None:
    """Each preset is a valid set for the whole node, its law's part the same either way."""
    assert ControllerParameters.preset(name).of_law() == PidParameters.preset(name)


def test_another_law_needs_another_set() -> None:
    """A name that is not the set's own law is refused with the way out."""
    with pytest.raises(ParameterError, match=r"use ControllerParameters\.for_law\('a:B'\)"):
        ControllerParameters({"controller.law": "a:B"})


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"type": "step", "target": 0.21}, "reference.target: 0.21 m"),
        ({"type": "step", "start": -0.01}, "reference.start: -0.01 m"),
        ({"type": "sine", "centre": 0.01}, "reference.centre ± reference.amplitude: -0.01 m"),
        ({"type": "sine", "centre": 0.19}, "reference.centre ± reference.amplitude: 0.21 m"),
        ({"minimum": 0.2}, "reference.minimum: 0.2 m"),
    ],
)
def test_a_reference_outside_the_travel_is_refused(values: dict[str, object], named: str) -> None:
    """Steps and sines in force must stay between reference.minimum and reference.maximum."""
    with pytest.raises(ParameterError) as refusal:
        ControllerParameters({f"reference.{name}": value for name, value in values.items()})
    assert str(refusal.value).startswith(f"{named} refused")
    assert "reference.maximum (0.2 m)" in str(refusal.value)


def test_a_reference_that_is_not_in_force_may_lie_outside() -> None:
    """A short travel with set-points needs no change of the step's default target."""
    short = ControllerParameters({"reference.maximum": 0.05})
    with pytest.raises(ParameterError, match=r"reference\.target: 0\.058 m refused"):
        short.with_values({"reference.type": "step"})
    longer = {"reference.maximum": 0.3, "reference.type": "step", "reference.target": 0.25}
    assert ControllerParameters(longer)["reference.target"] == 0.25


def test_a_law_of_any_length_is_refused_in_a_short_line() -> None:
    """Whoever sets it may send three thousand letters; they are not sent back."""
    with pytest.raises(ParameterError, match="these are the parameters of 'pid'") as refused:
        ControllerParameters().with_values({"controller.law": "x" * 3000})
    assert len(str(refused.value)) < 400
