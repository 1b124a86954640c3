# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Parameters: checked alone and together, immutable, read from presets and files."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from rodless_sim import ParameterError, RigParameters
from rodless_sim.physics.plant import Plant


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cylinder.moving_mass", 0.0),
        ("cylinder.moving_mass", -1.0),
        ("friction.forward.coulomb", -1.0),
        ("friction.reverse.static", -36.0),
        ("friction.forward.viscous", -4500.0),
        ("friction.reverse.stribeck_velocity", -3.6e-3),
        ("valve.gap_height", -1e-6),
        ("supply.temperature", 24.0),
        ("cylinder.bore", 25.0),
        ("time.tolerance", 0.0),
    ],
)
def test_a_value_out_of_range_is_refused_by_name(name: str, value: float) -> None:
    """Zero or negative mass, negative friction, degrees Celsius, millimetres: refused, named."""
    with pytest.raises(ParameterError, match=name):
        RigParameters({name: value})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    "name", ["supply.pressure", "friction.forward.static", "end_stop.restitution"]
)
def test_a_number_that_is_not_finite_is_refused(name: str, value: float) -> None:
    """No parameter takes NaN or an infinity."""
    with pytest.raises(ParameterError, match=name):
        RigParameters({name: value})


def test_not_a_number_inside_a_list_is_refused() -> None:
    """One NaN among the nine coefficients of eq. (5) refuses the list."""
    good = RigParameters().numbers("valve.area_coefficients")
    with pytest.raises(ParameterError, match=r"valve\.area_coefficients"):
        RigParameters({"valve.area_coefficients": (*good[:8], math.nan)})


# Eq. (5) as the paper prints it, in mm², and so in parameter files of old.
PRINTED = (2.108, 0.2636, 0.1742, 2.012, 0.4851, 2.157, -0.0933, 1.331, 0.9104)


def test_the_area_coefficients_of_older_files_are_told_by_their_size() -> None:
    """Amplitudes in mm² mean the same rig as those in m², to the last bit, with a warning."""
    with pytest.warns(FutureWarning, match="can only be in mm²"):
        old = RigParameters({"valve.area_coefficients": PRINTED})
    assert old == RigParameters()
    assert Plant.of(old) == Plant.of(RigParameters())
    assert Plant.of(old).valve.area_coefficients == PRINTED
    amplitudes = np.random.default_rng(3).uniform(-3.0, 3.0, (100, 3)).round(8)
    for a, b, c in amplitudes.tolist():
        square_millimetres = (a, 0.3, 0.1, b, 0.5, 2.0, c, 1.3, 0.9)
        with pytest.warns(FutureWarning):
            old = RigParameters({"valve.area_coefficients": square_millimetres})
        assert Plant.of(old).valve.area_coefficients == square_millimetres
        assert old.numbers("valve.area_coefficients")[0] == pytest.approx(a * 1e-6, rel=1e-15)


@pytest.mark.parametrize("largest", [1.001e-4, 1e-3, 9.99e-3])
def test_an_amplitude_that_could_be_a_slip_in_either_unit_is_refused(largest: float) -> None:
    """Between 100 mm² in m² and 0.01 mm² in mm² nothing is guessed; a line says how to convert."""
    with pytest.raises(ParameterError, match="values in mm² times 1e-6 are m²"):
        RigParameters({"valve.area_coefficients": (largest, *[0.0] * 8)})


@pytest.mark.parametrize("largest", [0.0, 1e-9, 1e-4])
def test_amplitudes_in_square_metres_are_left_as_they_are(largest: float) -> None:
    """No warning, no change."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        values = RigParameters(
            {"valve.area_coefficients": (-largest, *[1.0, 0.1, 0.0, 50.0, 0.2, 0.0, 1.0, 2.0])}
        )
    assert values.numbers("valve.area_coefficients")[0] == -largest


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("supply.pressure", "0.6e6"),
        ("supply.pressure", True),
        ("supply.pressure", None),
        ("supply.pressure", [6e5]),
        ("cylinder.locked", 1),
        ("cylinder.locked", "yes"),
        ("valve.assembly", "reconciledd"),
        ("friction.form", 1),
        ("valve.area_coefficients", 2.108),
        ("valve.area_coefficients", (2.108, 0.2636)),
        ("valve.flow_coefficients", "1.132"),
    ],
)
def test_a_value_of_the_wrong_type_is_refused(name: str, value: object) -> None:
    """Texts for numbers, numbers for truth values, wrong choices and lengths are refused, named."""
    with pytest.raises(ParameterError, match=name):
        RigParameters({name: value})


def test_an_integer_is_accepted_for_a_real() -> None:
    """600000 means 600000.0, alone and inside a list, and is kept as a float."""
    parameters = RigParameters(
        {"supply.pressure": 600000, "valve.flow_coefficients": [1] + [0] * 5}
    )
    assert parameters["supply.pressure"] == 600000.0
    assert isinstance(parameters["supply.pressure"], float)
    assert parameters.numbers("valve.flow_coefficients") == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"supply.pressure": 101324.0}, "supply.pressure"),
        ({"friction.forward.static": 11.9}, "friction.forward.static"),
        ({"friction.reverse.coulomb": 36.1}, "friction.reverse.static"),
        ({"valve.sleeve_diameter": 5.9e-3}, "valve.sleeve_diameter"),
        ({"air.isentropic_index": 1.3, "air.critical_ratio": 0.528}, "air.critical_ratio"),
        ({"cylinder.initial_position": 0.201}, "cylinder.initial_position"),
        ({"valve.flow_coefficients": (1.0, 0.0, 0.0, 0.0, 0.0, -1e-3)}, "valve.flow_coefficients"),
        ({"valve.flow_coefficients": (1.0, -1.0, 0.2, 0.0, 0.0, 0.0)}, r"-0\.25 at 2\.5 V"),
        ({"time.period": 0.2}, "valve.command_timeout"),
        ({"valve.command_timeout": 1e-3, "time.period": 2e-3}, "time.period"),
    ],
)
def test_values_that_contradict_each_other_are_refused(
    changes: dict[str, object], named: str
) -> None:
    """Supply below ambient, F_s below F_c, a sleeve inside its spool, backward flow: refused."""
    with pytest.raises(ParameterError, match=named):
        RigParameters(changes)


def test_a_pair_that_is_sound_together_is_accepted_together() -> None:
    """Raising F_c past the old F_s is fine when F_s rises with it: a change counts as a whole."""
    changed = RigParameters().with_values(
        {"friction.forward.coulomb": 40.0, "friction.forward.static": 50.0}
    )
    assert changed.number("friction.forward.coulomb") == 40.0


def test_an_unknown_name_is_refused_with_the_nearest_known_one() -> None:
    """``supply.presure`` is no parameter; the message offers ``supply.pressure``."""
    with pytest.raises(ParameterError, match=r"supply\.presure.*did you mean supply\.pressure\?"):
        RigParameters({"supply.presure": 6e5})


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("time.inner_step", "time.tolerance"),
        ("end_stop.stiffness", "end_stop.restitution"),
        ("end_stop.damping", "end_stop.restitution"),
    ],
)
def test_a_name_of_former_days_is_refused_with_what_replaces_it(name: str, instead: str) -> None:
    """The message names both, in one line."""
    with pytest.raises(ParameterError, match=f"^{name}: no longer a parameter.*{instead}") as found:
        RigParameters({name: 1.0})
    assert "\n" not in str(found.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"cylinder.moving_mass": 0.05},
        {"friction.forward.viscous": 1e5, "cylinder.moving_mass": 0.05},
        {"friction.forward.static": 1e4, "friction.forward.stribeck_velocity": 1e-4},
        {"cylinder.dead_volume_a": 2e-6, "cylinder.bore": 0.1},
        {"time.period": 1e-4, "time.tolerance": 1e3},
    ],
)
def test_no_combination_is_too_fast(changes: dict[str, object]) -> None:
    """Light, stiff, viscous and steep rigs are accepted: the integrator chooses its steps."""
    assert RigParameters(changes) != RigParameters()


def test_a_refused_change_changes_nothing() -> None:
    """With one bad value among good ones with_values raises and the original stays as it was."""
    parameters = RigParameters()
    before = dict(parameters)
    with pytest.raises(ParameterError, match=r"cylinder\.moving_mass"):
        parameters.with_values({"supply.pressure": 7e5, "cylinder.moving_mass": -1.0})
    assert dict(parameters) == before


def test_with_values_leaves_the_original_alone() -> None:
    """A change is a copy: the original keeps its value, the copy differs in that one only."""
    parameters = RigParameters()
    changed = parameters.with_values({"supply.pressure": 7e5})
    assert parameters["supply.pressure"] == 621325.0
    assert {name for name in parameters if parameters[name] != changed[name]} == {"supply.pressure"}


def test_parameters_are_equal_by_value_and_usable_as_keys() -> None:
    """Equal values are equal objects with equal hashes; one different value makes them differ."""
    one, same = RigParameters({"supply.pressure": 7e5}), RigParameters({"supply.pressure": 700000})
    other = RigParameters({"supply.pressure": 7.1e5})
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert {one: "rig"}[same] == "rig"


def test_parameters_cannot_be_changed_in_place() -> None:
    """Neither assignment nor deletion by name works, and a list given stays the caller's own."""
    coefficients = [1.132, 0.0, 0.0, 0.0, 0.0, 0.0]
    parameters = RigParameters({"valve.flow_coefficients": coefficients})
    with pytest.raises(TypeError):
        parameters["supply.pressure"] = 7e5  # type: ignore[index]
    with pytest.raises(TypeError):
        del parameters["supply.pressure"]  # type: ignore[attr-defined]
    coefficients[0] = 2.0
    assert parameters.numbers("valve.flow_coefficients")[0] == 1.132


def test_defaults_are_the_paper_preset() -> None:
    """The rig without a file is the paper's rig; the calibrated one slides more easily."""
    assert RigParameters.preset("paper") == RigParameters()
    assert RigParameters.preset("calibrated")["friction.form"] == "saturating"


def test_defaults_are_those_of_table_2_and_the_data_sheets() -> None:
    """Friction magnitudes of Table 2, the cylinder's bore and stroke, supply in absolute Pa."""
    parameters = RigParameters()
    names = ("static", "coulomb", "stribeck_velocity", "viscous")
    forward = [parameters[f"friction.forward.{name}"] for name in names]
    reverse = [parameters[f"friction.reverse.{name}"] for name in names]
    assert forward == [29.0, 12.0, 1.3e-3, 4500.0]
    assert reverse == [36.0, 12.5, 3.6e-3, 4800.0]
    assert parameters["cylinder.bore"] == 0.025
    assert parameters["cylinder.stroke"] == 0.2
    assert parameters["supply.pressure"] == 520e3 + 101325.0


def test_an_unknown_preset_is_refused_with_the_known_ones() -> None:
    """``papper`` is no preset; the message lists ``calibrated`` and ``paper``."""
    with pytest.raises(ParameterError, match=r"papper.*calibrated, paper"):
        RigParameters.preset("papper")


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_gives_its_values_to_the_plant(tmp_path: Path) -> None:
    """Dotted and nested names mean the same; other nodes' sections are none of the plant's."""
    path = write(
        tmp_path / "rig.yaml",
        "/**/plant:\n  ros__parameters:\n    supply.pressure: 600000\n"
        "    friction:\n      forward:\n        static: 20.0\n"
        "/**/controller:\n  ros__parameters:\n    controller.kp: 1.0\n",
    )
    parameters = RigParameters.from_file(path)
    assert parameters["supply.pressure"] == 600000.0
    assert parameters["friction.forward.static"] == 20.0
    assert parameters["friction.reverse.static"] == 36.0


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("supply.presure: 600000.0", "did you mean supply.pressure"),
        ("supply.pressure: .nan", "supply.pressure"),
        ("supply.pressure: 600 kPa", "supply.pressure"),
        ("supply.pressure: 90000.0", "atmosphere.pressure"),
    ],
)
def test_a_file_with_a_mistake_is_refused_with_its_path(
    tmp_path: Path, line: str, message: str
) -> None:
    """A misspelt name, NaN, a unit or a bad combination in a file raises and names the file."""
    path = write(tmp_path / "typo.yaml", f"/**/plant:\n  ros__parameters:\n    {line}\n")
    with pytest.raises(ParameterError, match=message) as caught:
        RigParameters.from_file(path)
    assert "typo.yaml" in str(caught.value)


@pytest.mark.parametrize("text", ["", "- a\n- b\n", "a: [1\n", "plant:\n  parameters:\n    x: 1\n"])
def test_a_file_that_is_no_parameter_file_is_refused(tmp_path: Path, text: str) -> None:
    """Empty, a list, broken YAML, no ros__parameters: refused with the file's name."""
    path = write(tmp_path / "broken.yaml", text)
    with pytest.raises(ParameterError, match=r"broken\.yaml"):
        RigParameters.from_file(path)


PRINTED_ASSEMBLY = {"valve.assembly": "printed"}
DEFAULT_AREA = RigParameters().numbers("valve.area_coefficients")


@pytest.mark.parametrize(
    ("coefficients", "place"),
    [
        # 2 sin(π/8 U): below zero from 8 V on.
        ((2e-6, math.pi / 8.0, 0.0, *[0.0] * 6), r"at 10 V"),
        # 1 + 1.001 sin(50 U): below zero for 2 mV at a time.
        ((1e-6, 0.0, math.pi / 2.0, 1.001e-6, 50.0, 0.0, 0.0, 0.0, 0.0), r"-0\.001 mm²"),
        ((-2e-6, 0.0, 1.0, *[0.0] * 6), r"-1\.68 mm²"),
    ],
)
def test_an_area_below_zero_is_refused_with_the_printed_assembly(
    coefficients: tuple[float, ...], place: str
) -> None:
    """Wherever from 0 to 10 V it is; the reconciled assembly counts from the smallest area."""
    values = {"valve.area_coefficients": coefficients}
    with pytest.raises(ParameterError, match=rf"^valve\.area_coefficients: .*{place}"):
        RigParameters({**values, **PRINTED_ASSEMBLY})
    reconciled = RigParameters(values)
    with pytest.raises(ParameterError, match=r"^valve\.area_coefficients: "):
        reconciled.with_values(PRINTED_ASSEMBLY)


def test_a_flow_coefficient_below_zero_is_refused() -> None:
    """With either assembly: at 5 V from closed, and right at the closed position."""
    falling = {"valve.flow_coefficients": (1.0, -0.3, 0.0, 0.0, 0.0, 0.0)}
    with pytest.raises(ParameterError, match=r"^valve\.flow_coefficients: .* -0\.5 at 5 V"):
        RigParameters(falling)
    # The printed one takes metres: -10 per metre is nothing over 1 mm, but it is below zero.
    hardly = {"valve.flow_coefficients": (0.0, 10.0, 0.0, 0.0, 0.0, 0.0)}
    RigParameters(hardly)
    with pytest.raises(ParameterError, match=r"^valve\.flow_coefficients: .* -0\.0108 with"):
        RigParameters({**hardly, **PRINTED_ASSEMBLY})


def test_the_papers_printed_valve_is_accepted() -> None:
    """Its area is positive from 0 to 10 V: 0.0118 mm² where it is least."""
    assert RigParameters(PRINTED_ASSEMBLY).numbers("valve.area_coefficients") == DEFAULT_AREA


@pytest.mark.parametrize("last", [5e-324, 1e-300, 1e-30])
def test_a_flow_coefficient_that_adds_nothing_hides_no_other(last: float) -> None:
    """A fifth power next to zero changes neither what is taken nor where it is too low."""
    good = RigParameters({"valve.flow_coefficients": (1.0, -0.1, 0.02, 0.0, 0.0, last)})
    assert good.numbers("valve.flow_coefficients")[5] == last
    falling = {"valve.flow_coefficients": (1.0, -1.0, 0.2, 0.0, 0.0, last)}
    with pytest.raises(ParameterError, match=r"-0\.25 at 2\.5 V"):
        RigParameters(falling)
