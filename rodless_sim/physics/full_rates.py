# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The equations for :class:`FullMotion`: chambers, carriage and, where it is another mass, piston.

Where no magnets join them, piston and carriage are one body, the carriage, with all the mass and
all the friction; the piston's states follow it.
"""

from typing import Any, NamedTuple

from rodless_base.kernels import kernel, kernel_by_type, version_for
from rodless_sim.physics import equations, faults
from rodless_sim.physics.bristles import contact
from rodless_sim.physics.coupling import pull
from rodless_sim.physics.cylinder import pressure_rate, volume_a, volume_b
from rodless_sim.physics.drift import drifted_friction
from rodless_sim.physics.faults import NO_TEMPERATURE, NOT_FINITE
from rodless_sim.physics.forces import FORCES, other_forces
from rodless_sim.physics.friction import Friction, sliding_friction
from rodless_sim.physics.heat import heated_rate
from rodless_sim.physics.heated import NetInflows, less_leaks
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, FullMotion, Motion
from rodless_sim.physics.streams import heated_supply_flow, stream_into_a, stream_into_b

RAIL = [force.__name__.rpartition(".")[2] for force in FORCES].index("rail")


class Modes(NamedTuple):
    """How each body moves: +1 or -1 is the direction in which it slides, 0 holds it.

    Friction with bristles knows no sliding: there it is 1 for a body that is not held.
    """

    carriage: int
    piston: int  # 0 where it is no body of its own


class Body(NamedTuple):
    """Piston or carriage, and its share of what both have in common."""

    position: float  # m
    velocity: float  # m/s
    bristle_deflection: float  # m
    mass: float  # kg
    share: float  # of friction.*
    friction: Friction
    push: float  # N, of all but friction


class BodyRates(NamedTuple):
    """The rates of change of a body."""

    velocity: float  # m/s
    acceleration: float  # m/s²
    bristle: float  # m/s


@kernel_by_type
def supply_at_valve(plant: Plant, state: AnyMotion) -> float:  # noqa: ARG001
    """Return the supply's pressure in Pa at the valve."""
    return plant.supply_pressure


@kernel
def full_supply_at_valve(plant: Plant, state: FullMotion) -> float:
    """:func:`supply_at_valve` of a full motion."""
    if plant.full.supply.sags:
        return state.supply_pressure
    return source_pressure(plant, state)


@kernel
def source_pressure(plant: Plant, state: FullMotion) -> float:
    """Return the pressure in Pa that the supply goes to when nothing is drawn."""
    supply = plant.full.supply
    if not supply.compressor:
        return plant.supply_pressure
    lost = supply.loss * (state.receiver_pressure - plant.ambient_pressure)
    # A ripple, which is in the plant's pressure, is that of the compressor, too.
    ripple = plant.supply_pressure - supply.set_pressure
    return float(state.receiver_pressure - lost + ripple)


@kernel_by_type
def as_supplied(plant: Plant, lands: Lands) -> Plant:  # noqa: ARG001
    """Return the plant with its supply at the instant of ``lands``."""
    return plant


@kernel_by_type
def drawn_flow(plant: Plant, lands: Lands, state: FullMotion) -> float:
    """Return what the valve draws from the supply, kg/s."""
    return heated_supply_flow(plant, supply_at_valve(plant, state), lands, state)


@kernel
def supply_rates(plant: Plant, lands: Lands, state: FullMotion) -> tuple[float, float]:
    """Return dP/dt (Pa/s) of the supply at the valve and of the compressor's receiver."""
    supply = plant.full.supply
    if not supply.acting:
        return 0.0, 0.0
    drawn = drawn_flow(plant, lands, state)
    at_valve = receiver = 0.0
    if supply.sags:
        below = source_pressure(plant, state) - supply.droop * drawn - state.supply_pressure
        at_valve = below / supply.time_constant
    if supply.compressor:
        delivered = supply.delivery if state.compressor > 0.5 else 0.0
        receiver = supply.receiver_stiffness * (delivered - drawn)
    return at_valve, receiver


@version_for(FullMotion, supply_at_valve)
def _supply_at_valve(plant: Plant, state: FullMotion) -> float:
    return full_supply_at_valve(plant, state)


@version_for(FullMotion, equations.inflows)
def _inflows(plant: Plant, lands: Lands, state: FullMotion) -> NetInflows:
    supply = supply_at_valve(plant, state)
    a = stream_into_a(plant, supply, lands, state.pressure_a, state.temperature_a)
    b = stream_into_b(plant, supply, lands, state.pressure_b, state.temperature_b)
    if plant.leak.open:
        return less_leaks(plant, state, NetInflows(a, b))
    return NetInflows(a, b)


@kernel
def friction_now(plant: Plant, state: FullMotion) -> Friction:
    """Return the friction that it has drifted to."""
    if plant.full.drift.acting:
        return drifted_friction(
            plant.friction, state.static_drift, state.coulomb_drift, state.viscous_drift
        )
    return plant.friction


@kernel
def bodies(plant: Plant, state: FullMotion) -> tuple[Body, Body]:
    """Return carriage and piston, and what pushes and rubs them."""
    coupling, mass = plant.full.coupling, plant.cylinder.moving_mass
    air = plant.cylinder.piston_area * (state.pressure_a - state.pressure_b)
    others = other_forces(plant.forces, state).force
    link, share, rubbed = air, 0.0, 0.0
    friction = friction_now(plant, state)
    if coupling.magnetic:
        share, rubbed, link = coupling.piston_mass, coupling.piston_friction, 0.0
        if state.coupled > 0.5:
            lag = state.piston_position - state.position
            link = pull(coupling, lag, state.piston_velocity - state.velocity)
    # Of the other forces, gravity pulls at each body.
    weight = share * plant.forces[RAIL].weight
    carriage = Body(
        state.position,
        state.velocity,
        state.bristle_deflection,
        (1.0 - share) * mass,
        1.0 - rubbed,
        friction,
        link + others + weight,
    )
    piston = Body(
        state.piston_position,
        state.piston_velocity,
        state.piston_bristle_deflection,
        share * mass,
        rubbed,
        friction,
        air - link - weight,
    )
    return carriage, piston


@kernel
def body_rates(plant: Plant, body: Body, mode: int) -> BodyRates:
    """Return the rates of a body that moves by ``mode``."""
    if mode == 0:
        return BodyRates(0.0, 0.0, 0.0)
    bristles = plant.full.bristles
    if bristles.acting:
        drag, rate = contact(bristles, body.friction, body.velocity, body.bristle_deflection)
    else:
        drag, rate = sliding_friction(body.friction, body.velocity, mode), 0.0
    return BodyRates(body.velocity, (body.push - body.share * drag) / body.mass, rate)


@kernel
def air_rates(
    plant: Plant,
    flows: Any,  # NetInflows
    state: FullMotion,
    position: float,
    velocity: float,
) -> tuple[float, float, float, float]:
    """Return dP/dt (Pa/s) of both chambers and dT/dt (K/s), the piston moving as told."""
    air, cylinder, heat = plant.air, plant.cylinder, plant.heat
    area = cylinder.piston_area
    first, second = volume_a(cylinder, position), volume_b(cylinder, position)
    one, other = state.pressure_a, state.pressure_b
    if plant.full.heated:
        a = heated_rate(air, heat, first, area, velocity, one, state.temperature_a, flows.a)
        b = heated_rate(air, heat, second, -area, velocity, other, state.temperature_b, flows.b)
        return a.pressure.rate, b.pressure.rate, a.temperature.rate, b.temperature.rate
    return (
        pressure_rate(air, first, area * velocity, one, flows.a.mass_flow),
        pressure_rate(air, second, -area * velocity, other, flows.b.mass_flow),
        0.0,
        0.0,
    )


@kernel
def full_rates(plant: Plant, lands: Lands, state: FullMotion, modes: Modes) -> FullMotion:
    """Time derivative of the state."""
    plant = as_supplied(plant, lands)
    flows = equations.inflows(plant, lands, state)
    body, other = bodies(plant, state)
    carriage, piston = body_rates(plant, body, modes.carriage), BodyRates(0.0, 0.0, 0.0)
    position, velocity = state.position, carriage.velocity
    if plant.full.coupling.magnetic:
        piston = body_rates(plant, other, modes.piston)
        position, velocity = state.piston_position, piston.velocity
    pressure_a, pressure_b, warmth_a, warmth_b = air_rates(plant, flows, state, position, velocity)
    supply, receiver = supply_rates(plant, lands, state)
    return FullMotion(
        position=carriage.velocity,
        velocity=carriage.acceleration,
        pressure_a=pressure_a,
        pressure_b=pressure_b,
        temperature_a=warmth_a,
        temperature_b=warmth_b,
        bristle_deflection=carriage.bristle,
        piston_position=piston.velocity,
        piston_velocity=piston.acceleration,
        piston_bristle_deflection=piston.bristle,
        coupled=0.0,
        supply_pressure=supply,
        receiver_pressure=receiver,
        compressor=0.0,
        friction_clock=0.0,
        friction_dice=0.0,
        static_drift=0.0,
        coulomb_drift=0.0,
        viscous_drift=0.0,
    )


@version_for(FullMotion, faults.fault_of)
def _fault_of(plant: Plant, state: FullMotion) -> int:
    total = 0.0
    for value in state:
        total += 0.0 * value
    if total != 0.0:
        return NOT_FINITE
    if state.temperature_a <= 0.0 or state.temperature_b <= 0.0:
        return NO_TEMPERATURE
    # The piston is where the volumes end.
    others = Motion(state.piston_position, state.velocity, state.pressure_a, state.pressure_b)
    return faults.fault_of(plant, others)
