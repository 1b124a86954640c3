# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One step in time: ROS3, a Rosenbrock method of order 3 with an error estimate of order 2.

L-stable: no rate of change, however fast, limits the step; only accuracy does. A step from s with
the rates f and their derivatives J solves three linear systems with the same matrix,

    (d I − J) u₁ = f(s)                              d = 1/(γ h)
    (d I − J) u₂ = f(s + u₁) + c₂₁/h u₁
    (d I − J) u₃ = f(s + u₁) + c₃₁/h u₁ + c₃₂/h u₂
    s⁺ = s + u₁ + b₂ u₂ + b₃ u₃                      error = e₁ u₁ + e₂ u₂ + e₃ u₃

Coefficients: Sandu, Verwer, Blom, Spee, Carmichael and Potra, *Benchmarking stiff ODE solvers for
atmospheric chemistry problems II: Rosenbrock solvers*, Atmospheric Environment 31, 1997.

The matrix is an arrowhead: every state changes with itself, with position and velocity, and only
the acceleration with all of them. Each chamber is eliminated by :func:`leaf`, a leak between the
chambers by :func:`exchanged`, then the position, and the velocity is what remains. A further state
that changes with itself and the carriage (a bristle, a coupled mass) is one more leaf here and one
more term of the velocity's pivot; states that change with each other are one leaf of two states, as
pressure and temperature of one chamber in :mod:`~rodless_sim.physics.heated`. A state that an
option leaves out has no leaf and costs nothing.
"""

from typing import Any, NamedTuple

from rodless_base.kernels import kernel, kernel_by_type
from rodless_sim.physics.cylinder import PressureRate
from rodless_sim.physics.equations import Rates, inflows, motion_rate, pressure_rates, rates
from rodless_sim.physics.lands import AnyCourse
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, Motion, moved

GAMMA = 0.43586652150845899942
C21 = -1.0156171083877702
C31, C32 = 4.0759956452537700, 9.2076794298330791
B2, B3 = 6.1697947043828246, -0.42772256543218573
E1, E2, E3 = 0.5, -2.9079558716805470, 0.22354069897811570

# Errors of a step that count as 1, with time.tolerance 1.
POSITION_ERROR = 1e-8  # m
VELOCITY_ERROR = 1e-5  # m/s
PRESSURE_ERROR = 2.0  # Pa


class Leaf(NamedTuple):
    """One state's row, solved for what position and velocity do to it."""

    inverse: float  # s
    by_position: float
    by_velocity: float


class Exchange(NamedTuple):
    """What the chambers' rows, each solved by itself, leave of each other: a leak between them."""

    of_a: float  # how P_a follows P_b
    of_b: float  # how P_b follows P_a


class Matrix(NamedTuple):
    """The matrix d I − J, eliminated down to the velocity."""

    inverse: float  # s, 1/d
    by_position: float  # of the acceleration, 1/s²
    by_pressure: float  # of the acceleration, m/(s²·Pa)
    pivot: float  # s
    # Those of the chambers, as eliminated_chambers() or a version of it makes them.
    a: Any  # Leaf
    b: Any  # Leaf
    exchange: Any  # Exchange


@kernel
def exchanged(exchange: Exchange, a: float, b: float) -> tuple[float, float]:
    """Solve P_a = a + of_a P_b and P_b = b + of_b P_a."""
    if exchange.of_a == 0.0 and exchange.of_b == 0.0:
        return a, b
    scale = 1.0 / (1.0 - exchange.of_a * exchange.of_b)
    return (a + exchange.of_a * b) * scale, (b + exchange.of_b * a) * scale


@kernel
def leaf(rate: PressureRate, diagonal: float) -> Leaf:
    """Eliminate the row of one chamber; ``diagonal`` is d."""
    inverse = 1.0 / (diagonal - rate.by_pressure)
    by_velocity = (rate.by_position / diagonal + rate.by_velocity) * inverse
    return Leaf(inverse, rate.by_position, by_velocity)


@kernel_by_type
def eliminated_chambers(
    first: PressureRate, second: PressureRate, diagonal: float
) -> tuple[Leaf, Leaf, Exchange]:
    """Eliminate the rows of both chambers, which may leak into each other."""
    a, b = leaf(first, diagonal), leaf(second, diagonal)
    exchange = Exchange(first.by_other * a.inverse, second.by_other * b.inverse)
    by_velocity_a, by_velocity_b = exchanged(exchange, a.by_velocity, b.by_velocity)
    return (
        Leaf(a.inverse, a.by_position, by_velocity_a),
        Leaf(b.inverse, b.by_position, by_velocity_b),
        exchange,
    )


@kernel
def eliminated(first: Rates, step: float) -> Matrix:
    """Eliminate all rows for a step of ``step`` s."""
    diagonal = 1.0 / (GAMMA * step)
    inverse = 1.0 / diagonal
    a, b, exchange = eliminated_chambers(first.a, first.b, diagonal)
    own = diagonal - first.by_velocity - first.by_position * inverse
    pivot = 1.0 / (own - first.by_pressure * (a.by_velocity - b.by_velocity))
    return Matrix(inverse, first.by_position, first.by_pressure, pivot, a, b, exchange)


@kernel_by_type
def solved(matrix: Matrix, right: Motion) -> Motion:
    """Solve for the right-hand side ``right``."""
    a, b = matrix.a, matrix.b
    shift = right.position * matrix.inverse
    rest_a, rest_b = exchanged(
        matrix.exchange,
        (right.pressure_a + a.by_position * shift) * a.inverse,
        (right.pressure_b + b.by_position * shift) * b.inverse,
    )
    push = matrix.by_pressure * (rest_a - rest_b) + matrix.by_position * shift
    velocity = (right.velocity + push) * matrix.pivot
    return Motion(
        shift + velocity * matrix.inverse,
        velocity,
        rest_a + a.by_velocity * velocity,
        rest_b + b.by_velocity * velocity,
    )


@kernel_by_type
def error_size(error: Motion) -> float:
    """Return the largest error in units of what counts as 1; NaN where one is no number."""
    carriage = max(abs(error.position) / POSITION_ERROR, abs(error.velocity) / VELOCITY_ERROR)
    air = max(abs(error.pressure_a), abs(error.pressure_b)) / PRESSURE_ERROR
    # A maximum passes over what is not a number.
    total = error.position + error.velocity + error.pressure_a + error.pressure_b
    return max(carriage, air) + 0.0 * total


@kernel_by_type
def staged(
    plant: Plant,
    course: AnyCourse,
    state: AnyMotion,
    direction: int,
    matrix: Matrix,
    first: AnyMotion,
    step: float,
) -> tuple[AnyMotion, float]:
    """Take one step by the three stages; ``first`` is the rate at ``state``.

    Returns the state after ``step`` s and the size of its error.
    """
    u1 = solved(matrix, first)
    later = rates(plant, course, moved(state, u1, 1.0), direction)
    u2 = solved(matrix, moved(later, u1, C21 / step))
    u3 = solved(matrix, moved(moved(later, u1, C31 / step), u2, C32 / step))
    after = moved(moved(moved(state, u1, 1.0), u2, B2), u3, B3)
    # E1 is a half, and a half of u1 less than u1 is exact.
    return after, error_size(moved(moved(moved(u1, u1, E1 - 1.0), u2, E2), u3, E3))


@kernel
def sliding_step(
    plant: Plant, course: AnyCourse, state: AnyMotion, direction: int, first: Rates, step: float
) -> tuple[AnyMotion, float]:
    """Take one step of a sliding carriage, ``first`` being its rates at ``state``.

    Returns the state after ``step`` s and the size of its error.
    """
    rate = motion_rate(first.velocity, first.acceleration, first.a, first.b)
    return staged(plant, course, state, direction, eliminated(first, step), rate, step)


@kernel_by_type
def sticking_step(
    plant: Plant, course: AnyCourse, state: Motion, a: PressureRate, b: PressureRate, step: float
) -> tuple[Motion, float]:
    """:func:`sliding_step` for a carriage at rest, which leaves the chambers to each other."""
    diagonal = 1.0 / (GAMMA * step)
    inverse_a, inverse_b = 1.0 / (diagonal - a.by_pressure), 1.0 / (diagonal - b.by_pressure)
    exchange = Exchange(a.by_other * inverse_a, b.by_other * inverse_b)
    a1, b1 = exchanged(exchange, a.rate * inverse_a, b.rate * inverse_b)
    halfway = Motion(state.position, 0.0, state.pressure_a + a1, state.pressure_b + b1)
    later_a, later_b = pressure_rates(plant, halfway, inflows(plant, course, halfway), 0.0)
    a2, b2 = exchanged(
        exchange,
        (later_a.rate + C21 / step * a1) * inverse_a,
        (later_b.rate + C21 / step * b1) * inverse_b,
    )
    a3, b3 = exchanged(
        exchange,
        (later_a.rate + C31 / step * a1 + C32 / step * a2) * inverse_a,
        (later_b.rate + C31 / step * b1 + C32 / step * b2) * inverse_b,
    )
    after = Motion(
        state.position,
        0.0,
        state.pressure_a + a1 + B2 * a2 + B3 * a3,
        state.pressure_b + b1 + B2 * b2 + B3 * b3,
    )
    error_a, error_b = E1 * a1 + E2 * a2 + E3 * a3, E1 * b1 + E2 * b2 + E3 * b3
    return after, max(abs(error_a), abs(error_b)) / PRESSURE_ERROR


@kernel
def next_step(step: float, error: float) -> float:
    """Return the step that should make an error of 0.6 where ``step`` made ``error``.

    It grows at most fivefold, and shrinks at most tenfold: so too for an error that is no number.
    """
    if error < 0.005:
        return 5.0 * step
    if not error < 600.0:
        return 0.1 * step
    shrinking: float = error ** (-1.0 / 3.0)
    return 0.85 * step * shrinking
