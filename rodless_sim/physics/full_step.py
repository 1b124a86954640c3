# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One step of a :class:`FullMotion` in time, by the method of :mod:`integrator`.

Here the matrix d I − J is full, and made of differences: what an option adds to the rates is all
there is to it. Of the states only those that act have a row. What is eliminated goes from the
position on, without exchange of rows: with dissipation every pivot keeps its sign, in any units.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel, kernel_by_type, outlined_kernel, version_for
from rodless_sim.physics import course as valve_course
from rodless_sim.physics.course import (
    ALPHA,
    BEYOND_PARABOLA,
    GAMMA_1,
    GAMMA_2,
    GAMMA_3,
    moving,
    openings_after,
)
from rodless_sim.physics.full_numbers import (
    COUNT,
    OF_CARRIAGE,
    OF_PISTON,
    numbers_of,
    restored,
    store,
)
from rodless_sim.physics.full_rates import Modes, full_rates
from rodless_sim.physics.heated import TEMPERATURE_ERROR
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
    POSITION_ERROR,
    PRESSURE_ERROR,
    VELOCITY_ERROR,
)
from rodless_sim.physics.lands import AnyCourse, Course, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import FullMotion

Array = npt.NDArray[np.float64]

# A deflection that changes the force of the bristles as much as VELOCITY_ERROR changes that of the
# viscous friction.
BRISTLE_ERROR = 1e-9  # m

# Errors of a step that count as 1, with time.tolerance 1.
ERRORS = FullMotion(
    position=POSITION_ERROR,
    velocity=VELOCITY_ERROR,
    pressure_a=PRESSURE_ERROR,
    pressure_b=PRESSURE_ERROR,
    temperature_a=TEMPERATURE_ERROR,
    temperature_b=TEMPERATURE_ERROR,
    bristle_deflection=BRISTLE_ERROR,
    piston_position=POSITION_ERROR,
    piston_velocity=VELOCITY_ERROR,
    piston_bristle_deflection=BRISTLE_ERROR,
    coupled=1.0,
    supply_pressure=PRESSURE_ERROR,
    receiver_pressure=PRESSURE_ERROR,
    compressor=1.0,
    friction_clock=1.0,
    friction_dice=1.0,
    static_drift=1.0,
    coulomb_drift=1.0,
    viscous_drift=1.0,
)

# The differences that J is made of, in those units.
DIFFERENCE = 0.1

# Rows of rates: of the state at the start, with the openings then, beside them, α h later and at
# the end of the step; and of the later stages.
HERE, BESIDE, MIDDLE, LAST, LATER = range(5)


@kernel_by_type
def spanned(plant: Plant, course: AnyCourse, step: float) -> Any:  # noqa: ARG001
    """Return the course as a step of ``step`` s sees it."""
    return course


@kernel_by_type
def openings_beside(plant: Plant, course: Any) -> tuple[Any, float]:  # noqa: ARG001
    """Return openings near the present ones, and how often (1/s) the change to them happens."""
    return course, 0.0


@version_for(Course, openings_beside)
def _openings_beside(plant: Plant, course: Course) -> tuple[Lands, float]:
    return valve_course.openings_beside(plant, course)


@kernel
def rows_of(plant: Plant, modes: Modes, rows: npt.NDArray[np.int64]) -> int:
    """Write the places of the states that change, and return their number: not those held."""
    count = 0
    for i in range(plant.full.moving_count):
        place = plant.full.moving[i]
        carriage = place in OF_CARRIAGE
        piston = place in OF_PISTON
        if (carriage and modes.carriage == 0) or (piston and modes.piston == 0):
            continue
        rows[count] = place
        count += 1
    return count


@kernel
def decomposed(matrix: Array, count: int) -> None:
    """Write the factors L and U over the first ``count`` rows of a matrix."""
    for k in range(count):
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, count):
            factor = matrix[i, k] * inverse
            matrix[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, count):
                    matrix[i, j] -= factor * matrix[k, j]


@kernel
def solve(matrix: Array, count: int, right: Array) -> None:
    """Write the solution for the right-hand side over it; ``matrix`` is decomposed."""
    for i in range(1, count):
        for j in range(i):
            right[i] -= matrix[i, j] * right[j]
    for i in range(count - 1, -1, -1):
        for j in range(i + 1, count):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]


@kernel
def rates_beside(
    plant: Plant,
    course: AnyCourse,
    state: FullMotion,
    modes: Modes,
    rows: npt.NDArray[np.int64],
    rates: Array,
    matrix: Array,
) -> float:
    """Write the rates, shape (5, COUNT): here, and beside the present openings.

    Into ``matrix`` goes −J, each column the change of the rates with a state. Returns how often
    (1/s) the change to the openings beside happens.
    """
    count = len(matrix)
    trial, lands = numbers_of(state), openings_after(plant, course, 0.0)
    beside, often = openings_beside(plant, course)
    # In one loop, so that compiled code has the equations in one place.
    for k in range(-1, count + (1 if often != 0.0 else 0)):
        kept = difference = 0.0
        if k == count:
            lands = beside
        elif k >= 0:
            kept = trial[rows[k]]
            trial[rows[k]] = kept + DIFFERENCE * ERRORS[rows[k]]
            difference = trial[rows[k]] - kept
        row = HERE if k < 0 else BESIDE if k == count else MIDDLE
        store(full_rates(plant, lands, restored(trial), modes), rates[row])
        if 0 <= k < count:
            trial[rows[k]] = kept
            for i in range(count):
                matrix[i, k] = (rates[HERE, rows[i]] - rates[MIDDLE, rows[i]]) / difference
    return often


@kernel
def beyond_parabola(rates: Array) -> float:
    """:func:`in_time_error` of one state, over the step; BESIDE has h ∂f/∂t."""
    rise, turn = rates[HERE] + rates[BESIDE], ALPHA * rates[BESIDE]
    bend = (rates[MIDDLE] - rates[HERE] - turn) / (ALPHA * ALPHA)
    error: float = BEYOND_PARABOLA * (rates[LAST] - rise - bend)
    return error


@outlined_kernel
def full_step(
    plant: Plant, course: AnyCourse, state: FullMotion, modes: Modes, step: float
) -> tuple[FullMotion, float]:
    """Return the state after ``step`` s and the size of its error; NaN where it is no number."""
    rows = np.empty(COUNT, np.int64)
    n = rows_of(plant, modes, rows)
    rates, stages, numbers = np.zeros((5, COUNT)), np.empty((3, n)), numbers_of(state)
    matrix = np.empty((n, n))
    course = spanned(plant, course, step)
    often = rates_beside(plant, course, state, modes, rows, rates, matrix)
    for i in range(n):
        matrix[i, i] += 1.0 / (GAMMA * step)
    decomposed(matrix, n)
    u1, u2, u3 = stages[0], stages[1], stages[2]
    change = rates[BESIDE]
    for i in range(n):
        place = rows[i]
        change[place] = step * often * (change[place] - rates[HERE, place]) if often != 0.0 else 0.0
        u1[i] = rates[HERE, place] + GAMMA_1 * change[place]
    solve(matrix, n, u1)
    for i in range(n):
        numbers[rows[i]] += u1[i]
    watched = moving(course)
    for row in range(MIDDLE if watched else LATER, LATER + 1):
        lands = openings_after(plant, course, step if row == LAST else ALPHA * step)
        there = restored(numbers) if row == LATER else state
        store(full_rates(plant, lands, there, modes), rates[row])
    for i in range(n):
        u2[i] = rates[LATER, rows[i]] + C21 / step * u1[i] + GAMMA_2 * change[rows[i]]
    solve(matrix, n, u2)
    for i in range(n):
        u3[i] = (
            rates[LATER, rows[i]] + (C31 * u1[i] + C32 * u2[i]) / step + GAMMA_3 * change[rows[i]]
        )
    solve(matrix, n, u3)
    size = total = 0.0
    for i in range(n):
        numbers[rows[i]] += B2 * u2[i] + B3 * u3[i]
        error = E1 * u1[i] + E2 * u2[i] + E3 * u3[i]
        size = max(size, abs(error) / ERRORS[rows[i]])
        if watched:
            in_time = beyond_parabola(rates[:, rows[i]]) * step
            size = max(size, abs(in_time) / ERRORS[rows[i]])
        # A maximum passes over what is not a number.
        total += error + numbers[rows[i]]
    return restored(numbers), size + 0.0 * total
