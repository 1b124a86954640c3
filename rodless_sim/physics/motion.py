"""The carriage and its chambers in time: eqs. (26), (27), (31) with true stick and slip."""

from rodless_base.kernels import kernel
from rodless_sim.physics.cylinder import pressure_rate, volume_a, volume_b
from rodless_sim.physics.forces import other_forces
from rodless_sim.physics.friction import sliding_friction, static_limit
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import flow_into_a, flow_into_b, openings
from rodless_sim.physics.state import Motion, moved, stopped

# Stick and slip change the equations inside a step; the step is cut there. More than this many
# changes within one step (20 µs) do not happen on the rig; if they did, the last cut stands.
MAXIMUM_CUTS = 8


@kernel
def net_force(plant: Plant, state: Motion) -> float:
    """Applied force without friction in N, the F_e of eq. (28)."""
    difference = state.pressure_a - state.pressure_b
    return plant.cylinder.piston_area * difference + other_forces(plant.forces, state)


@kernel
def sliding_direction(plant: Plant, state: Motion) -> int:
    """Return +1 or -1 for a sliding carriage, 0 for one that sticks, eq. (28)."""
    if plant.cylinder.locked:
        return 0
    force = net_force(plant, state)
    limit = static_limit(plant.friction, force)
    if abs(state.velocity) <= plant.friction.capture_velocity and abs(force) <= limit:
        return 0
    if state.velocity == 0.0:
        return 1 if force > 0.0 else -1
    return 1 if state.velocity > 0.0 else -1


@kernel
def rates(plant: Plant, lands: Lands, state: Motion, direction: int) -> Motion:
    """Time derivative of the state: eqs. (26), (31); ``direction`` 0 holds the carriage."""
    cylinder, air = plant.cylinder, plant.air
    velocity = state.velocity if direction != 0 else 0.0
    acceleration = 0.0
    if direction != 0:
        friction = sliding_friction(plant.friction, velocity, direction)
        acceleration = (net_force(plant, state) - friction) / cylinder.moving_mass
    flow_a = flow_into_a(plant, lands, state.pressure_a)
    flow_b = flow_into_b(plant, lands, state.pressure_b)
    rate_a = cylinder.piston_area * velocity
    return Motion(
        velocity,
        acceleration,
        pressure_rate(air, volume_a(cylinder, state.position), rate_a, state.pressure_a, flow_a),
        pressure_rate(air, volume_b(cylinder, state.position), -rate_a, state.pressure_b, flow_b),
    )


@kernel
def midpoint(plant: Plant, lands: Lands, state: Motion, direction: int, step: float) -> Motion:
    """One explicit midpoint step (second order) in one mode of friction."""
    halfway = moved(state, rates(plant, lands, state, direction), 0.5 * step)
    return moved(state, rates(plant, lands, halfway, direction), step)


@kernel
def fraction_to_event(plant: Plant, before: Motion, after: Motion, direction: int) -> float:
    """Share of a step after which the carriage stops or breaks away; 1 or more: it does not."""
    if direction != 0:
        if after.velocity * direction > 0.0:
            return 1.0
        return before.velocity / (before.velocity - after.velocity)
    if plant.cylinder.locked:
        return 1.0
    force_after = net_force(plant, after)
    limit = static_limit(plant.friction, force_after)
    if abs(force_after) <= limit:
        return 1.0
    sign = 1.0 if force_after > 0.0 else -1.0
    force_before = net_force(plant, before)
    return (limit - sign * force_before) / (sign * (force_after - force_before))


@kernel
def inner_step(plant: Plant, lands: Lands, state: Motion, step: float) -> Motion:
    """Advance by ``step`` seconds, cutting the step where the carriage sticks or slips."""
    remaining = step
    direction = sliding_direction(plant, state)
    for _ in range(MAXIMUM_CUTS):
        if direction == 0:
            state = stopped(state)
        after = midpoint(plant, lands, state, direction, remaining)
        fraction = fraction_to_event(plant, state, after, direction)
        if fraction >= 1.0:
            return after
        if fraction > 0.0:
            state = midpoint(plant, lands, state, direction, fraction * remaining)
            remaining *= 1.0 - fraction
        state = stopped(state)
        # A push within rounding of F_s must not be judged anew: it has just been found to grow
        # past the limit, or to fall back before it moves the carriage.
        if direction == 0:
            direction = 1 if net_force(plant, after) > 0.0 else -1
        elif fraction > 0.0:
            direction = sliding_direction(plant, state)
        else:
            direction = 0
    return state


@kernel
def advance(plant: Plant, lands: Lands, state: Motion, steps: int, step: float) -> Motion:
    """Keep the valve at its openings ``lands`` for ``steps`` inner steps of ``step`` seconds."""
    for _ in range(steps):
        state = inner_step(plant, lands, state, step)
    return state


@kernel
def chamber_flows(plant: Plant, lands: Lands, state: Motion) -> tuple[float, float]:
    """Mass flows into chambers A and B in kg/s."""
    return (
        flow_into_a(plant, lands, state.pressure_a),
        flow_into_b(plant, lands, state.pressure_b),
    )


@kernel
def advance_at_voltage(
    plant: Plant, voltage: float, state: Motion, steps: int, step: float
) -> tuple[Motion, float, float]:
    """:func:`advance` at ``voltage`` (V), with the :func:`chamber_flows` at the end."""
    lands = openings(plant, voltage)
    state = advance(plant, lands, state, steps, step)
    flow_a, flow_b = chamber_flows(plant, lands, state)
    return state, flow_a, flow_b
