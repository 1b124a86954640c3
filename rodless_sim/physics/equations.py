# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The equations of motion of carriage and chambers: eqs. (26), (27), (28), (31)."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel
from rodless_sim.physics.cylinder import PressureRate, chamber_rate, volume_a, volume_b
from rodless_sim.physics.force import Force
from rodless_sim.physics.forces import other_forces
from rodless_sim.physics.friction import sliding
from rodless_sim.physics.lands import AnyCourse, Lands
from rodless_sim.physics.leak import Leaking, leaking
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import Inflow, inflow_a, inflow_b
from rodless_sim.physics.state import AnyMotion, Motion


class Rates(NamedTuple):
    """Rates of change of a sliding rig, and all that they change with.

    The acceleration changes with both pressures, with opposite signs; each pressure changes with
    itself and the carriage, and with the other where air leaks past the piston.
    """

    velocity: float  # m/s
    acceleration: float  # m/s²
    by_position: float  # of the acceleration, 1/s²
    by_velocity: float  # of the acceleration, 1/s
    by_pressure: float  # of the acceleration, m/(s²·Pa): by that of A, less by that of B
    a: PressureRate
    b: PressureRate


class Inflows(NamedTuple):
    """What flows into each chamber."""

    a: Inflow
    b: Inflow


@kernel
def applied(plant: Plant, state: AnyMotion) -> Force:
    """Applied force without friction, the F_e of eq. (28)."""
    push = plant.cylinder.piston_area * (state.pressure_a - state.pressure_b)
    others = other_forces(plant.forces, state)
    return Force(push + others.force, others.by_position, others.by_velocity)


@kernel
def net_force(plant: Plant, state: AnyMotion) -> float:
    """Applied force without friction in N, the F_e of eq. (28)."""
    return applied(plant, state).force


@kernel
def breakaway_limits(plant: Plant, position: float) -> tuple[float, float]:
    """Return the least and the greatest net force in N that a carriage at rest withstands.

    An end cap withstands any push into it.
    """
    low, high = -plant.friction.reverse.static, plant.friction.forward.static
    if plant.cylinder.locked or position <= 0.0:
        low = -math.inf
    if plant.cylinder.locked or position >= plant.cylinder.stroke:
        high = math.inf
    return low, high


@kernel
def sliding_direction(plant: Plant, state: AnyMotion) -> int:
    """Return +1 or -1 for a sliding carriage, 0 for one that sticks, eq. (28)."""
    speed = abs(state.velocity)
    if not plant.cylinder.locked and speed > plant.friction.capture_velocity:
        return 1 if state.velocity > 0.0 else -1
    force = net_force(plant, state)
    low, high = breakaway_limits(plant, state.position)
    if low <= force <= high:
        return 0
    if speed > 0.0:
        return 1 if state.velocity > 0.0 else -1
    return 1 if force > high else -1


@kernel_by_type
def inflows(plant: Plant, lands: Lands, state: Motion) -> Inflows:
    """Return what flows into both chambers: through the valve, less what leaks out."""
    a = inflow_a(plant, lands, state.pressure_a)
    b = inflow_b(plant, lands, state.pressure_b)
    if plant.leak.open:
        return less_leaks(plant, state, Inflows(a, b))
    return Inflows(a, b)


@outlined_kernel
def less_leaks(plant: Plant, state: Motion, flows: Inflows) -> Inflows:
    """``flows`` into both chambers less what leaks out of them."""
    a, b = leaking(
        plant.leak, plant.air, plant.ambient_pressure, state.pressure_a, state.pressure_b
    )
    return Inflows(less(flows.a, a), less(flows.b, b))


@kernel
def less(flow: Inflow, out: Leaking) -> Inflow:
    """``flow`` into a chamber less what leaks out of it."""
    return Inflow(
        flow.mass_flow - out.mass_flow,
        flow.by_pressure - out.by_pressure,
        flow.by_other - out.by_other,
    )


@kernel_by_type
def pressure_rates(
    plant: Plant, state: Motion, flows: Inflows, velocity: float
) -> tuple[PressureRate, PressureRate]:
    """Eq. (26) for chambers A and B, the carriage moving at ``velocity`` (m/s)."""
    air, cylinder = plant.air, plant.cylinder
    area = cylinder.piston_area
    a, b = flows
    first = volume_a(cylinder, state.position)
    second = volume_b(cylinder, state.position)
    one, other = state.pressure_a, state.pressure_b
    return (
        chamber_rate(air, first, area, velocity, one, a.mass_flow, a.by_pressure, a.by_other),
        chamber_rate(air, second, -area, velocity, other, b.mass_flow, b.by_pressure, b.by_other),
    )


@kernel
def sliding_rates(plant: Plant, state: AnyMotion, flows: Inflows, direction: int) -> Rates:
    """Eqs. (26) and (31) for a carriage that slides in ``direction`` (+1 or -1)."""
    mass = plant.cylinder.moving_mass
    force = applied(plant, state)
    drag = sliding(plant.friction, state.velocity, direction)
    a, b = pressure_rates(plant, state, flows, state.velocity)
    return Rates(
        state.velocity,
        (force.force - drag.force) / mass,
        force.by_position / mass,
        (force.by_velocity - drag.by_speed) / mass,
        plant.cylinder.piston_area / mass,
        a,
        b,
    )


@kernel_by_type
def motion_rate(velocity: float, acceleration: float, a: PressureRate, b: PressureRate) -> Motion:
    """Return the rate of change of the state from those of carriage and chambers."""
    return Motion(velocity, acceleration, a.rate, b.rate)


@kernel
def rates(plant: Plant, lands: AnyCourse, state: AnyMotion, direction: int) -> AnyMotion:
    """Time derivative of the state: eqs. (26), (31); ``direction`` 0 holds the carriage."""
    flows = inflows(plant, lands, state)
    if direction == 0:
        a, b = pressure_rates(plant, state, flows, 0.0)
        return motion_rate(0.0, 0.0, a, b)
    found = sliding_rates(plant, state, flows, direction)
    return motion_rate(found.velocity, found.acceleration, found.a, found.b)
