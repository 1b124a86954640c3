# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The openings of a valve whose spool moves: what takes the place of constant :class:`Lands`.

The equations of motion then change with time too. The stages of :mod:`integrator` take the openings
at their own instants, and the rates' change with time,

    (d I − J) u_i = … + γ_i h ∂f/∂t                   stages 2 and 3 at t + α h

so that the method keeps its order. Its own estimate of the error does not see all of what the
openings do: a spool that sets out from rest has hardly moved by t + α h, and is far by the step's
end. So the openings there are looked at too, by :func:`in_time_error`. Where the spool passes the
closed position, its edges exchange their parts, and at either end of its stroke the openings change
no more: a step ends there.
"""

import math
from typing import Any

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel, version_for
from rodless_sim.physics import equations, integrator
from rodless_sim.physics.cylinder import PressureRate
from rodless_sim.physics.equations import motion_rate, rates
from rodless_sim.physics.events import MOST_HALVINGS, MOST_TRIALS, Bracket, guess, narrowed
from rodless_sim.physics.heat import HeatedRate
from rodless_sim.physics.integrator import (
    B2,
    B3,
    C21,
    C31,
    C32,
    E1,
    E2,
    E3,
    GAMMA,
    Matrix,
    eliminated_chambers,
    error_size,
    solved,
    staged,
)
from rodless_sim.physics.lands import AnyCourse, Course, Lands, Timed
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.spool import (
    AnySpool,
    Spool,
    calmed,
    sent,
    spool_voltage,
    swung,
)
from rodless_sim.physics.state import AnyMotion, moved

# Of ROS3: the instant of the later stages, and the weights of ∂f/∂t.
ALPHA = GAMMA
GAMMA_1, GAMMA_2, GAMMA_3 = GAMMA, 0.24291996454816804366, 2.1851380027664058511

# The error of the method in ∫ f dt, of what f is at the step's end beyond the parabola through its
# value and slope at the start and its value at α h: for a cubic, (1/4 − α/3) / (1 − α).
BEYOND_PARABOLA = (1.0 / 4.0 - ALPHA / 3.0) / (1.0 - ALPHA)

# Of a difference that gives the openings' change: their curves are straight over this.
NEAR = 1e-6  # V

# While the spool moves, a step is at most this angle of its oscillation.
LONGEST_ANGLE = 1.0  # rad

# The spool is at the closed position within this; and how little is past it, one bit.
CLOSE = 1e-9  # V
BEYOND = 1e-15  # V


@kernel
def beyond(plant: Plant, forward: bool) -> float:
    """Return the voltage just past the closed position, ``forward`` or not."""
    closed = plant.valve.closed_voltage
    return closed if forward else closed - BEYOND


@outlined_kernel
def passing_time(plant: Plant, spool: Spool, position: float, latest: float, there: float) -> float:
    """Return when (s) the spool passes ``position`` (V), which it has at ``latest``.

    It is at ``there`` (V) then.
    """
    bracket = Bracket(0.0, spool.place - position, latest, there - position)
    for _ in range(MOST_TRIALS):
        time = guess(bracket)
        value = swung(plant.drive, spool, time).place - position
        bracket = narrowed(bracket, time, value)
        if abs(value) < CLOSE or bracket.before == bracket.after:
            break
    return bracket.after


@outlined_kernel
def staying_time(plant: Plant, spool: Spool, latest: float) -> float:
    """Return a time (s) before ``latest`` up to which a spool that leaves closed is not back."""
    closed = plant.valve.closed_voltage
    forward = spool.place >= closed
    time = latest
    for _ in range(MOST_HALVINGS):
        time *= 0.5
        if (swung(plant.drive, spool, time).place >= closed) == forward:
            break
    return time


@kernel
def course_from(plant: Plant, spool: Spool) -> Course:
    """Return the course of the openings from ``spool`` on."""
    drive, closed = plant.drive, plant.valve.closed_voltage
    horizon, passes = math.inf, False
    if spool.speed != 0.0 or spool.place != spool.target:
        horizon = LONGEST_ANGLE / drive.natural_frequency
        forward = spool.place >= closed
        there = swung(drive, spool, horizon).place
        passes = (there >= closed) != forward
        if passes and abs(spool.place - closed) > CLOSE:
            horizon = passing_time(plant, spool, closed, horizon, there)
        elif passes:
            passes = False
            upward = spool.speed > 0.0 or (spool.speed == 0.0 and spool.target > closed)
            if upward == forward:
                horizon = staying_time(plant, spool, horizon)
            else:
                spool = Spool(spool.target, beyond(plant, not forward), spool.speed)
        end = MAXIMUM_VOLTAGE if forward else MINIMUM_VOLTAGE
        there = swung(drive, spool, horizon).place
        if abs(spool.place - end) > CLOSE and (spool.place > end) != (there > end):
            horizon, passes = passing_time(plant, spool, end, horizon, there), False
    return Course(spool, openings(plant, spool_voltage(spool)), horizon, passes)


@kernel_by_type
def course_at(plant: Plant, spool: AnySpool, voltage: float) -> AnyCourse:  # noqa: ARG001
    """Return the openings from now on, after ``voltage`` (V) has arrived at the valve."""
    return openings(plant, voltage)


@version_for(Spool, course_at)
def _course_at(plant: Plant, spool: Spool, voltage: float) -> Course:
    found = sent(plant.drive, spool, voltage)
    if plant.drive.natural_frequency == 0.0:
        found = swung(plant.drive, found, 0.0)
    return course_from(plant, found)


@kernel_by_type
def openings_after(plant: Plant, course: Any, elapsed: float) -> Any:  # noqa: ARG001
    """Return the openings ``elapsed`` s later."""
    return course


@version_for(Course, openings_after)
def _openings_after(plant: Plant, course: Course, elapsed: float) -> Lands:
    if elapsed == 0.0:
        return course.lands
    voltage = spool_voltage(swung(plant.drive, course.spool, elapsed))
    # A step ends where the spool passes closed, with the edges still in their parts.
    if course.lands.forward:
        return openings(plant, max(voltage, beyond(plant, True)))
    return openings(plant, min(voltage, beyond(plant, False)))


@kernel
def openings_beside(plant: Plant, course: Course) -> tuple[Lands, float]:
    """Return openings near the present ones, and how often (1/s) the change to them happens."""
    spool = course.spool
    if spool.speed == 0.0:
        return course.lands, 0.0
    # Away from closed, where the curves have a kink.
    near = NEAR if course.lands.forward else -NEAR
    # A spool that comes back from the end of its stroke is about to leave it.
    if near * spool.speed < 0.0 and spool_voltage(moved_by(spool, near)) != spool.place + near:
        near = -near
    return openings(plant, spool_voltage(moved_by(spool, near))), spool.speed / near


@kernel
def moved_by(spool: Spool, distance: float) -> Spool:
    """Return the spool somewhere else (V)."""
    return Spool(spool.target, spool.place + distance, spool.speed)


@kernel_by_type
def spool_of(course: AnyCourse) -> AnySpool:  # noqa: ARG001
    """Return the spool on a course; nothing where it follows at once."""
    return ()


@version_for(Course, spool_of)
def _spool_of(course: Course) -> Spool:
    return course.spool


@kernel_by_type
def step_on(plant: Plant, course: AnyCourse, step: float) -> float:  # noqa: ARG001
    """Return the longest step in s, up to ``step``, that the course allows."""
    return step


@version_for(Course, step_on)
def _step_on(plant: Plant, course: Course, step: float) -> float:  # noqa: ARG001
    return min(step, course.horizon)


@kernel_by_type
def course_after(
    plant: Plant,  # noqa: ARG001
    course: AnyCourse,
    elapsed: float,  # noqa: ARG001
    after: AnyMotion,  # noqa: ARG001
) -> AnyCourse:
    """Return the course from ``elapsed`` s later on, when the rig is in the state ``after``."""
    return course


@version_for(Course, course_after)
def _course_after(
    plant: Plant,
    course: Course,
    elapsed: float,
    after: AnyMotion,  # noqa: ARG001
) -> Course:
    if course.spool.speed == 0.0 and course.spool.place == course.spool.target:
        return course
    spool = swung(plant.drive, course.spool, elapsed)
    if course.passes and elapsed == course.horizon:
        spool = Spool(spool.target, beyond(plant, not course.lands.forward), spool.speed)
    return course_from(plant, calmed(plant.drive, spool))


@version_for(Course, equations.inflows)
def _inflows(plant: Plant, course: Course, state: AnyMotion) -> object:
    return equations.inflows(plant, course.lands, state)


@kernel
def staged_with(
    plant: Plant,
    lands: Any,  # or what else lets air in
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    change: AnyMotion,
    weight: float,
    step: float,
) -> tuple[AnyMotion, float]:
    """Take one step as :func:`staged` does, by rates that change with time.

    ``plant`` and ``lands`` are those at the instant of the later stages, ``weight`` · ``change`` is
    h ∂f/∂t.
    """
    u1 = solved(matrix, moved(first, change, GAMMA_1 * weight))
    later = rates(plant, lands, moved(state, u1, 1.0), direction)
    u2 = solved(matrix, moved(moved(later, u1, C21 / step), change, GAMMA_2 * weight))
    sum3 = moved(moved(later, u1, C31 / step), u2, C32 / step)
    u3 = solved(matrix, moved(sum3, change, GAMMA_3 * weight))
    after = moved(moved(moved(state, u1, 1.0), u2, B2), u3, B3)
    return after, error_size(moved(moved(moved(u1, u1, E1 - 1.0), u2, E2), u3, E3))


@version_for((Course, Timed), integrator.sticking_step)
def _sticking_step(
    plant: Plant,
    course: Course | Timed,
    state: AnyMotion,
    a: PressureRate | HeatedRate,
    b: PressureRate | HeatedRate,
    step: float,
) -> tuple[AnyMotion, float]:
    # A pivot of nothing: whatever pushes, the carriage stays.
    chambers = eliminated_chambers(a, b, 1.0 / (GAMMA * step))
    matrix = Matrix(0.0, 0.0, 0.0, 0.0, chambers[0], chambers[1], chambers[2])
    return staged(plant, course, state, 0, matrix, motion_rate(0.0, 0.0, a, b), step)


@version_for(Course, staged)
def _staged(
    plant: Plant,
    course: Course,
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    step: float,
) -> tuple[AnyMotion, float]:
    return staged_on_the_way(plant, course, state, direction, matrix, first, step)


@kernel_by_type
def moving(course: Any) -> bool:  # noqa: ARG001
    """Whether the openings change during a step."""
    return False


@version_for(Course, moving)
def _moving(course: Course) -> bool:
    return course.spool.speed != 0.0 or course.spool.place != course.spool.target


@kernel
def worse(size: float, other: float) -> float:
    """Return the larger of two errors; NaN where one is no number."""
    return max(size, other) + 0.0 * (size + other)


@kernel
def in_time_error(
    first: AnyMotion,
    change: AnyMotion,
    weight: float,
    middle: AnyMotion,
    last: AnyMotion,
    step: float,
) -> float:
    """Return the size of the error in what the rates do by themselves during a step.

    ``first``, ``middle`` and ``last`` are the rates of one state at the start, α h later and at the
    end; ``weight`` · ``change`` is h ∂f/∂t at the start.
    """
    # h² f''/2 of the parabola, and what lies beyond it at the end.
    bend = moved(moved(middle, first, -1.0), change, -ALPHA * weight)
    rest = moved(moved(last, first, -1.0), change, -weight)
    rest = moved(rest, bend, -1.0 / (ALPHA * ALPHA))
    return error_size(moved(rest, rest, BEYOND_PARABOLA * step - 1.0))


@outlined_kernel
def staged_on_the_way(
    plant: Plant,
    course: Course,
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    step: float,
) -> tuple[AnyMotion, float]:
    """Take one step as :func:`staged` does, while the spool moves along its course.

    Three times the openings in every place that takes a step would be much to compile.
    """
    there, often = openings_beside(plant, course)
    change, weight = moved(first, first, -1.0), step * often
    if often != 0.0:
        change = moved(rates(plant, there, state, direction), first, -1.0)
    lands = openings_after(plant, course, ALPHA * step)
    after, size = staged_with(plant, lands, state, direction, matrix, first, change, weight, step)
    if moving(course):
        middle = rates(plant, lands, state, direction)
        last = rates(plant, openings_after(plant, course, step), state, direction)
        size = worse(size, in_time_error(first, change, weight, middle, last, step))
    return after, size
