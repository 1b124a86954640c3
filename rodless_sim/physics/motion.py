"""The carriage and its chambers in time: :func:`advance`, with true stick and slip."""

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.equations import (
    Rates,
    breakaway_limits,
    chamber_flows,
    net_force,
    pressure_rates,
    sliding_direction,
    sliding_rates,
)
from rodless_sim.physics.events import breakaway, gap_ahead, sliding_event, stops_within
from rodless_sim.physics.faults import TOO_MANY_STEPS, fault_of
from rodless_sim.physics.friction import side_of, sliding
from rodless_sim.physics.integrator import next_step, sliding_step, sticking_step
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion, stopped

# What happens within a longer step might leave no trace at its end.
LONGEST_STEP = 1e-3  # s

# About one step is taken in a millisecond. So many in one call, and so many for each second of it,
# mean that the rig cannot be followed.
MOST_STEPS = 100_000
MOST_STEPS_PER_SECOND = 1e6

# Where friction falls with speed, the motion runs away from itself, and that is what makes
# stick-slip. An L-stable method would damp it: there a step is at most this share of the time
# constant.
UNSTABLE_SHARE = 0.25
# The fall ends at about this many Stribeck velocities; a step changes the speed there by at most
# this share of one, or it would jump the curve without having seen it.
FALL = 2.5
FALL_SHARE = 0.5


@kernel
def may_fall(speed: float, stribeck_velocity: float) -> bool:
    """Whether friction may fall with speed at ``speed`` (m/s)."""
    return abs(speed) < 3.0 * stribeck_velocity


@kernel
def step_in_the_fall(
    speed: float, after: float, slope: float, stribeck_velocity: float, step: float
) -> float:
    """Return the step to try instead of one from ``speed`` to ``after`` (m/s), or ``step`` itself.

    ``slope`` is how the acceleration grows with the velocity at its end, 1/s.
    """
    if may_fall(after, stribeck_velocity) and slope * step > UNSTABLE_SHARE:
        return 0.8 * UNSTABLE_SHARE / slope
    change = abs(after - speed)
    edge = FALL * stribeck_velocity
    if change > FALL_SHARE * stribeck_velocity and min(speed, after) < edge:
        # First to the edge of the fall, then along it.
        ahead = speed - 0.96 * edge if speed > edge else 0.0
        return step * min(0.9, max(ahead, 0.8 * FALL_SHARE * stribeck_velocity) / change)
    return step


@kernel
def sliding_attempt(
    plant: Plant, lands: Lands, state: Motion, direction: int, step: float, tolerance: float
) -> tuple[Motion, int, float, float]:
    """Try a step of a sliding carriage.

    Returns the state and direction after it, the time it took, 0 where it must be shorter, and the
    step to try next.
    """
    first = sliding_rates(plant, lands, state, direction)
    stribeck_velocity = side_of(plant.friction, direction).stribeck_velocity
    if first.by_velocity * step > UNSTABLE_SHARE and may_fall(state.velocity, stribeck_velocity):
        step = UNSTABLE_SHARE / first.by_velocity
    after, error = sliding_step(plant, lands, state, direction, first, step)
    error /= tolerance
    if not error <= 1.0:
        return state, direction, 0.0, next_step(step, error)
    drag = sliding(plant.friction, after.velocity, direction)
    mass = plant.cylinder.moving_mass
    speed, speed_after = direction * state.velocity, direction * after.velocity
    shorter = step_in_the_fall(
        speed, speed_after, -drag.by_speed / mass, stribeck_velocity, step
    )
    if shorter < step:
        return state, direction, 0.0, shorter
    acceleration = (net_force(plant, after) - drag.force) / mass
    stops = stops_within(
        speed, direction * first.acceleration, speed_after, direction * acceleration, step
    )
    if stops or gap_ahead(plant, after, direction) <= 0.0:
        event = sliding_event(plant, lands, state, direction, first, step, after, stops)
        return event.state, event.direction, event.elapsed, LONGEST_STEP
    return after, direction, step, next_step(step, error)


@kernel
def sticking_attempt(
    plant: Plant, lands: Lands, state: Motion, step: float, tolerance: float
) -> tuple[Motion, int, float, float]:
    """:func:`sliding_attempt` for a carriage at rest."""
    a, b = pressure_rates(plant, lands, state, 0.0)
    after, error = sticking_step(plant, lands, state, a, b, step)
    error /= tolerance
    if not error <= 1.0:
        return state, 0, 0.0, next_step(step, error)
    low, high = breakaway_limits(plant, state.position)
    if low <= net_force(plant, after) <= high:
        return after, 0, step, next_step(step, error)
    event = breakaway(plant, lands, state, a, b, step, after)
    return event.state, event.direction, event.elapsed, LONGEST_STEP


@kernel
def advance(
    plant: Plant, lands: Lands, state: Motion, period: float, tolerance: float
) -> tuple[Motion, int]:
    """Keep the valve at its openings ``lands`` for ``period`` s.

    The integrator chooses its steps anew in every call, for an error of ``tolerance``
    (``time.tolerance``). Returns the state and a code of :mod:`rodless_sim.physics.faults`: 0
    where it is sound.
    """
    left = step = period
    direction = sliding_direction(plant, state)
    for _ in range(MOST_STEPS + int(MOST_STEPS_PER_SECOND * period)):
        if left <= 0.0:
            return state, fault_of(plant, state)
        step = min(step, LONGEST_STEP)
        if step >= left:
            step = left
        elif step > 0.5 * left:
            step = 0.5 * left
        if direction == 0:
            state, direction, elapsed, step = sticking_attempt(
                plant, lands, stopped(state), step, tolerance
            )
        else:
            state, direction, elapsed, step = sliding_attempt(
                plant, lands, state, direction, step, tolerance
            )
        left -= elapsed
    return state, TOO_MANY_STEPS


@outlined_kernel
def advance_at_voltage(
    plant: Plant, voltage: float, state: Motion, period: float, tolerance: float
) -> tuple[Motion, float, float, int]:
    """:func:`advance` at ``voltage`` (V), with the :func:`chamber_flows` at the end."""
    lands = openings(plant, voltage)
    fault = 0
    if period > 0.0:
        state, fault = advance(plant, lands, state, period, tolerance)
    flow_a, flow_b = chamber_flows(plant, lands, state)
    return state, flow_a, flow_b, fault
