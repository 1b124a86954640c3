# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One step of the method, against the method's theory and dense linear algebra."""

import cmath
import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rodless_sim import RigParameters
from rodless_sim.physics.equations import inflows, pressure_rates, rates, sliding_rates
from rodless_sim.physics.integrator import (
    GAMMA,
    eliminated,
    error_size,
    next_step,
    sliding_step,
    solved,
    sticking_step,
)
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

PLANT = Plant.of(RigParameters())
GENERATOR = np.random.default_rng(4)

# The one root between 1/3 and 1/2 makes a method of three stages and order 3 L-stable: Hairer and
# Wanner, Solving Ordinary Differential Equations II, table IV.6.4.
L_STABLE = brentq(lambda g: g**3 - 3.0 * g**2 + 1.5 * g - 1.0 / 6.0, 1.0 / 3.0, 0.5, xtol=1e-16)


def growth(z: float) -> float:
    """What any L-stable method of order 3 with three stages makes of y' = z y in one unit of time.

    The numerator are the first terms of e^z (1 - γ z)³, of degree 2 at most.
    """
    g = L_STABLE
    numerator = 1.0 + (1.0 - 3.0 * g) * z + (0.5 - 3.0 * g + 3.0 * g * g) * z * z
    return float(numerator / (1.0 - g * z) ** 3)


def test_its_coefficient_is_the_l_stable_one() -> None:
    """γ is a root of γ³ - 3 γ² + 3/2 γ - 1/6, to the last digit."""
    assert pytest.approx(L_STABLE, rel=1e-14) == GAMMA


@pytest.mark.parametrize("share", [1e-3, 0.1, 1.0, 10.0, 1e3])
@pytest.mark.parametrize("side", ["a", "b"])
def test_a_chamber_that_vents_into_next_to_nothing_follows_the_methods_growth(
    share: float, side: str
) -> None:
    """Choked outflow falls with the pressure, P' = -P/τ: a step of h gives R(-h/τ) of it.

    From a hundredth of τ to a thousand of them, where an L-stable method leaves next to nothing.
    The other chamber, at the supply's pressure and wide open to it, stays.
    """
    plant = Plant.of(RigParameters({"valve.gap_height": 0.0, "atmosphere.pressure": 5e4}))
    lands = openings(plant, 0.0 if side == "a" else 10.0)
    supply = plant.supply_pressure
    state = Motion(0.1, 0.0, *((6e5, supply) if side == "a" else (supply, 6e5)))
    a, b = pressure_rates(plant, state, inflows(plant, lands, state), 0.0)
    rate = (a if side == "a" else b).rate / 6e5
    assert rate < 0.0
    # The outflow is choked as long as the pressure is above 50 kPa / 0.528, also halfway.
    plant = plant._replace(ambient_pressure=1e-9)
    after, _ = sticking_step(plant, lands, state, a, b, -share / rate)
    pressures = (after.pressure_a, after.pressure_b)
    expected = 6e5 * growth(-share)
    assert pressures[side == "b"] == pytest.approx(expected, abs=6e5 * 1e-9)
    assert pressures[side == "a"] == pytest.approx(supply, rel=1e-12)
    assert (after.position, after.velocity) == (0.1, 0.0)


def dense(first: object) -> npt.NDArray[np.float64]:
    """Return the derivatives of a sliding rig's rates as a matrix, 4 by 4."""
    a, b, push = first.a, first.b, first.by_pressure  # type: ignore[attr-defined]
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [first.by_position, first.by_velocity, push, -push],  # type: ignore[attr-defined]
            [a.by_position, a.by_velocity, a.by_pressure, 0.0],
            [b.by_position, b.by_velocity, 0.0, b.by_pressure],
        ]
    )


@pytest.mark.parametrize("step", [1e-5, 1e-3, 0.1])
def test_the_arrowhead_is_solved_as_a_dense_matrix_is(step: float) -> None:
    """Of random rigs with a spring on the carriage: (1/(γ h) - J) u = r, solved by LAPACK."""
    lands = openings(PLANT, 7.0)
    for _ in range(20):
        state = Motion(
            GENERATOR.uniform(0.01, 0.19),
            GENERATOR.uniform(0.01, 1.0),
            *GENERATOR.uniform(1.1e5, 5.5e5, 2).tolist(),
        )
        first = sliding_rates(PLANT, state, inflows(PLANT, lands, state), 1)
        first = first._replace(by_position=GENERATOR.uniform(-1e4, 1e4))
        unit = np.array([1e-3, 1.0, 1e5, 1e5])  # so that all numbers are of about one size
        right = GENERATOR.uniform(-1e3, 1e3, 4)
        matrix = np.eye(4) / (GAMMA * step) - dense(first) * unit / unit[:, None]
        expected = np.linalg.solve(matrix, right)
        found = solved(eliminated(first, step), Motion(*(right * unit).tolist())) / unit
        scale = np.abs(np.linalg.inv(matrix)) @ np.abs(right)
        assert np.abs((found - expected) / scale).max() < 1e-11


def sliding(voltage: float) -> tuple[Motion, int]:
    """Return a carriage that slides, all its rates alive, and its direction."""
    if voltage > 5.08:
        return Motion(0.06, 0.03, 4.2e5, 2.6e5), 1
    return Motion(0.14, -0.04, 2.4e5, 4.4e5), -1


def exact(voltage: float, state: Motion, direction: int, step: float) -> npt.NDArray[np.float64]:
    """Return the solution after ``step`` s to some twelve digits, by an explicit method of order 8.

    In units in which errors count as 1.
    """
    lands = openings(PLANT, voltage)
    unit = np.array([1e-8, 1e-5, 2.0, 2.0])
    result = solve_ivp(
        lambda _, y: np.array(rates(PLANT, lands, Motion(*(y * unit).tolist()), direction)) / unit,
        (0.0, step),
        np.array(state) / unit,
        method="DOP853",
        rtol=1e-13,
        atol=1e-7,
    )
    return np.asarray(result.y[:, -1] * unit)


@pytest.mark.parametrize("voltage", [3.5, 7.0])
def test_a_sliding_step_is_right_to_the_fourth_power_of_its_length(voltage: float) -> None:
    """Against DOP853: halving the step makes every component's error 16 times smaller."""
    state, direction = sliding(voltage)
    lands = openings(PLANT, voltage)
    first = sliding_rates(PLANT, state, inflows(PLANT, lands, state), direction)
    errors = []
    for step in (8e-5, 4e-5, 2e-5):
        after, _ = sliding_step(PLANT, lands, state, direction, first, step)
        errors.append(np.abs(np.array(after) - exact(voltage, state, direction, step)))
    order = np.log2(errors[0] / errors[1]), np.log2(errors[1] / errors[2])
    assert np.array(order) == pytest.approx(4.0, abs=0.6)


@pytest.mark.parametrize("voltage", [3.5, 7.0])
@pytest.mark.parametrize("rest", [False, True])
def test_the_estimate_is_that_of_a_method_of_order_two(voltage: float, rest: bool) -> None:
    """It falls with the third power of the step, and is larger than the error it stands for."""
    state, direction = sliding(voltage)
    lands = openings(PLANT, voltage)
    estimates = []
    for step in (1e-5, 5e-6, 2.5e-6):
        flows = inflows(PLANT, lands, state)
        if rest:
            a, b = pressure_rates(PLANT, state, flows, 0.0)
            _, estimate = sticking_step(PLANT, lands, state, a, b, step)
        else:
            first = sliding_rates(PLANT, state, flows, direction)
            after, estimate = sliding_step(PLANT, lands, state, direction, first, step)
            gap = np.array(after) - exact(voltage, state, direction, step)
            assert estimate > error_size(Motion(*gap.tolist()))
        estimates.append(estimate)
    order = np.log2(estimates[0] / estimates[1]), np.log2(estimates[1] / estimates[2])
    assert np.array(order) == pytest.approx(3.0, abs=0.1)


def test_errors_count_by_their_own_units() -> None:
    """10 nm, 10 µm/s and 2 Pa count as 1, of either sign; the largest counts."""
    one = (1e-8, 1e-5, 2.0, 2.0)
    for place, value in enumerate(one):
        for sign in (1.0, -1.0):
            error = [0.1 * other for other in one]
            error[place] = 3.0 * sign * value
            assert error_size(Motion(*error)) == pytest.approx(3.0, rel=1e-12)
    for place in range(4):
        error = list(one)
        error[place] = math.nan
        assert math.isnan(error_size(Motion(*error)))


def test_the_next_step_aims_at_an_error_of_six_tenths() -> None:
    """An error falls with the third power, 0.85³ = 0.614; a step grows to 5 times, falls to 0.1."""
    for error in (0.006, 0.1, 1.0, 40.0, 590.0):
        found = next_step(2e-4, error)
        assert error * (found / 2e-4) ** 3 == pytest.approx(0.614125, rel=1e-9)
    assert next_step(2e-4, 0.0) == next_step(2e-4, 0.0049) == 1e-3
    for wild in (600.0, 1e9, math.inf, math.nan):
        assert next_step(2e-4, wild) == pytest.approx(2e-5, rel=1e-12)


def test_the_growth_itself_is_of_order_three() -> None:
    """The formula these tests stand on: R(z) - e^z is of fourth order, and R vanishes far left."""
    gaps = [abs(growth(z) - cmath.exp(z).real) for z in (-0.02, -0.01)]
    assert math.log2(gaps[0] / gaps[1]) == pytest.approx(4.0, abs=0.05)
    assert abs(growth(-1e9)) < 1e-8
