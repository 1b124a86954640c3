# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A model number sets the cylinder: sizes of the catalogue, and what grows with them."""

import math

import pytest

from rodless_sim import ParameterError, RigParameters, simulate
from rodless_sim.cylinder_series import BORES, values_of

# SMC catalogue ES20-172C: theoretical output in N at 0.5 MPa.
OUTPUT = {6: 14, 10: 39, 15: 88, 20: 157, 25: 245, 32: 402, 40: 628, 50: 981, 63: 1559}

# Highest supply of the series, Pa absolute.
HIGHEST_SUPPLY = 0.7e6 + 101325.0


def model(bore: int, stroke: int = 200) -> RigParameters:
    """A rig with a cylinder of the series."""
    return RigParameters({"cylinder.model": f"CY3R{bore}-{stroke}"})


def test_papers_cylinder_is_the_default() -> None:
    """The number of the paper's cylinder changes nothing at all."""
    assert model(25) == RigParameters()
    assert values_of("CY3R25-200").items() <= dict(RigParameters()).items()


@pytest.mark.parametrize("bore", BORES)
def test_force_is_the_catalogues(bore: int) -> None:
    """Bore in m: 0.5 MPa push with the force that the catalogue lists."""
    area = math.pi / 4.0 * model(bore).number("cylinder.bore") ** 2
    assert area * 0.5e6 == pytest.approx(OUTPUT[bore], abs=1.0)


@pytest.mark.parametrize("bore", BORES)
def test_same_pressure_moves_every_bore(bore: int) -> None:
    """The pressure difference that breaks the carriage away is the same for all bores."""
    for side in ("forward", "reverse"):
        pressures = [
            one.number(f"friction.{side}.static") / one.number("cylinder.bore") ** 2
            for one in (model(bore), model(25))
        ]
        assert pressures[0] == pytest.approx(pressures[1], rel=1e-12)


@pytest.mark.parametrize("bore", BORES)
def test_whole_stroke_at_the_highest_supply(bore: int) -> None:
    """Every bore runs from end to end and back, and rests within its stroke."""
    rig = model(bore).with_values({"supply.pressure": HIGHEST_SUPPLY})
    run = simulate(rig, [10.0] * 15000 + [0.0] * 15000, period=1e-3)
    assert run.position[15000] == pytest.approx(0.2, abs=5e-4)
    assert run.position[-1] == pytest.approx(0.0, abs=5e-4)
    assert run.position.min() > -5e-4
    assert run.position.max() < 0.2005


def test_what_is_given_beside_it_stays() -> None:
    """A load of one's own on a cylinder of the series."""
    rig = RigParameters({"cylinder.model": "CY3R32-500", "cylinder.moving_mass": 7.0})
    assert rig["cylinder.moving_mass"] == 7.0
    assert rig["cylinder.stroke"] == 0.5
    later = model(32, 500).with_values({"cylinder.moving_mass": 7.0})
    assert later == rig


def test_new_model_replaces_the_old_ones_values() -> None:
    """From one cylinder to another and back nothing is left of the first."""
    there = RigParameters().with_values({"cylinder.model": "CY3R63-1000"})
    assert there == model(63, 1000)
    assert there.with_values({"cylinder.model": "CY3R25-200"}) == RigParameters()


def test_the_model_it_has_already_changes_nothing() -> None:
    """`ros2 param load` gives a dump's values one by one in the order of the alphabet.

    A dead volume of one's own, given before the model, is still there after it.
    """
    dump = model(32, 500).with_values({"cylinder.dead_volume_a": 9e-5})
    rig = dump.with_values({"cylinder.dead_volume_a": 1e-5, "cylinder.moving_mass": 7.0})
    for name in sorted(dump):
        rig = rig.with_values({name: dump[name]})
    assert rig == dump


@pytest.mark.parametrize(
    "values", [{"cylinder.bore": 0.024}, {"cylinder.stroke": 0.3}, {"cylinder.model": "other"}]
)
def test_another_size_is_another_cylinder(values: dict[str, object]) -> None:
    """A bore or stroke of one's own, as files had before, is no model's, and nothing else moves."""
    rig = RigParameters(values)
    assert rig["cylinder.model"] == "other"
    assert set(rig.differences(RigParameters())) == {"cylinder.model", *values}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"cylinder.model": "CY3B25-200"}, "CY3R<bore>-<stroke>"),
        ({"cylinder.model": "CY3R25"}, "CY3R<bore>-<stroke>"),
        ({"cylinder.model": ""}, "CY3R<bore>-<stroke>"),
        ({"cylinder.model": "CY3R25-\u09e9\u09e6\u09e6"}, "CY3R<bore>-<stroke>"),
        ({"cylinder.model": "CY3R28-200"}, "bores 6, 10, 15"),
        ({"cylinder.model": "CY3R25-5"}, "from 10 to 2000 mm"),
        ({"cylinder.model": "CY3R25-9999"}, "from 10 to 2000 mm"),
        ({"cylinder.model": "CY3R32-500", "cylinder.bore": 0.025}, "has 0.032 m"),
        ({"cylinder.model": "CY3R25-100", "cylinder.initial_position": 0.15}, "beyond"),
    ],
)
def test_what_is_no_cylinder_is_refused(values: dict[str, object], words: str) -> None:
    """In one line that names the value and the way out."""
    with pytest.raises(ParameterError, match=words) as caught:
        RigParameters(values)
    assert "\n" not in str(caught.value)
