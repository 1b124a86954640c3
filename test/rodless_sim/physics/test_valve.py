# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The valve's openings: eqs. (5), (24), (25) at hand-computed points, and their assembly."""

import math
from types import ModuleType

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters
from rodless_sim.physics import valve_assembly
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.valve import (
    centred_area,
    effective_area,
    flow_coefficient,
    spool_displacement,
)
from rodless_sim.physics.valve_assemblies import reconciled

PLANT = Plant.of(RigParameters())
DEFLECTIONS = np.linspace(-5.08, 4.92, 1001)


@pytest.mark.parametrize(
    ("voltage", "area"),
    [
        # 2.108 sin(0.1742)   + 2.012 sin(2.157)    - 0.0933 sin(0.9104), calculator in radians
        # 2.108 x 0.173320    + 2.012 x 0.833047    - 0.0933 x 0.789749
        (0.0, 0.365359 + 1.676090 - 0.073684),
        # 2.108 sin(1.513288) + 2.012 sin(4.621308) - 0.0933 sin(7.671880)
        # 2.108 x 0.998347    - 2.012 x 0.995855    - 0.0933 x 0.983465
        (5.08, 2.104515 - 2.003660 - 0.091757),
        # 2.108 sin(1.808520) + 2.012 sin(5.164620) - 0.0933 sin(9.162600)
        # 2.108 x 0.971877    - 2.012 x 0.899474    - 0.0933 x 0.259185
        (6.2, 2.048716 - 1.809743 - 0.024182),
        # 2.108 sin(2.810200) + 2.012 sin(7.008000) - 0.0933 sin(14.220400)
        # 2.108 x 0.325360    + 2.012 x 0.662997    - 0.0933 x 0.996538
        (10.0, 0.685859 + 1.333949 - 0.092977),
    ],
)
def test_effective_area_of_eq_5_at_hand_computed_voltages(voltage: float, area: float) -> None:
    """S in mm² equals the three sines worked out with a pocket calculator, and is given in m²."""
    assert effective_area(PLANT.valve, voltage) == pytest.approx(area * 1e-6, abs=3e-12)


def test_smallest_area_lies_at_the_curve_centre() -> None:
    """The measured curve has its minimum where the default ``valve.curve_centre`` says."""
    voltages = np.linspace(4.5, 6.0, 15001)
    areas = [effective_area(PLANT.valve, u) for u in voltages]
    assert voltages[np.argmin(areas)] == pytest.approx(PLANT.valve.curve_centre, abs=2e-4)


def test_centred_area_is_the_measured_curve_less_its_minimum() -> None:
    """S_e(d) = S(5.2416 + d) - S_min: zero when closed; at d = 0.9584 V, S(6.2) - 0.002678 mm²."""
    assert centred_area(PLANT.valve, 0.0) == 0.0
    # S(6.2) = 0.214791 mm² from the calculator lines above, S_min = 0.002678 mm²
    assert centred_area(PLANT.valve, 0.9584) == pytest.approx(0.212113e-6, abs=3e-12)


@pytest.mark.parametrize(
    ("deflection", "coefficient"),
    [
        (0.0, 1.132),
        # 1.132 - 0.006917 - 0.0339 + 0.02509 - 0.006486 + 0.0004983
        (1.0, 1.1102853),
        # 1.132 - 0.006917*2 - 0.0339*4 + 0.02509*8 - 0.006486*16 + 0.0004983*32
        (2.0, 1.132 - 0.013834 - 0.1356 + 0.20072 - 0.103776 + 0.0159456),
        # 1.132 - 0.006917*5 - 0.0339*25 + 0.02509*125 - 0.006486*625 + 0.0004983*3125
        (5.0, 1.132 - 0.034585 - 0.8475 + 3.13625 - 4.05375 + 1.5571875),
    ],
)
def test_flow_coefficient_of_eq_25_at_hand_computed_deflections(
    deflection: float, coefficient: float
) -> None:
    """C_v equals the polynomial worked out by hand, and is the same on both sides of closed."""
    assert flow_coefficient(PLANT.valve, deflection) == pytest.approx(coefficient, abs=1e-12)
    assert flow_coefficient(PLANT.valve, -deflection) == pytest.approx(coefficient, abs=1e-12)


def test_flow_coefficient_holds_its_value_beyond_the_fitted_range() -> None:
    """Past 5 V of deflection C_v keeps its value at 5 V; the polynomial itself turns upwards."""
    assert flow_coefficient(PLANT.valve, -5.08) == flow_coefficient(PLANT.valve, -5.0)


def test_flow_coefficient_stays_positive_and_never_exceeds_its_closed_value() -> None:
    """C_v lies between 0 and 1.132 at every deflection: opening the valve costs flow efficiency."""
    values = [flow_coefficient(PLANT.valve, d) for d in DEFLECTIONS]
    assert min(values) > 0.5
    assert max(values) <= 1.132


@pytest.mark.parametrize(
    ("voltage", "displacement"),
    [
        # 0.00021485*5.05 - 0.00108499 = 0.0010849925 - 0.00108499
        (5.05, 2.5e-9),
        # 0.00021485*10 - 0.00108499
        (10.0, 1.06351e-3),
        (0.0, -1.08499e-3),
    ],
)
def test_spool_displacement_of_eq_24_at_hand_computed_voltages(
    voltage: float, displacement: float
) -> None:
    """x_v equals the straight line of eq. (24): about ±1 mm of travel over 0-10 V."""
    assert spool_displacement(voltage) == pytest.approx(displacement, abs=1e-12)


def test_openings_have_no_jump_at_the_closed_voltage() -> None:
    """Just below and just above 5.08 V all four edges are the same: nothing is thrown over."""
    below = openings(PLANT, 5.08 - 1e-9)
    above = openings(PLANT, 5.08 + 1e-9)
    assert below.opening.gap == pytest.approx(above.closing.gap, rel=1e-8)
    assert below.closing.gap == pytest.approx(above.opening.gap, rel=1e-8)
    assert below.opening.orifice_area < 1e-18
    assert above.opening.orifice_area < 1e-18


def test_only_the_opening_edge_has_an_orifice_and_it_grows_with_deflection() -> None:
    """C_v·S rises from zero with the deflection both ways; the closing edge keeps only its gap.

    From 4.4 V on, near the ends of the range, the fitted S and C_v are flat and pull apart by 3 %.
    """
    for side in (1.0, -1.0):
        edges = [openings(PLANT, 5.08 + side * d) for d in np.arange(0.0, 4.4, 0.05)]
        areas = np.array([edge.opening.orifice_area for edge in edges])
        assert areas[0] == 0.0
        assert np.all(np.diff(areas) > 0.0)
        assert all(edge.closing.orifice_area == 0.0 for edge in edges)


def test_closing_gap_thins_as_its_overlap_lengthens() -> None:
    """At 1 V from closed the overlap is 2 mm + 0.21485 mm, so the gap passes 2/2.21485 as much."""
    closed = openings(PLANT, 5.08).closing.gap
    opened = openings(PLANT, 6.08).closing.gap
    assert opened / closed == pytest.approx(2.0 / 2.21485, rel=1e-12)


def test_opening_edge_gap_fades_away_as_the_land_clears() -> None:
    """The opening edge's gap shrinks with deflection and is under 1 % of itself at 1.5 V."""
    gaps = [openings(PLANT, 5.08 + d).opening.gap for d in np.arange(0.0, 1.6, 0.1)]
    assert np.all(np.diff(gaps) < 0.0)
    assert gaps[15] < 0.01 * gaps[0]


def test_closed_valve_gap_conductance_by_hand() -> None:
    """π d_s h0³/(24 μ L0 R T_s) with d_s 6 mm, h0 6 µm, L0 2 mm: 5.437e-17 kg/(s·Pa²)."""
    # numerator   3.14159*6e-3*216e-18 = 4.0715e-18
    # denominator 24*1.83e-5*2e-3*287.05*297 = 8.784e-7*85253.85 = 0.0748870
    assert openings(PLANT, 5.08).closing.gap == pytest.approx(4.0715e-18 / 0.0748870, rel=2e-5)
    assert math.isclose(PLANT.valve.gap_height, 6e-6)


@pytest.mark.parametrize(
    ("kernel", "answer", "wanted"),
    [
        ("lands", 3.0, "lands returns 3.0, but must return a Lands, such as Lands("),
        ("lands", Lands(True, Edge(0, 0.0), Edge(0.0, 0.0)), "lands returns Lands(forward=True"),
        ("lands", Lands(1.0, Edge(0.0, 0.0), Edge(0.0, 0.0)), "lands returns Lands(forward=1.0"),
        ("gap", (0.0, 0.0, 0.0), "gap returns (0.0, 0.0, 0.0), but must return a Flow, such as"),
        ("gap", None, "gap returns None, but must return a Flow, such as"),
    ],
)
def test_an_assembly_that_returns_something_else_is_named(
    monkeypatch: pytest.MonkeyPatch, kernel: str, answer: object, wanted: str
) -> None:
    """Module, kernel and answer, in one line, instead of the compiler's pages."""
    odd = ModuleType("own.odd")
    vars(odd).update({**vars(reconciled), "__name__": "own.odd", kernel: lambda *_: answer})
    monkeypatch.setattr(valve_assembly, "ASSEMBLIES", (reconciled, odd))
    with pytest.raises(TypeError) as refused:
        Rig()
    assert str(refused.value).startswith(f"own.odd: {wanted}")
    assert "\n" not in str(refused.value)
