# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a set of parameters says of itself: where it comes from, and what differs from there."""

from pathlib import Path

import pytest

from rodless_base.parameter_file import preset_names
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control import PidParameters
from rodless_sim import RigParameters

FILE = "/**/plant:\n  ros__parameters:\n    supply.pressure: 600000.0\n"


def test_defaults_say_nothing_more() -> None:
    """No values, no braces."""
    assert repr(RigParameters()) == "RigParameters()"
    assert repr(RigParameters({"supply.pressure": 621325.0})) == "RigParameters()"


def test_values_are_shown_where_they_differ_from_the_defaults() -> None:
    """However they came about."""
    shown = "RigParameters({'supply.pressure': 600000.0})"
    assert repr(RigParameters({"supply.pressure": 6e5})) == shown
    assert repr(RigParameters().with_values({"supply.pressure": 6e5})) == shown


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("kind", [RigParameters, PidParameters])
def test_a_preset_says_its_name(kind: type[ParameterSet], name: str) -> None:
    """Whatever it holds."""
    assert repr(kind.preset(name)) == f"{kind.__name__}.preset('{name}')"


def test_a_changed_preset_says_what_differs_from_the_preset() -> None:
    """Over several changes, and no more once a value is back."""
    calibrated = RigParameters.preset("calibrated")
    changed = calibrated.with_values({"supply.pressure": 6e5})
    changed = changed.with_values({"friction.form": "stribeck"})
    assert repr(changed) == (
        "RigParameters.preset('calibrated')"
        ".with_values({'supply.pressure': 600000.0, 'friction.form': 'stribeck'})"
    )
    back = changed.with_values({name: calibrated[name] for name in calibrated})
    assert repr(back) == "RigParameters.preset('calibrated')"
    assert repr(calibrated) == "RigParameters.preset('calibrated')"


def test_a_file_says_its_path(tmp_path: Path) -> None:
    """And what was changed since."""
    path = tmp_path / "mine.yaml"
    path.write_text(FILE, encoding="utf-8")
    found = RigParameters.from_file(path)
    assert repr(found) == f"RigParameters.from_file('{path}')"
    assert repr(found.with_values({"cylinder.locked": True})) == (
        f"RigParameters.from_file('{path}').with_values({{'cylinder.locked': True}})"
    )


@pytest.mark.parametrize(
    "parameters",
    [
        RigParameters(),
        RigParameters({"supply.pressure": 6e5}),
        RigParameters.preset("calibrated"),
        RigParameters.preset("calibrated").with_values({"supply.pressure": 6e5}),
    ],
)
def test_what_it_says_makes_an_equal_set(parameters: RigParameters) -> None:
    """The text is an expression."""
    assert eval(repr(parameters), {"RigParameters": RigParameters}) == parameters


def test_where_it_comes_from_does_not_count_in_comparisons(tmp_path: Path) -> None:
    """Equal values are equal sets with equal hashes."""
    path = tmp_path / "mine.yaml"
    path.write_text(FILE, encoding="utf-8")
    read, made = RigParameters.from_file(path), RigParameters({"supply.pressure": 6e5})
    assert read == made
    assert hash(read) == hash(made)
    assert RigParameters.preset("paper") == RigParameters()


def test_a_choice_is_a_place_among_the_choices() -> None:
    """Compiled equations take an integer for it."""
    assert RigParameters().choice("friction.form") == 0
    assert RigParameters({"friction.form": "saturating"}).choice("friction.form") == 1


def test_a_parameter_is_declared_once() -> None:
    """Two modules cannot take the same name in silence."""
    mass = Parameter("mass", 1.0, "kg", "a mass", "test")
    with pytest.raises(ValueError, match="mass: declared twice"):
        declare(mass, mass)
    with pytest.raises(ValueError, match="mass: declared twice"):
        collect(declare(mass), declare(mass))
    assert list(collect(declare(mass), declare())) == ["mass"]
