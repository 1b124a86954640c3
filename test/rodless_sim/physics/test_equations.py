# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The equations of motion by hand, and whether a carriage sticks or slides, and which way."""

import math

import pytest
from chamber_flows import flow_into_a, flow_into_b

from rodless_sim import RigParameters
from rodless_sim.physics.equations import (
    breakaway_limits,
    inflows,
    net_force,
    rates,
    sliding_direction,
    sliding_rates,
)
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

HEAVY = Plant.of(RigParameters({"cylinder.moving_mass": 4.0}))
OPEN = openings(HEAVY, 7.0)
AREA, DEAD_VOLUME = math.pi / 4.0 * 0.025**2, 15e-6
HEAT = 1.4 * 287.05 * 297.0  # κ R T_s, J/kg


def test_a_heavy_carriage_by_hand() -> None:
    """Eq. (31) with 4 kg: (A (P_a - P_b) - F_c - B v)/m, the Stribeck drop long spent at 0.1 m/s.

    490.874 mm² · 100 kPa = 49.0874 N; 12 N and 4500 · 0.1 = 450 N against it: -103.228 m/s².
    """
    state = Motion(0.05, 0.1, 4e5, 3e5)
    found = sliding_rates(HEAVY, state, inflows(HEAVY, OPEN, state), 1)
    assert found.velocity == 0.1
    assert found.acceleration == pytest.approx((49.08738521 - 462.0) / 4.0, rel=1e-9)
    assert found.by_velocity == pytest.approx(-4500.0 / 4.0, rel=1e-9)
    assert found.by_pressure == pytest.approx(AREA / 4.0, rel=1e-12)
    assert found.by_position == 0.0


@pytest.mark.parametrize("velocity", [0.0, 0.1])
def test_a_held_carriage_does_not_press_its_air(velocity: float) -> None:
    """Eq. (26) with dV/dt = 0: κ R T ṁ/V in both chambers, whatever velocity the state has."""
    state = Motion(0.05, velocity, 4e5, 3e5)
    found = rates(HEAVY, OPEN, state, 0)
    volume_a, volume_b = DEAD_VOLUME + AREA * 0.05, DEAD_VOLUME + AREA * 0.15
    assert (found.position, found.velocity) == (0.0, 0.0)
    into_a, into_b = flow_into_a(HEAVY, OPEN, 4e5), flow_into_b(HEAVY, OPEN, 3e5)
    assert into_a > 0.0 > into_b
    assert found.pressure_a == pytest.approx(HEAT * into_a / volume_a, rel=1e-12)
    assert found.pressure_b == pytest.approx(HEAT * into_b / volume_b, rel=1e-12)


def test_a_moving_carriage_presses_its_air() -> None:
    """Eq. (26) at 0.1 m/s: chamber A grows by A v, B shrinks by as much."""
    state = Motion(0.05, 0.1, 4e5, 3e5)
    held, found = rates(HEAVY, OPEN, state, 0), rates(HEAVY, OPEN, state, 1)
    volume_a, volume_b = DEAD_VOLUME + AREA * 0.05, DEAD_VOLUME + AREA * 0.15
    assert found.position == 0.1
    assert found.pressure_a - held.pressure_a == pytest.approx(
        -1.4 * 4e5 * AREA * 0.1 / volume_a, rel=1e-9
    )
    assert found.pressure_b - held.pressure_b == pytest.approx(
        1.4 * 3e5 * AREA * 0.1 / volume_b, rel=1e-9
    )


def pushed(force: float, position: float = 0.1, velocity: float = 0.0) -> Motion:
    """Return a carriage that its air pushes with ``force`` N."""
    return Motion(position, velocity, 3e5 + force / AREA, 3e5)


@pytest.mark.parametrize(
    ("force", "position", "velocity", "direction"),
    [
        # At rest: within F_s of 29 N forward and 36 N in reverse it sticks, beyond it slides.
        (28.9, 0.1, 0.0, 0),
        (29.1, 0.1, 0.0, 1),
        (-35.9, 0.1, 0.0, 0),
        (-36.1, 0.1, 0.0, -1),
        # A cap holds any push into it, but none away from it.
        (-500.0, 0.0, 0.0, 0),
        (29.1, 0.0, 0.0, 1),
        (500.0, 0.2, 0.0, 0),
        (-36.1, 0.2, 0.0, -1),
        # Faster than 10 µm/s it slides whichever way it is pushed.
        (-100.0, 0.1, 1.1e-5, 1),
        (100.0, 0.1, -1.1e-5, -1),
        (0.0, 0.1, 1.1e-5, 1),
        # Slower, a push within F_s holds it; beyond, it goes on first.
        (0.0, 0.1, 0.9e-5, 0),
        (0.0, 0.1, -0.9e-5, 0),
        (-50.0, 0.1, 0.9e-5, 1),
        (50.0, 0.1, -0.9e-5, -1),
    ],
)
def test_a_carriage_sticks_or_slides(
    force: float, position: float, velocity: float, direction: int
) -> None:
    """Eq. (28), by the values of Table 2; locked, it sticks whatever happens."""
    state = pushed(force, position, velocity)
    assert net_force(HEAVY, state) == pytest.approx(force, abs=1e-9)
    assert sliding_direction(HEAVY, state) == direction
    locked = HEAVY._replace(cylinder=HEAVY.cylinder._replace(locked=True))
    assert sliding_direction(locked, state) == 0
    assert breakaway_limits(locked, position) == (-math.inf, math.inf)
