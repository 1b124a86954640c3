# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The carriage and its chambers in time: :func:`advance`, with true stick and slip."""

from typing import NamedTuple

from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel, version_for
from rodless_sim.physics import heated, timed  # noqa: F401  versions of what is used here
from rodless_sim.physics.course import course_after, course_at, spool_of, step_on
from rodless_sim.physics.equations import (
    Inflows,
    breakaway_limits,
    inflows,
    net_force,
    pressure_rates,
    sliding_direction,
    sliding_rates,
)
from rodless_sim.physics.events import breakaway, gap_ahead, sliding_event, stops_within
from rodless_sim.physics.faults import TOO_MANY_STEPS, fault_of
from rodless_sim.physics.friction import side_of, sliding
from rodless_sim.physics.full_motion import advance_full
from rodless_sim.physics.integrator import next_step, sliding_step, sticking_step
from rodless_sim.physics.lands import AnyCourse
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import AnySpool
from rodless_sim.physics.state import AnyMotion, FullMotion, stopped
from rodless_sim.physics.step_control import (
    FALL_ACCURACY,
    LONGEST_STEP,
    MOST_STEPS,
    MOST_STEPS_PER_SECOND,
    UNSTABLE_SHARE,
    may_fall,
    step_in_the_fall,
    step_within,
)


class Attempt(NamedTuple):
    """Where a step has led."""

    state: AnyMotion
    direction: int  # of sliding from then on, 0 for a carriage at rest
    elapsed: float  # s, 0 where the step was too long and has not been taken
    step: float  # s, to try next


@kernel
def cruises(speed: float, rate: float, after: float, stribeck_velocity: float, step: float) -> bool:
    """Whether a step from ``speed`` to ``after`` (m/s) is far from standstill all along.

    ``rate`` is that of the speed at its start, m/s².
    """
    slowest = min(speed, after)
    return slowest > 3.0 * stribeck_velocity and abs(rate * step) < slowest


@kernel
def sliding_attempt(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    flows: Inflows,
    direction: int,
    step: float,
    tolerance: float,
) -> Attempt:
    """Try a step of a sliding carriage, which ``flows`` enter at its start."""
    first = sliding_rates(plant, state, flows, direction)
    stribeck_velocity = side_of(plant.friction, direction).stribeck_velocity
    if first.by_velocity * step > UNSTABLE_SHARE and may_fall(state.velocity, stribeck_velocity):
        step = UNSTABLE_SHARE / first.by_velocity
    after, error = sliding_step(plant, course, state, direction, first, step)
    error /= tolerance
    speed, speed_after = direction * state.velocity, direction * after.velocity
    if may_fall(min(speed, speed_after), stribeck_velocity):
        error *= FALL_ACCURACY
    if not error <= 1.0:
        return Attempt(state, direction, 0.0, next_step(step, error))
    rate = direction * first.acceleration
    stops = False
    if not cruises(speed, rate, speed_after, stribeck_velocity, step):
        drag = sliding(plant.friction, after.velocity, direction)
        mass = plant.cylinder.moving_mass
        slope = -drag.by_speed / mass
        shorter = step_in_the_fall(speed, speed_after, slope, stribeck_velocity, step)
        if shorter < step:
            return Attempt(state, direction, 0.0, shorter)
        rate_after = direction * (net_force(plant, after) - drag.force) / mass
        stops = stops_within(speed, rate, speed_after, rate_after, step)
    if stops or gap_ahead(plant, after, direction) <= 0.0:
        event = sliding_event(plant, course, state, direction, first, step, after, stops)
        return Attempt(event.state, event.direction, event.elapsed, LONGEST_STEP)
    return Attempt(after, direction, step, next_step(step, error))


@kernel
def sticking_attempt(
    plant: Plant, course: AnyCourse, state: AnyMotion, flows: Inflows, step: float, tolerance: float
) -> Attempt:
    """:func:`sliding_attempt` for a carriage at rest."""
    a, b = pressure_rates(plant, state, flows, 0.0)
    after, error = sticking_step(plant, course, state, a, b, step)
    error /= tolerance
    if not error <= 1.0:
        return Attempt(state, 0, 0.0, next_step(step, error))
    low, high = breakaway_limits(plant, state.position)
    if low <= net_force(plant, after) <= high:
        return Attempt(after, 0, step, next_step(step, error))
    event = breakaway(plant, course, state, a, b, step, after)
    return Attempt(event.state, event.direction, event.elapsed, LONGEST_STEP)


@kernel_by_type
def advance_from(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    flows: Inflows,
    period: float,
    tolerance: float,
) -> tuple[AnyMotion, AnyCourse, int]:
    """:func:`advance` from a state that ``flows`` enter, which need not be computed again.

    Returns the course from then on, too.
    """
    left = step = period
    direction = sliding_direction(plant, state)
    for _ in range(MOST_STEPS + int(MOST_STEPS_PER_SECOND * period)):
        step = step_on(plant, course, step_within(left, step))
        if direction == 0:
            attempt = sticking_attempt(plant, course, stopped(state), flows, step, tolerance)
        else:
            attempt = sliding_attempt(plant, course, state, flows, direction, step, tolerance)
        state, direction, elapsed, step = attempt
        if elapsed > 0.0:
            left -= elapsed
            course = course_after(plant, course, elapsed, state)
            fault = fault_of(plant, state)
            if fault != 0 or left <= 0.0:
                return state, course, fault
            flows = inflows(plant, course, state)
    return state, course, TOO_MANY_STEPS


@version_for(FullMotion, advance_from)
def _advance_from(
    plant: Plant,
    course: AnyCourse,
    state: FullMotion,
    flows: Inflows,  # noqa: ARG001
    period: float,
    tolerance: float,
) -> tuple[FullMotion, AnyCourse, int]:
    return advance_full(plant, course, state, period, tolerance)


@kernel
def advance(
    plant: Plant, course: AnyCourse, state: AnyMotion, period: float, tolerance: float
) -> tuple[AnyMotion, int]:
    """Keep the valve at its openings, or let them take their ``course``, for ``period`` s.

    The integrator chooses its steps anew in every call, for an error of ``tolerance``
    (``time.tolerance``). Returns the state and a code of :mod:`rodless_sim.physics.faults`: 0
    where it is sound.
    """
    flows = inflows(plant, course, state)
    state, _, fault = advance_from(plant, course, state, flows, period, tolerance)
    return state, fault


@outlined_kernel
def advance_at_voltage(
    plant: Plant,
    spool: AnySpool,
    voltage: float,
    state: AnyMotion,
    period: float,
    tolerance: float,
) -> tuple[AnyMotion, AnySpool, float, float, int]:
    """:func:`advance` once ``voltage`` (V) has arrived; with the spool and both flows at the end.

    The mass flows are those into A and B in kg/s.
    """
    course = course_at(plant, spool, voltage)
    fault = 0
    if period > 0.0:
        flows = inflows(plant, course, state)
        state, course, fault = advance_from(plant, course, state, flows, period, tolerance)
    a, b = inflows(plant, course, state)
    return state, spool_of(course), a.mass_flow, b.mass_flow, fault
