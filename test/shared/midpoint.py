# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant by the explicit midpoint rule at steps so short that nothing else matters.

An integrator that shares none with the package's: fixed steps, no Jacobian, events by a straight
line within a step of a microsecond or less.
"""

import numba
import numpy as np
import numpy.typing as npt

from rodless_sim.physics.cylinder import pressure_rate, volume_a, volume_b
from rodless_sim.physics.equations import breakaway_limits, inflows, net_force
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

Array = npt.NDArray[np.float64]

compiled = numba.njit(error_model="numpy")


@compiled
def moved(state: Motion, rate: Motion, step: float) -> Motion:
    return Motion(
        state.position + step * rate.position,
        state.velocity + step * rate.velocity,
        state.pressure_a + step * rate.pressure_a,
        state.pressure_b + step * rate.pressure_b,
    )


@compiled
def rates(plant: Plant, lands: Lands, state: Motion, direction: int) -> Motion:
    cylinder, air = plant.cylinder, plant.air
    velocity, acceleration = 0.0, 0.0
    if direction != 0:
        velocity = state.velocity
        friction = sliding_friction(plant.friction, velocity, direction)
        acceleration = (net_force(plant, state) - friction) / cylinder.moving_mass
    to_a, to_b = inflows(plant, lands, state)
    first, second = volume_a(cylinder, state.position), volume_b(cylinder, state.position)
    grown = cylinder.piston_area * velocity
    return Motion(
        velocity,
        acceleration,
        pressure_rate(air, first, grown, state.pressure_a, to_a.mass_flow),
        pressure_rate(air, second, -grown, state.pressure_b, to_b.mass_flow),
    )


@compiled
def midpoint(plant: Plant, lands: Lands, state: Motion, direction: int, step: float) -> Motion:
    halfway = moved(state, rates(plant, lands, state, direction), 0.5 * step)
    return moved(state, rates(plant, lands, halfway, direction), step)


@compiled
def direction_at(plant: Plant, state: Motion) -> int:
    if state.velocity != 0.0:
        return 1 if state.velocity > 0.0 else -1
    force = net_force(plant, state)
    low, high = breakaway_limits(plant, state.position)
    return 1 if force > high else -1 if force < low else 0


@compiled
def short_step(plant: Plant, lands: Lands, state: Motion, step: float) -> Motion:
    """One step, cut where the carriage stops, breaks away or strikes a cap."""
    stroke = plant.cylinder.stroke
    direction = direction_at(plant, state)
    for _ in range(20):
        after = midpoint(plant, lands, state, direction, step)
        share = 2.0
        struck = False
        if direction == 0:
            low, high = breakaway_limits(plant, state.position)
            before, force = net_force(plant, state), net_force(plant, after)
            if force > high:
                share = (high - before) / (force - before)
            elif force < low:
                share = (low - before) / (force - before)
        else:
            if after.velocity * direction <= 0.0:
                share = state.velocity / (state.velocity - after.velocity)
            wall = stroke if direction > 0 else 0.0
            if (after.position - wall) * direction > 0.0:
                to_wall = (wall - state.position) / (after.position - state.position)
                struck = to_wall <= share
                share = min(share, to_wall)
        if share >= 1.0:
            return after
        if share > 0.0:
            state = midpoint(plant, lands, state, direction, share * step)
            step *= 1.0 - share
        if struck:
            rebound = -plant.end_stop.restitution * state.velocity
            wall = stroke if direction > 0 else 0.0
            state = Motion(
                wall, rebound if abs(rebound) > 3e-5 else 0.0, state.pressure_a, state.pressure_b
            )
            direction = direction_at(plant, state)
            continue
        state = Motion(state.position, 0.0, state.pressure_a, state.pressure_b)
        if direction == 0:
            direction = 1 if net_force(plant, after) > net_force(plant, state) else -1
        else:
            direction = direction_at(plant, state) if share > 0.0 else 0
    return state


@compiled
def by_midpoint(plant: Plant, voltages: Array, state: Motion, period: float, steps: int) -> Array:
    """Position, velocity and pressures, shape (n + 1, 4): ``steps`` in each of n periods."""
    rows = np.empty((voltages.size + 1, 4))
    for k in range(voltages.size):
        lands = openings(plant, voltages[k])
        for j in range(4):
            rows[k, j] = state[j]
        for _ in range(steps):
            state = short_step(plant, lands, state, period / steps)
    for j in range(4):
        rows[-1, j] = state[j]
    return rows
