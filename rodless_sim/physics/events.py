# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where within a step the carriage stops, breaks away or strikes an end cap.

The equations change there, so the step is cut at that instant. It is found by repeating the step
from the same rates with other lengths, so that it lies on the very curve the step follows.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.cylinder import PressureRate
from rodless_sim.physics.end_stop import rebound
from rodless_sim.physics.equations import (
    Rates,
    breakaway_limits,
    net_force,
    sliding_direction,
)
from rodless_sim.physics.integrator import sliding_step, sticking_step
from rodless_sim.physics.lands import AnyCourse
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, carried, stopped

# How near to the event is near enough.
SMALLEST_FORCE = 1e-8  # N
SMALLEST_VELOCITY = 1e-12  # m/s
SMALLEST_GAP = 1e-13  # m

# The method of the false position converges in some five steps; bisection would need 52.
MOST_TRIALS = 60
MOST_HALVINGS = 40

# The shortest part of a step that is tried.
SHORTEST = 1e-12

# How finely a step is searched for a stop that ends before the step does.
PARTS = 8


class Event(NamedTuple):
    """What happened within a step."""

    state: AnyMotion
    direction: int  # of sliding from then on, 0 for a carriage at rest
    elapsed: float  # s, since the start of the step


class Bracket(NamedTuple):
    """Two instants between which a value changes its sign."""

    before: float  # s
    value_before: float
    after: float  # s
    value_after: float


@kernel
def guess(bracket: Bracket) -> float:
    """Return the instant at which the value would be zero if it were a straight line.

    Never the start of the step itself: a step cannot have no length.
    """
    rise = bracket.value_after - bracket.value_before
    if rise == 0.0:
        return bracket.after
    found = bracket.after - bracket.value_after * (bracket.after - bracket.before) / rise
    return max(found, SHORTEST * max(bracket.before, bracket.after))


@kernel
def narrowed(bracket: Bracket, time: float, value: float) -> Bracket:
    """Return the part of the bracket with the change of sign, by the Illinois rule.

    The newest instant is kept as ``after``. The value of an end that stays is halved, or it might
    stay for ever.
    """
    if (value > 0.0) == (bracket.value_after > 0.0):
        return Bracket(bracket.before, 0.5 * bracket.value_before, time, value)
    return Bracket(bracket.after, bracket.value_after, time, value)


@kernel
def later_start(bracket: Bracket, time: float, value: float) -> Bracket:
    """Return the bracket from ``time`` on."""
    return Bracket(time, value, bracket.after, bracket.value_after)


@kernel
def earlier_end(bracket: Bracket, time: float, value: float) -> Bracket:
    """Return the bracket up to ``time``."""
    return Bracket(bracket.before, bracket.value_before, time, value)


@kernel
def gap_ahead(plant: Plant, state: AnyMotion, direction: int) -> float:
    """Distance in m to the cap ahead of a carriage that slides in ``direction``."""
    return plant.cylinder.stroke - state.position if direction > 0 else state.position


@kernel
def stops_within(speed: float, rate: float, after: float, rate_after: float, step: float) -> bool:
    """Whether a speed falls below zero within a step of ``step`` s, by its cubic Hermite curve.

    Speeds are in m/s in the direction of motion, their rates in m/s². A carriage that starts from
    rest has not stopped.
    """
    if after <= 0.0:
        return True
    if speed == 0.0:
        return False
    first = step * rate
    second = 3.0 * (after - speed) - step * (2.0 * rate + rate_after)
    third = 2.0 * (speed - after) + step * (rate + rate_after)
    # The curve is speed + first x + second x² + third x³; here is where its slope turns positive.
    discriminant = second * second - 3.0 * first * third
    if discriminant <= 0.0:
        return False
    curvature = second + math.sqrt(discriminant)
    if curvature == 0.0:
        return False
    place = -first / curvature
    lowest = speed + place * (first + place * (second + place * third))
    return 0.0 < place < 1.0 and lowest < 0.0


@kernel
def standstill(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    direction: int,
    first: Rates,
    step: float,
    after: AnyMotion,
) -> Event:
    """Find where a sliding carriage stops; ``elapsed`` is negative if it does not."""
    bracket = Bracket(0.0, direction * state.velocity, step, direction * after.velocity)
    if bracket.value_after > 0.0:
        # It stops and would slide on: look for an instant between.
        for part in range(1, PARTS):
            time = step * part / PARTS
            found, _ = sliding_step(plant, course, state, direction, first, time)
            if direction * found.velocity <= 0.0:
                bracket = earlier_end(bracket, time, direction * found.velocity)
                break
        if bracket.value_after > 0.0:
            return Event(after, direction, -1.0)
    if bracket.value_before <= 0.0:
        # It starts from rest: look for an instant at which it moves.
        time = bracket.after
        for _ in range(MOST_HALVINGS):
            time *= 0.5
            found, _ = sliding_step(plant, course, state, direction, first, time)
            if direction * found.velocity > 0.0:
                bracket = later_start(bracket, time, direction * found.velocity)
                break
            bracket = earlier_end(bracket, time, direction * found.velocity)
        if bracket.value_before <= 0.0:
            return Event(stopped(state), 0, 0.0)
    found = after
    for _ in range(MOST_TRIALS):
        time = guess(bracket)
        found, _ = sliding_step(plant, course, state, direction, first, time)
        value = direction * found.velocity
        bracket = narrowed(bracket, time, value)
        if abs(value) < SMALLEST_VELOCITY or bracket.before == bracket.after:
            break
    found = stopped(found)
    return Event(found, sliding_direction(plant, found), bracket.after)


@kernel
def impact(
    plant: Plant, course: AnyCourse, state: AnyMotion, direction: int, first: Rates, until: Event
) -> Event:
    """Find where a sliding carriage strikes a cap that it has passed at ``until``."""
    bracket = Bracket(
        0.0,
        gap_ahead(plant, state, direction),
        until.elapsed,
        gap_ahead(plant, until.state, direction),
    )
    found, elapsed = state, 0.0
    if bracket.value_before > 0.0:
        for _ in range(MOST_TRIALS):
            elapsed = guess(bracket)
            found, _ = sliding_step(plant, course, state, direction, first, elapsed)
            gap = gap_ahead(plant, found, direction)
            bracket = narrowed(bracket, elapsed, gap)
            if abs(gap) < SMALLEST_GAP or bracket.before == bracket.after:
                break
    cap = plant.cylinder.stroke if direction > 0 else 0.0
    struck = carried(found, cap, rebound(plant.end_stop, found.velocity))
    return Event(struck, sliding_direction(plant, struck), elapsed)


@outlined_kernel
def sliding_event(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    direction: int,
    first: Rates,
    step: float,
    after: AnyMotion,
    stops: bool,
) -> Event:
    """Find the first event of a step of a sliding carriage that led to ``after``.

    ``stops`` says that it may stop. With no event this is the end of the step.
    """
    event = Event(after, direction, step)
    if stops:
        found = standstill(plant, course, state, direction, first, step, after)
        if found.elapsed >= 0.0:
            event = found
    if gap_ahead(plant, event.state, direction) <= 0.0 and event.elapsed > 0.0:
        event = impact(plant, course, state, direction, first, event)
    return event


@outlined_kernel
def breakaway(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    a: PressureRate,
    b: PressureRate,
    step: float,
    after: AnyMotion,
) -> Event:
    """Find where a carriage at rest breaks away in a step at whose end it is pushed too hard."""
    low, high = breakaway_limits(plant, state.position)
    direction = 1 if net_force(plant, after) > high else -1
    limit = high if direction > 0 else -low
    bracket = Bracket(
        0.0,
        direction * net_force(plant, state) - limit,
        step,
        direction * net_force(plant, after) - limit,
    )
    found = after
    if bracket.value_before >= 0.0:
        # The push starts at the limit, or past it by rounding: it may fall first and grow later.
        for _ in range(MOST_HALVINGS // 2):
            time = 0.5 * bracket.after
            found, _ = sticking_step(plant, course, state, a, b, time)
            value = direction * net_force(plant, found) - limit
            if value < 0.0:
                bracket = later_start(bracket, time, value)
                break
            bracket = earlier_end(bracket, time, value)
        if bracket.value_before >= 0.0:
            return Event(found, direction, bracket.after)
    for _ in range(MOST_TRIALS):
        time = guess(bracket)
        found, _ = sticking_step(plant, course, state, a, b, time)
        value = direction * net_force(plant, found) - limit
        bracket = narrowed(bracket, time, value)
        if abs(value) < SMALLEST_FORCE or bracket.before == bracket.after:
            break
    return Event(found, direction, bracket.after)
