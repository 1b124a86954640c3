# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The flow law of ISO 6358-1 against the standard's own formula, in closed form and by number."""

import math
from functools import partial

import numpy as np
import pytest

from rodless_sim import ParameterError, RigParameters
from rodless_sim.physics.flow_law import function, orifice
from rodless_sim.physics.flow_laws import iso_6358
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings

CHOSEN = {"valve.flow_law": "iso_6358"}
PLANT = Plant.of(RigParameters(CHOSEN))
REFERENCE_DENSITY = 1.185  # kg/m³ at 100 kPa, 20 °C, 65 % humidity (ISO 8778, "ANR")
WIDEST = iso_6358.widest_opening_of(RigParameters(CHOSEN))
RATIOS = np.random.default_rng(6358).uniform(0.36, 0.999, 200).tolist()


def flow_at(plant: Plant, ratio: float) -> float:
    """Mass flow of the widest orifice from 600 kPa."""
    return orifice(plant.flow_law, plant.air, WIDEST, 6e5, 6e5 * ratio).mass_flow


def by_the_standard(ratio: complex, b: float = 0.35, m: float = 0.5) -> complex:
    """ṁ = C P₁ ρ₀ √(T₀/T₁) φ, C 3.9 dm³/(s·MPa), from 600 kPa at 297 K."""
    choked = 3.9e-9 * 6e5 * REFERENCE_DENSITY * math.sqrt(293.15 / 297.0)
    if ratio.real <= b:
        return complex(choked)
    return choked * (1.0 - ((ratio - b) / (1.0 - b)) ** 2) ** m


@pytest.mark.parametrize(
    ("ratio", "share"),
    [
        # The ellipse x² + φ² = 1 over x = (r − 0.35)/0.65: by Pythagorean triples.
        (0.10, 1.0),
        (0.35, 1.0),
        (0.35 + 0.65 * 0.28, 0.96),
        (0.35 + 0.65 * 0.60, 0.80),
        (0.35 + 0.65 * 0.80, 0.60),
        (0.35 + 0.65 * 0.96, 0.28),
        (1.0, 0.0),
    ],
)
def test_points_of_the_ellipse(ratio: float, share: float) -> None:
    """With m = 0.5 the flow is an ellipse over the pressure ratio; points on it by hand."""
    choked = 2.754869e-3  # 3.9e-9 · 6e5 · 1.185 · √(293.15/297) kg/s
    assert flow_at(PLANT, ratio) == pytest.approx(share * choked, rel=1e-6)


@pytest.mark.parametrize(("b", "m"), [(0.35, 0.5), (0.2, 0.5), (0.45, 0.58), (0.0, 1.0)])
def test_the_formula_of_the_standard(b: float, m: float) -> None:
    """From vacuum to r = 0.999, for other b and m too."""
    values = {**CHOSEN, "valve.critical_ratio": b, "valve.subsonic_index": m}
    plant = Plant.of(RigParameters(values))
    for ratio in np.linspace(0.0, 0.999, 300).tolist():
        assert flow_at(plant, ratio) == pytest.approx(by_the_standard(ratio, b, m).real, rel=1e-12)


def test_the_slope_by_complex_step() -> None:
    """dψ/dr beside the law is that of the standard's formula, exact to rounding."""
    scale = flow_at(PLANT, 0.0)
    for ratio in RATIOS:
        exact = by_the_standard(complex(ratio, 1e-30)).imag / 1e-30 / scale
        found, slope = function(PLANT.flow_law.code, PLANT.flow_law.own, PLANT.air, ratio)
        choked, _ = function(PLANT.flow_law.code, PLANT.flow_law.own, PLANT.air, 0.0)
        assert slope / choked == pytest.approx(exact, rel=1e-11)
        assert 0.0 < found < choked


def test_value_and_slope_are_continuous_where_it_chokes() -> None:
    """On both sides of b the flow is the same and does not change with the ratio."""
    at = partial(function, PLANT.flow_law.code, PLANT.flow_law.own, PLANT.air)
    below, above = at(0.35 - 1e-9), at(0.35 + 1e-9)
    assert below[0] == pytest.approx(above[0], rel=1e-12)
    assert below[1] == 0.0
    assert abs(above[1]) < 1e-8
    edge, line = at(0.999), at(0.999 + 1e-12)
    assert edge[0] == pytest.approx(line[0], rel=1e-8)
    assert line[0] == pytest.approx(-line[1] * 0.001, rel=1e-8)


def test_flow_reverses_with_the_pressures() -> None:
    """The same flow backwards, its derivatives exchanged; none at equal pressures or no opening."""
    passed = partial(orifice, PLANT.flow_law, PLANT.air)
    for ratio in RATIOS[:20]:
        forward, back = passed(1e-6, 6e5, 6e5 * ratio), passed(1e-6, 6e5 * ratio, 6e5)
        assert forward == (-back[0], -back[2], -back[1])
    assert passed(1e-6, 4e5, 4e5).mass_flow == 0.0
    assert passed(0.0, 4e5, 1e5) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
@pytest.mark.parametrize("discharge", ["polynomial", "constant"])
def test_the_widest_opening_has_the_conductance_of_the_data_sheet(
    assembly: str, discharge: str
) -> None:
    """However the area is put together, its largest passes C P ρ₀ √(T₀/T) when choked.

    From 6 to 5 bar gauge that is the rated 100 L/min within 10 %.
    """
    values = {**CHOSEN, "valve.assembly": assembly, "valve.discharge": discharge}
    parameters = RigParameters({**values, "valve.gap_height": 0.0})
    plant = Plant.of(parameters)
    voltages = np.linspace(0.0, 10.0, 101)
    edges = [openings(plant, float(voltage)).opening for voltage in voltages]
    widest = max(edges, key=lambda edge: edge.orifice_area)._replace(gap=0.0)
    choked = 3.9e-9 * 7e5 * REFERENCE_DENSITY * math.sqrt(293.15 / 297.0)
    assert edge_flow(plant, widest, 7e5, 1e5) == pytest.approx(choked, rel=1e-12)
    litres = edge_flow(plant, widest, 701325.0, 601325.0) / REFERENCE_DENSITY * 6e4
    assert 90.0 < litres < 110.0


def test_a_valve_that_never_opens_is_refused() -> None:
    """Without an opening there is none that C belongs to; the nozzle law goes on with it."""
    shut = {"valve.discharge": "constant", "valve.discharge_coefficient": 0.0}
    assert RigParameters(shut)["valve.flow_law"] == "nozzle"
    with pytest.raises(ParameterError, match=r"^valve\.flow_law: iso_6358 refused, .* 0 m²"):
        RigParameters({**shut, **CHOSEN})
