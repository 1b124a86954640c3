# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The carriage held: pressures at which the valve's flows balance, and the force they make."""

import math

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.state import Motion

AMBIENT = 101325.0
SUPPLIES = (0.4e6 + AMBIENT, 0.5e6 + AMBIENT, 0.6e6 + AMBIENT)
AREA = math.pi / 4.0 * 0.025**2


def held(supply: float, **more: object) -> RigParameters:
    return RigParameters({"supply.pressure": supply, "cylinder.locked": True, **more})


def blocked_force(parameters: RigParameters, voltage: float) -> float:
    """A·(P_a - P_b) in N once the chambers of a held carriage have settled."""
    pressure_a, pressure_b = settled_pressures(Plant.of(parameters), voltage)
    return AREA * (pressure_a - pressure_b)


@pytest.mark.parametrize("supply", SUPPLIES)
def test_chambers_start_at_the_root_mean_square_of_supply_and_ambient(supply: float) -> None:
    """Two equal gaps in series pass k(P_s² - P²) = k(P² - P_e²): P = √((P_s² + P_e²)/2)."""
    state = Rig(held(supply)).state
    expected = math.sqrt((supply**2 + AMBIENT**2) / 2.0)
    assert state.pressure_a == pytest.approx(expected, rel=1e-9)
    assert state.pressure_b == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("supply", SUPPLIES)
@pytest.mark.parametrize("pressures", [(1.0, 0.0), (0.0, 1.0), (0.1, 0.2), (0.9, 0.9)])
def test_closed_valve_brings_any_start_to_that_pressure(
    supply: float, pressures: tuple[float, float]
) -> None:
    """From full, empty or uneven chambers, ten minutes at 5.08 V end within 1 Pa of it."""
    # The slower chamber (64 cm³ at mid-stroke) closes in at about 0.17/s.
    start = [AMBIENT + share * (supply - AMBIENT) for share in pressures]
    plant = Plant.of(held(supply))
    end = advance(plant, openings(plant, 5.08), Motion(0.1, 0.0, *start), 600.0, 1.0)[0]
    expected = math.sqrt((supply**2 + AMBIENT**2) / 2.0)
    assert end.pressure_a == pytest.approx(expected, abs=1.0)
    assert end.pressure_b == pytest.approx(expected, abs=1.0)


@pytest.mark.parametrize("voltage", [4.4, 5.0, 5.24, 6.0])
def test_settled_pressures_are_where_a_long_run_ends(voltage: float) -> None:
    """The root the rig starts from is the state that minutes of simulated time lead to."""
    parameters = held(SUPPLIES[1])
    plant = Plant.of(parameters)
    end = advance(plant, openings(plant, voltage), Motion(0.1, 0.0, 3e5, 3e5), 600.0, 1.0)[0]
    pressure_a, pressure_b = settled_pressures(plant, voltage)
    assert end.pressure_a == pytest.approx(pressure_a, abs=1.0)
    assert end.pressure_b == pytest.approx(pressure_b, abs=1.0)


def test_a_locked_carriage_stays_whatever_pushes_it() -> None:
    """``cylinder.locked`` holds the carriage against the full force of the supply."""
    voltages = np.repeat([10.0, 0.0], 500)
    trace = simulate(held(SUPPLIES[2]), voltages, 1e-3, 0.07)
    assert np.abs(trace.force).max() > 200.0
    assert np.all(trace.position == 0.07)
    assert np.all(trace.velocity == 0.0)


@pytest.mark.parametrize("supply", SUPPLIES)
def test_blocked_force_rises_with_voltage_through_zero_at_closed(supply: float) -> None:
    """From 4 V to 6 V the force on a held piston only ever rises, and is zero at 5.08 V."""
    parameters = held(supply)
    voltages = np.linspace(4.08, 6.08, 401)
    forces = np.array([blocked_force(parameters, u) for u in voltages])
    assert np.all(np.diff(forces) > 0.0)
    assert blocked_force(parameters, 5.08) == pytest.approx(0.0, abs=1e-6)
    assert forces[0] < -0.9 * AREA * (supply - AMBIENT)
    assert forces[-1] > 0.9 * AREA * (supply - AMBIENT)


@pytest.mark.parametrize("supply", SUPPLIES)
def test_blocked_force_has_no_jump_at_closed(supply: float) -> None:
    """A tenth of a millivolt across 5.08 V changes the force by less than a tenth of a newton."""
    parameters = held(supply)
    rise = blocked_force(parameters, 5.08005) - blocked_force(parameters, 5.07995)
    assert 0.0 < rise < 0.1
