# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A :class:`FullMotion` in time: steps between events, as :mod:`motion` takes them."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.bristles import growth
from rodless_sim.physics.course import course_after, step_on
from rodless_sim.physics.drift import ROUNDING, STEP, stepped
from rodless_sim.physics.events import (
    MOST_HALVINGS,
    MOST_TRIALS,
    Bracket,
    guess,
    narrowed,
    stops_within,
)
from rodless_sim.physics.faults import TOO_MANY_STEPS, fault_of
from rodless_sim.physics.friction import side_of, sliding
from rodless_sim.physics.full_events import (
    NEAR,
    Margins,
    after_events,
    consistent,
    is_crossed,
    margins,
    resumed,
)
from rodless_sim.physics.full_numbers import (
    CLOCK,
    DICE,
    FIRST_DRIFT,
    LAST_DRIFT,
    numbers_of,
    restored,
)
from rodless_sim.physics.full_rates import Body, Modes, bodies, body_rates
from rodless_sim.physics.full_step import full_step
from rodless_sim.physics.integrator import next_step
from rodless_sim.physics.lands import AnyCourse
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import FullMotion
from rodless_sim.physics.step_control import (
    FALL_ACCURACY,
    LONGEST_STEP,
    MOST_STEPS,
    MOST_STEPS_PER_SECOND,
    may_fall,
    step_in_the_fall,
    step_within,
)

# A stop and a new start are looked for in no shorter step.
SHORTEST_SEARCH = 1e-6  # s


class FullAttempt(NamedTuple):
    """Where a step has led."""

    state: FullMotion
    elapsed: float  # s, 0 where the step was too long and has not been taken
    step: float  # s, to try next
    event: bool  # whether the equations change


@kernel
def least(found: Margins, among: Margins) -> float:
    """Return the least of the margins of which ``among`` are below zero."""
    smallest = math.inf
    for k in range(len(found)):
        if among[k] < 0.0:
            smallest = min(smallest, found[k])
    return smallest


@outlined_kernel
def located(
    plant: Plant,
    course: AnyCourse,
    state: FullMotion,
    modes: Modes,
    step: float,
    crossed: Margins,
) -> FullAttempt:
    """Find the first instant in ``step`` s at which one of the margins ``crossed`` is nothing."""
    bracket = Bracket(
        0.0, least(margins(plant, state, modes), crossed), step, least(crossed, crossed)
    )
    found = state
    if bracket.value_before <= 0.0:
        # It starts at an event of the kind: look for an instant at which it is clear of it.
        time = step
        for _ in range(MOST_HALVINGS):
            time *= 0.5
            found, _ = full_step(plant, course, state, modes, time)
            value = least(margins(plant, found, modes), crossed)
            if value > 0.0:
                bracket = Bracket(time, value, bracket.after, bracket.value_after)
                break
            bracket = Bracket(0.0, bracket.value_before, time, value)
        if bracket.value_before <= 0.0:
            return FullAttempt(found, time, LONGEST_STEP, True)
    for _ in range(MOST_TRIALS):
        time = guess(bracket)
        found, _ = full_step(plant, course, state, modes, time)
        value = least(margins(plant, found, modes), crossed)
        bracket = narrowed(bracket, time, value)
        if abs(value) < NEAR or bracket.before == bracket.after:
            break
    return FullAttempt(found, bracket.after, LONGEST_STEP, True)


@kernel
def shorter_step(plant: Plant, before: Body, after: Body, mode: int, step: float) -> float:
    """Return the step to try instead where friction falls with the speed of a body, or ``step``."""
    direction = mode
    if plant.full.bristles.acting:
        direction = 1 if before.velocity + after.velocity > 0.0 else -1
    speed, speed_after = abs(before.velocity), abs(after.velocity)
    drag = sliding(after.friction, direction * speed_after, direction)
    side = side_of(after.friction, direction)
    slope = -after.share / after.mass * drag.by_speed
    if plant.full.bristles.acting:
        slope = growth(plant.full.bristles, side, speed_after, slope)
    return step_in_the_fall(speed, speed_after, slope, side.stribeck_velocity, step)


@kernel
def in_the_fall(before: Body, after: Body) -> bool:
    """Whether friction may fall with the speed of a body."""
    friction = before.friction
    widest = max(friction.forward.stribeck_velocity, friction.reverse.stribeck_velocity)
    return may_fall(min(abs(before.velocity), abs(after.velocity)), widest)


@kernel
def stop_hidden(plant: Plant, before: Body, after: Body, mode: int, step: float) -> bool:
    """Whether a sliding body may have stopped within a step and slid on."""
    if mode == 0 or plant.full.bristles.acting:
        return False
    rate = mode * body_rates(plant, before, mode).acceleration
    rate_after = mode * body_rates(plant, after, mode).acceleration
    speed, speed_after = mode * before.velocity, mode * after.velocity
    if speed <= 0.0 or speed_after <= 0.0:
        return False
    return stops_within(speed, rate, speed_after, rate_after, step)


@kernel
def attempt(
    plant: Plant,
    course: AnyCourse,
    state: FullMotion,
    modes: Modes,
    step: float,
    tolerance: float,
) -> FullAttempt:
    """Try a step of ``step`` s."""
    after, error = full_step(plant, course, state, modes, step)
    error /= tolerance
    carriage, piston = bodies(plant, state)
    carriage_after, piston_after = bodies(plant, after)
    slow = modes.carriage != 0 and in_the_fall(carriage, carriage_after)
    if slow or (modes.piston != 0 and in_the_fall(piston, piston_after)):
        error *= FALL_ACCURACY
    if not error <= 1.0:
        return FullAttempt(state, 0.0, next_step(step, error), False)
    shorter = step
    if modes.carriage != 0:
        shorter = shorter_step(plant, carriage, carriage_after, modes.carriage, shorter)
    if modes.piston != 0:
        shorter = shorter_step(plant, piston, piston_after, modes.piston, shorter)
    if shorter < step:
        return FullAttempt(state, 0.0, shorter, False)
    found = margins(plant, after, modes)
    if is_crossed(found):
        return located(plant, course, state, modes, step, found)
    if step > SHORTEST_SEARCH and (
        stop_hidden(plant, carriage, carriage_after, modes.carriage, step)
        or stop_hidden(plant, piston, piston_after, modes.piston, step)
    ):
        return FullAttempt(state, 0.0, 0.5 * step, False)
    return FullAttempt(after, step, next_step(step, error), False)


@kernel
def time_to_drift(plant: Plant, state: FullMotion, step: float) -> float:
    """Return the longest step in s, up to ``step``, in which friction does not drift."""
    if not plant.full.drift.acting:
        return step
    return min(step, STEP - state.friction_clock)


@kernel
def drifting(plant: Plant, state: FullMotion, elapsed: float) -> tuple[FullMotion, bool]:
    """Return the state with its clock ``elapsed`` s on, and whether friction has drifted then."""
    numbers = numbers_of(state)
    numbers[CLOCK] += elapsed
    if numbers[CLOCK] < STEP - ROUNDING:
        return restored(numbers), False
    numbers[CLOCK] = 0.0
    deviations = numbers[FIRST_DRIFT : LAST_DRIFT + 1]
    numbers[DICE] = stepped(plant.full.drift, numbers[DICE], deviations)
    return restored(numbers), True


@outlined_kernel
def advance_full(
    plant: Plant, course: AnyCourse, state: FullMotion, period: float, tolerance: float
) -> tuple[FullMotion, AnyCourse, int]:
    """Keep the valve on its ``course`` for ``period`` s, as :func:`motion.advance_from` does."""
    left = step = period
    state, modes = resumed(plant, consistent(plant, state))
    for _ in range(MOST_STEPS + int(MOST_STEPS_PER_SECOND * period)):
        step = time_to_drift(plant, state, step_on(plant, course, step_within(left, step)))
        state, elapsed, step, event = attempt(plant, course, state, modes, step, tolerance)
        if elapsed > 0.0:
            left -= elapsed
            course = course_after(plant, course, elapsed, state)
            if plant.full.drift.acting:
                state, drifts = drifting(plant, state, elapsed)
                if drifts:
                    state, modes = resumed(plant, state)
            if event:
                state, modes = resumed(plant, after_events(plant, state, modes))
            fault = fault_of(plant, state)
            if fault != 0 or left <= 0.0:
                return consistent(plant, state), course, fault
    return state, course, TOO_MANY_STEPS
