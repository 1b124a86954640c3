# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Mass flow through an orifice and through a slit, against theory that stands on its own."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from rodless_sim import RigParameters
from rodless_sim.physics.flow import gap_conductance, gap_flow, nozzle_function, orifice_flow
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings

PLANT = Plant.of(RigParameters())
AIR = PLANT.air
AREA = 1e-6
REFERENCE_DENSITY = 1.185  # kg/m³ at 100 kPa, 20 °C, 65 % humidity (ISO 8778, "ANR")
LITRES_PER_MINUTE = 60e3 / REFERENCE_DENSITY


def test_choked_flow_by_hand() -> None:
    """1 mm² from 700 kPa at 297 K passes 0.684731·P·S/√(RT) = 1.64158e-3 kg/s when choked."""
    # for κ = 1.4 the choked function is √κ (2/(κ+1))³ = 1.183216*0.578704 = 0.684731
    # √(287.05*297) = 291.9826; 0.684731*7e5*1e-6/291.9826 = 0.4793117/291.9826
    assert orifice_flow(AIR, AREA, 7e5, 1e5) == pytest.approx(0.4793117 / 291.9826, rel=2e-6)


def test_subsonic_flow_by_hand() -> None:
    """At pressure ratio 0.9 the nozzle function is √(7 (r^(10/7) - r^(12/7))) = 0.42258."""
    # 0.9^(5/7) = 0.927505; squared 0.860265; times 0.9: 0.834754; √(7*0.0255107) = 0.422581
    assert nozzle_function(AIR, 0.9) == pytest.approx(0.422581, rel=3e-6)


def test_choked_flow_is_the_maximum_of_the_subsonic_formula() -> None:
    """Among all throat pressures of an isentropic nozzle the choked one passes the most air."""
    ratios = np.linspace(0.3, 0.99, 100001)
    subsonic = np.sqrt(7.0 * (ratios ** (2 / 1.4) - ratios ** (2.4 / 1.4)))
    assert nozzle_function(AIR, 0.2) == pytest.approx(subsonic.max(), rel=1e-9)


def test_flow_is_continuous_where_it_chokes() -> None:
    """At the critical ratio b the subsonic and the choked branch meet within 1 ppm."""
    below = orifice_flow(AIR, AREA, 6e5, 6e5 * (AIR.critical_ratio - 1e-12))
    above = orifice_flow(AIR, AREA, 6e5, 6e5 * AIR.critical_ratio)
    assert above == pytest.approx(below, rel=1e-6)


def test_flow_is_continuous_where_it_turns_laminar() -> None:
    """At r = 0.999 the nozzle formula and the straight line to zero meet."""
    below = orifice_flow(AIR, AREA, 6e5, 6e5 * (0.999 - 1e-10))
    above = orifice_flow(AIR, AREA, 6e5, 6e5 * (0.999 + 1e-10))
    assert above == pytest.approx(below, rel=1e-6)


@pytest.mark.parametrize("downstream", [1.0e5, 3.5e5, 5.99e5, 5.9999e5])
def test_orifice_flow_reverses_with_the_pressures(downstream: float) -> None:
    """Exchanging the two pressures exchanges the sign of the flow and nothing else."""
    forward = orifice_flow(AIR, AREA, 6e5, downstream)
    assert forward > 0.0
    assert orifice_flow(AIR, AREA, downstream, 6e5) == -forward


def test_slit_flow_reverses_with_the_pressures() -> None:
    """The slit, too, passes the same flow the other way when its pressures are exchanged."""
    assert gap_flow(5e-17, 2e5, 6e5) == -gap_flow(5e-17, 6e5, 2e5)
    assert gap_flow(5e-17, 6e5, 2e5) > 0.0


def test_no_flow_at_equal_pressures_and_finite_slope_there() -> None:
    """Flow is zero at P1 = P2 and grows in proportion to a small difference, not as its root."""
    assert orifice_flow(AIR, AREA, 4e5, 4e5) == 0.0
    assert gap_flow(5e-17, 4e5, 4e5) == 0.0
    small = orifice_flow(AIR, AREA, 4e5, 4e5 - 1e-3)
    assert orifice_flow(AIR, AREA, 4e5, 4e5 - 1.0) == pytest.approx(1000.0 * small, rel=1e-3)


def test_flow_falls_as_the_far_pressure_rises() -> None:
    """Raising the downstream pressure never raises the flow, and lowers it once not choked.

    The paper's b is rounded (0.528 for 0.52828), which leaves a step of 0.1 ppm where it chokes.
    """
    pressures = np.linspace(0.0, 12e5, 4001)
    flows = np.array([orifice_flow(AIR, AREA, 6e5, p) for p in pressures])
    assert np.all(np.diff(flows) <= 1e-7 * flows[0])
    assert np.all(np.diff(flows[pressures > 3.2e5]) < 0.0)


def test_flow_rises_with_the_near_pressure() -> None:
    """Raising the near pressure always raises the flow, backwards, forwards and choked.

    Below 0.528 of the far pressure the backward flow is choked and the near side is not felt.
    """
    flows = [orifice_flow(AIR, AREA, p, 3e5) for p in np.linspace(1.6e5, 12e5, 4001)]
    assert np.all(np.diff(flows) > 0.0)


def test_fully_open_valve_passes_its_rated_flow() -> None:
    """The maker rates the valve 100 L/min ± 10 % free air from 6 to 5 bar gauge, fully open."""
    edges = openings(PLANT, 10.0)
    flow = orifice_flow(AIR, edges.opening.orifice_area, 701325.0, 601325.0)
    assert 90.0 < flow * LITRES_PER_MINUTE < 110.0


def test_constant_of_eq_4_is_that_of_an_ideal_choked_nozzle() -> None:
    """At 273 K, 1 mm² passes 0.124 L/min of free air per kPa of upstream pressure, eq. (4)."""
    air = AIR._replace(temperature=273.0)
    per_kilopascal = orifice_flow(air, AREA, 500e3, 0.0) / 500.0 * LITRES_PER_MINUTE
    assert per_kilopascal == pytest.approx(0.124, abs=0.0005)


@pytest.mark.parametrize("pressures", [(6.2e5, 1.01e5), (6.2e5, 4.4e5), (1.01e5, 4.4e5)])
def test_slit_flow_against_integration_along_the_slit(pressures: tuple[float, float]) -> None:
    """Driven by the slit's flow, d(P²)/dx integrated over the length ends at the far pressure.

    At every place the plane flow passes ṁ = -ρ w h³/(12 μ) dP/dx with ρ = P/(R T), that is
    d(P²)/dx = -24 μ R T ṁ/(w h³).
    """
    width, height, length = math.pi * 6e-3, 6e-6, 2.1e-3
    flow = gap_flow(gap_conductance(AIR, width, height, length), *pressures)
    gas = AIR.gas_constant * AIR.temperature

    def slope(_: float, pressure: np.ndarray) -> np.ndarray:
        return -12.0 * AIR.viscosity * flow * gas / (width * height**3 * pressure)

    along = solve_ivp(slope, (0.0, length), [pressures[0]], rtol=1e-10, atol=1e-4)
    assert along.y[0, -1] == pytest.approx(pressures[1], rel=1e-6)


def test_parabola_of_eq_11_carries_a_twelfth_of_the_height_cubed() -> None:
    """The velocity profile z(h - z)/(2 μ) integrates to the h³/(12 μ) the conductance uses."""
    height = 6e-6
    profile = quad(lambda z: z * (height - z) / (2.0 * AIR.viscosity), 0.0, height)[0]
    gas, width, length = AIR.gas_constant * AIR.temperature, 0.02, 2e-3
    expected = width * profile / (2.0 * length * gas)
    assert gap_conductance(AIR, width, height, length) == pytest.approx(expected, rel=1e-9)
