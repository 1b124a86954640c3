# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The paper's misprints, one test each: the fault in the printed form, the form used sound.

Equation numbers are those of Zhang et al., Actuators 2022, 11, 50. Printed forms are written out
here; what the rig uses is taken from it.
"""

import itertools
import math

import numpy as np
import pytest

from rodless_sim import ParameterError, Rig, RigParameters, simulate
from rodless_sim.physics.cylinder import pressure_rate
from rodless_sim.physics.equations import rates
from rodless_sim.physics.flow import gap_conductance, gap_flow, orifice_flow
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.state import Motion
from rodless_sim.physics.valve import effective_area, flow_coefficient, spool_displacement

PARAMETERS = RigParameters()
PLANT = Plant.of(PARAMETERS)
AMBIENT = 101325.0
LITRES_PER_MINUTE = 60e3 / 1.185
FRICTION_RUN = {"supply.pressure": 0.5e6 + AMBIENT}


def assembled(assembly: str, **more: object) -> Plant:
    return Plant.of(RigParameters({"valve.assembly": assembly, **FRICTION_RUN, **more}))


def blocked_force(plant: Plant, voltage: float) -> float:
    """A·(P_a - P_b) in N on a held piston once its chambers have settled."""
    pressure_a, pressure_b = settled_pressures(plant, voltage)
    return plant.cylinder.piston_area * (pressure_a - pressure_b)


def test_table_1_valve_pressure_range() -> None:
    """Printed: 0-100 MPa. The rig refuses a hundredth of that, and takes the data sheet's 1 MPa."""
    with pytest.raises(ParameterError, match=r"supply\.pressure"):
        RigParameters({"supply.pressure": 2e6})
    assert RigParameters({"supply.pressure": 1e6 + AMBIENT})["supply.pressure"] > 1e6


def test_eq_4_pressure_unit() -> None:
    """S = q/(0.124 P_u) √(T_1/273): with P_u in MPa it is a thousand times the nozzle's own area.

    An ideal choked nozzle of 1 mm² at 0.5 MPa and 293 K gives the flow; with P_u in kPa eq. (4)
    finds 1 mm² again, within 1 %.
    """
    air = PLANT.air._replace(temperature=293.0)
    litres = orifice_flow(air, 1e-6, 0.5e6, AMBIENT) * LITRES_PER_MINUTE
    area = math.sqrt(293.0 / 273.0) * litres / 0.124
    assert area / 0.5 == pytest.approx(1000.0, rel=0.01)
    assert area / 500.0 == pytest.approx(1.0, rel=0.01)


def test_eq_5_curve_is_not_centred_on_the_closed_position() -> None:
    """The printed curve has its minimum at 5.24 V, so at the closed 5.08 V it is 3.4 times as open.

    Re-centred, the opening is least, and nothing, at 5.08 V.
    """
    voltages = np.linspace(4.5, 5.8, 1301)
    printed = [effective_area(PLANT.valve, u) for u in voltages]
    assert voltages[np.argmin(printed)] > 5.2
    assert effective_area(PLANT.valve, 5.08) / min(printed) == pytest.approx(3.40, abs=0.02)
    used = [openings(PLANT, u).opening.orifice_area for u in voltages]
    assert voltages[np.argmin(used)] == pytest.approx(5.08, abs=1e-9)
    assert min(used) == 0.0


def test_eq_5_at_the_voltage_of_the_forward_run() -> None:
    """At 5.24 V the paper's carriage ran forward: the printed assembly drives it backward.

    Re-centred it creeps forward, a stick-slip of half a millimetre per second.
    """
    assert blocked_force(assembled("printed"), 5.24) < -36.0
    assert blocked_force(assembled("reconciled"), 5.24) > 29.0
    used = RigParameters(FRICTION_RUN)
    voltages = np.full(20_000, 5.24)
    assert simulate(used, voltages, 1e-3, 0.1).position[-1] > 0.103
    printed = used.with_values({"valve.assembly": "printed"})
    assert simulate(printed, voltages, 1e-3, 0.1).position[-1] < 0.05


def nozzle_radicand(ratio: float) -> float:
    """What stands under the root of eqs. (6), (7), (19), (20)."""
    return 7.0 * (ratio ** (2.0 / 1.4) - ratio ** (2.4 / 1.4))


def test_eq_6_with_the_downstream_side_higher() -> None:
    """Printed: the root of a negative number as soon as P_a > P_s. Used: the flow turns round."""
    assert nozzle_radicand(1.001) < 0.0
    assert orifice_flow(PLANT.air, 1e-6, 5e5, 5.005e5) < 0.0


def test_eq_6_slope_at_equal_pressures() -> None:
    """Printed: the slope dṁ/dr grows without bound towards r = 1. Used: it stays what it is."""

    def printed_slope(gap: float) -> float:
        return math.sqrt(nozzle_radicand(1.0 - gap)) / gap

    def used_slope(gap: float) -> float:
        return orifice_flow(PLANT.air, 1e-6, 5e5, 5e5 * (1.0 - gap)) / gap

    assert printed_slope(1e-8) > 90.0 * printed_slope(1e-4)
    assert used_slope(1e-8) == pytest.approx(used_slope(1e-4), rel=1e-6)


def test_eq_6_area_unit() -> None:
    """With S in mm² as printed 1 mm² at 0.6 MPa would pass over a tonne per second, not 1.4 g/s."""
    flow = orifice_flow(PLANT.air, 1e-6, 6e5, AMBIENT)
    printed = 1.0 * 6e5 / math.sqrt(287.05 * 297.0) * 0.684731
    assert printed > 1000.0
    assert flow == pytest.approx(1e-6 * printed, rel=1e-5)


def test_gas_constant() -> None:
    """8.31432e3 makes sound run at 1.86 km/s in air of 0.041 kg/m³; 287.05 gives both right."""

    def sound(gas_constant: float) -> float:
        return math.sqrt(1.4 * gas_constant * 297.0)

    assert sound(8314.32) > 1800.0
    assert sound(PLANT.air.gas_constant) == pytest.approx(345.5, abs=0.5)
    assert AMBIENT / (8314.32 * 297.0) < 0.05
    assert AMBIENT / (PLANT.air.gas_constant * 297.0) == pytest.approx(1.19, abs=0.01)


def profile(sign: float, pressure_slope: float) -> float:
    """Middle velocity of dP/dx = sign·μ u'' between two walls, by finite differences."""
    cells, height = 100, 6e-6
    second = np.diag(np.full(cells - 1, -2.0)) + np.diag(np.ones(cells - 2), 1)
    second += np.diag(np.ones(cells - 2), -1)
    second /= (height / cells) ** 2
    load = np.full(cells - 1, pressure_slope / (sign * PLANT.air.viscosity))
    return float(np.linalg.solve(second, load)[cells // 2 - 1])


def test_eq_8_sign() -> None:
    """With the printed minus air runs from low to high pressure; with plus it runs downhill.

    The plus agrees with the paper's own eq. (11), u = -z(z - h)/(2μ) · dP/dx, only up to a sign
    that eq. (15) corrects; the flow used runs from the higher pressure to the lower.
    """
    falling = -1e8
    assert profile(-1.0, falling) < 0.0
    assert profile(+1.0, falling) == pytest.approx(-falling * 9e-12 / (2.0 * 1.83e-5), rel=1e-3)
    assert gap_flow(5e-17, 6e5, 1e5) > 0.0


@pytest.mark.parametrize(("upstream", "downstream"), [(7.01325e5, AMBIENT), (5e5, 4e5)])
def test_eq_15_density_along_the_gap(upstream: float, downstream: float) -> None:
    """Printed: density of the far end all along, low by (P1+P2)/(2 P2), ≈ 4 at 0.6 MPa gauge.

    Used: the same mass passes every place. Of ten gaps in series, each a tenth as long, with
    P² falling evenly, every one passes the flow of the whole.
    """
    width, height, length = math.pi * 6e-3, 6e-6, 2e-3
    gas = PLANT.air.gas_constant * PLANT.air.temperature
    difference = upstream - downstream
    printed = width * height**3 * downstream * difference / (12.0 * 1.83e-5 * length * gas)
    used = gap_flow(gap_conductance(PLANT.air, width, height, length), upstream, downstream)
    assert used / printed == pytest.approx((upstream + downstream) / (2.0 * downstream), rel=1e-9)
    tenth = gap_conductance(PLANT.air, width, height, length / 10.0)
    places = np.sqrt(np.linspace(upstream**2, downstream**2, 11))
    pieces = [gap_flow(tenth, p, q) for p, q in itertools.pairwise(places)]
    assert pieces == pytest.approx([used] * 10, rel=1e-9)


def test_eq_15_factor_at_the_papers_largest_supply() -> None:
    """(P1 + P2)/(2 P2) with 0.701325 and 0.101325 MPa is 802650/202650 = 3.96: the "≈ 4×"."""
    used = gap_flow(1e-17, 701325.0, AMBIENT)
    printed = 2.0 * 1e-17 * AMBIENT * (701325.0 - AMBIENT)
    assert used / printed == pytest.approx(802650.0 / 202650.0, rel=1e-9)


def mid_position_leak(height: float) -> float:
    """Free air in L/min through the closed valve at 0.6 MPa gauge, two gaps in series twice."""
    conductance = gap_conductance(PLANT.air, math.pi * 6e-3, height, 2e-3)
    settled = math.sqrt((701325.0**2 + AMBIENT**2) / 2.0)
    return 2.0 * gap_flow(conductance, 701325.0, settled) * LITRES_PER_MINUTE


def test_eq_3_gap_height() -> None:
    """The printed 11.5 µm leaks over the maker's 7 L/min at mid-position; 6 µm stays below it."""
    assert mid_position_leak(11.5e-6) == pytest.approx(9.4, abs=0.2)
    assert mid_position_leak(PLANT.valve.gap_height) < 7.0
    at_supply = RigParameters({"supply.pressure": 701325.0})
    assert Rig(at_supply).free_air_flow * 60e3 == pytest.approx(
        mid_position_leak(PLANT.valve.gap_height), rel=0.03
    )


def test_joining_the_equations_at_the_closed_voltage() -> None:
    """Printed: the force on a held piston leaps from +138 N to -138 N across 5.08 V.

    It is still backward, -37 N, at 5.5 V. Used: it passes smoothly through zero and rises.
    """
    printed, used = assembled("printed"), assembled("reconciled")
    assert blocked_force(printed, 5.08 - 1e-6) == pytest.approx(138.0, abs=1.0)
    assert blocked_force(printed, 5.08) == pytest.approx(-138.0, abs=1.0)
    assert blocked_force(printed, 5.5) == pytest.approx(-37.0, abs=1.0)
    assert blocked_force(used, 5.08) == pytest.approx(0.0, abs=1e-6)
    assert abs(blocked_force(used, 5.08 - 1e-6)) < 1e-3
    assert blocked_force(used, 5.5) > 100.0


def test_eq_24_offset() -> None:
    """Printed: the spool is centred at -0.5 V, out of the command range. Used: at 5.05 V."""
    printed_centre = -0.000108499 / 0.00021485
    assert printed_centre == pytest.approx(-0.505, abs=1e-3)
    assert spool_displacement(5.05) == pytest.approx(0.0, abs=1e-8)
    assert spool_displacement(10.0) == pytest.approx(-spool_displacement(0.0), rel=0.02)


def printed_coefficient(argument: float) -> float:
    """C_v of eq. (25), branches as printed."""
    even = 1.132 - 0.0339 * argument**2 - 0.006486 * argument**4
    odd = -0.006917 * argument + 0.02509 * argument**3 + 0.0004983 * argument**5
    return even + odd if argument <= 0.0 else even - odd


def rated_flow(area: float) -> float:
    """Free air in L/min from 6 to 5 bar gauge."""
    return orifice_flow(PLANT.air, area, 701325.0, 601325.0) * LITRES_PER_MINUTE


def test_eq_25_argument_in_metres() -> None:
    """In metres, as printed, C_v never leaves 1.132 and the valve passes 133 L/min, not 100.

    The text says that it falls with opening; in volts it falls to 0.89 and 105 L/min.
    """
    travel = np.linspace(-1.085e-3, 1.0635e-3, 101)
    assert np.ptp([printed_coefficient(x) for x in travel]) < 1e-4
    area = effective_area(PLANT.valve, PLANT.valve.curve_centre + 4.92)
    assert rated_flow(1.132 * area) > 110.0
    assert rated_flow(flow_coefficient(PLANT.valve, 4.92) * area) == pytest.approx(100.0, abs=10.0)


def test_eq_25_branches() -> None:
    """In volts with the branches as printed C_v turns negative before 4 V on either side."""
    assert printed_coefficient(4.0) < 0.0
    assert printed_coefficient(-4.0) < 0.0
    for deflection in (4.0, -4.0):
        assert 0.8 < flow_coefficient(PLANT.valve, deflection) < 1.132


def test_eq_26_has_no_temperature_of_its_own() -> None:
    """As printed, outflow at T_s: a venting chamber reaches zero pressure with air still in it.

    Letting out 1/κ = 71 % of its air takes all of its pressure. What the form does keep is the
    energy of filling: inflow at T_s brings c_p T_s per kilogram, exactly.
    """
    volume, pressure, gas = 50e-6, 4e5, 287.05 * 297.0
    air_in_it = pressure * volume / gas
    per_kilogram = pressure_rate(PLANT.air, volume, 0.0, pressure, 1.0)
    assert pressure - per_kilogram * air_in_it / 1.4 == pytest.approx(0.0, abs=1e-6)
    stored = volume * per_kilogram / (1.4 - 1.0)
    assert stored == pytest.approx(1.4 / 0.4 * 287.05 * 297.0, rel=1e-12)


def test_eq_28_has_no_way_to_stop() -> None:
    """Printed: for |v| ≤ α and |F_e| < F_s friction equals F_e, so that nothing slows the carriage.

    It coasts on at up to α for ever. Used: within the band it stops, and α may not come near v_s.
    """
    speed, pushed = 5e-6, 10.0
    printed_friction = min(max(pushed, -29.0), 29.0)
    after_a_minute = speed + 60.0 * (pushed - printed_friction) / PLANT.cylinder.moving_mass
    assert after_a_minute == speed
    even = settled_pressures(PLANT, 5.08)
    stopped = advance(PLANT, openings(PLANT, 5.08), Motion(0.1, speed, *even), 1.0, 1.0)[0]
    assert stopped.velocity == 0.0
    assert stopped.position - 0.1 < 0.01 * speed
    with pytest.raises(ParameterError, match=r"friction\.capture_velocity"):
        RigParameters({"friction.capture_velocity": 1e-3})


def test_table_2_signs_of_reverse_friction() -> None:
    """Eq. (29) with sgn(v) and Table 2's negative F_s and F_c drives the reverse motion.

    Its power F·v is then negative, energy given to the carriage; with magnitudes it is taken.
    """
    velocity = -1e-3
    drop = (-36.0 + 12.5) * math.exp(-((velocity / -3.6e-3) ** 2))
    printed = 4800.0 * velocity - (-12.5 + drop)
    assert printed * velocity < 0.0
    assert sliding_friction(PLANT.friction, velocity, -1) * velocity > 0.0


def test_eq_31_is_a_force_balance() -> None:
    """Used: m dv/dt = A (P_a - P_b) - F_f. The printed ½ m v² gives a carriage at rest no push.

    ½ m v² is an energy: at v = 0 it vanishes whatever the force, and it ignores the direction.
    """
    state = Motion(0.1, 0.02, 4.5e5, 1.5e5)
    edges = openings(PLANT, 5.08)
    acceleration = rates(PLANT, edges, state, 1).velocity
    # 490.8739 mm² * 0.3 MPa = 147.262 N; F_f = 12 + 4500*0.02 = 102 N; 45.262 N on 1 kg
    assert acceleration == pytest.approx(45.262, abs=1e-3)
    heavy = Plant.of(PARAMETERS.with_values({"cylinder.moving_mass": 4.0}))
    assert rates(heavy, edges, state, 1).velocity == pytest.approx(45.262 / 4.0, abs=1e-3)


def test_eq_31_piston_area() -> None:
    """0.00491 m² makes 2.5 kN at 0.5 MPa, seven times what the 363 N magnets carry over.

    π/4 · (25 mm)² is a tenth of it and keeps the coupling whole at every supply of the paper.
    """
    assert 0.00491 * 0.5e6 > 6.0 * 363.0
    assert PLANT.cylinder.piston_area == pytest.approx(0.000490874, rel=1e-6)
    assert PLANT.cylinder.piston_area * 0.6e6 < 363.0
