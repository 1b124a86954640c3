# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The presets that ship with the package."""

from pathlib import Path

import pytest
import yaml

from rodless_base import parameter_file
from rodless_base.parameters import ParameterError, ParameterSet
from rodless_control import ControllerParameters, PidParameters
from rodless_control.laws import LAWS
from rodless_sim import RigParameters

SETS = {"plant": RigParameters, "controller": ControllerParameters}


@pytest.fixture
def own_presets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder that stands in for the one of the presets."""
    monkeypatch.setattr(parameter_file, "preset_directory", lambda: tmp_path)
    return tmp_path


def test_both_presets_are_there() -> None:
    """They are found from the source tree and from an installation."""
    assert {"paper", "calibrated"} <= set(parameter_file.preset_names())
    for name in parameter_file.preset_names():
        assert parameter_file.preset_file(name).is_file()


@pytest.mark.parametrize("name", parameter_file.preset_names())
def test_presets_hold_only_declared_names(name: str) -> None:
    """Every section is for one of the two nodes; with one law or another it has every name."""
    document = yaml.safe_load(parameter_file.preset_file(name).read_text(encoding="utf-8"))
    laws = [ControllerParameters.for_law(law) for law in LAWS]
    for section, content in document.items():
        kinds = {"plant": [RigParameters], "controller": laws}[section.rsplit("/", 1)[-1]]
        given = content["ros__parameters"]
        for kind in kinds:
            found = kind.preset(name)
            own = given.keys() & kind.DECLARATIONS.keys()
            assert {key: given[key] for key in own} == {key: found[key] for key in own}
        assert given.keys() <= {key for kind in kinds for key in kind.DECLARATIONS}


def test_the_presets_differ_where_they_say() -> None:
    """Paper friction is Table 2's, the calibrated one saturates."""
    assert RigParameters.preset("paper").text("friction.form") == "stribeck"
    assert RigParameters.preset("calibrated").text("friction.form") == "saturating"


@pytest.mark.parametrize("kind", SETS.values())
def test_paper_is_the_default(kind: type[ParameterSet]) -> None:
    """Parameters made without a word are the paper's."""
    assert kind.preset("paper") == kind()


@pytest.mark.parametrize("kind", SETS.values())
@pytest.mark.parametrize("name", ["papre", "", "paper.yaml", "../config/paper", "Paper"])
def test_an_unknown_preset_lists_the_known(kind: type[ParameterSet], name: str) -> None:
    """The message names what was asked for and what there is."""
    with pytest.raises(ParameterError) as refusal:
        kind.preset(name)
    message = str(refusal.value)
    assert repr(name) in message
    assert all(known in message for known in ("paper", "calibrated"))


def test_a_typo_in_a_preset_names_file_and_name(own_presets: Path) -> None:
    """Nothing in a preset is silently without effect."""
    path = own_presets / "mine.yaml"
    path.write_text(
        "/**/plant:\n  ros__parameters:\n    friction.forwad.static: 30.0\n", encoding="utf-8"
    )
    with pytest.raises(ParameterError) as refusal:
        RigParameters.preset("mine")
    assert str(refusal.value) == (
        f"{path}: friction.forwad.static: no such parameter; did you mean friction.forward.static?"
    )
    assert PidParameters.preset("mine") == PidParameters()


def test_a_preset_is_found_by_its_file_name(own_presets: Path) -> None:
    """A file beside the others is a preset; other files are none."""
    (own_presets / "mine.yaml").write_text(
        "/**:\n  ros__parameters: {}\n/**/controller:\n  ros__parameters:\n    controller.kp: 7\n",
        encoding="utf-8",
    )
    (own_presets / "notes.txt").write_text("none", encoding="utf-8")
    assert parameter_file.preset_names() == ["mine"]
    assert PidParameters.preset("mine").number("controller.kp") == 7.0
