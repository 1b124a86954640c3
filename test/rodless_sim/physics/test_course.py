# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The course of a spool: where its steps end, and what the openings do within one.

What it is held against is the spool's equation by the matrix exponential, scipy's root finder and
numpy's polynomials.
"""

import math

import numpy as np
import numpy.typing as npt
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from rodless_sim import RigParameters
from rodless_sim.physics.course import (
    ALPHA,
    course_after,
    course_at,
    course_from,
    in_time_error,
    moving,
    openings_after,
    openings_beside,
    spool_of,
    step_on,
    worse,
)
from rodless_sim.physics.equations import inflows, pressure_rates, rates, sliding_rates
from rodless_sim.physics.integrator import (
    POSITION_ERROR,
    PRESSURE_ERROR,
    VELOCITY_ERROR,
    sliding_step,
    sticking_step,
)
from rodless_sim.physics.lands import Course, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.spool import Spool
from rodless_sim.physics.state import Motion

FREQUENCY, DAMPING, CLOSED = 2.0 * math.pi * 115.0, 0.7, 5.08
PLANT = Plant.of(RigParameters({"valve.dynamics": "second_order"}))
SYSTEM = np.array([[0.0, 1.0], [-(FREQUENCY**2), -2.0 * DAMPING * FREQUENCY]])
LONGEST = 1.0 / FREQUENCY  # s, one radian
ANYWHERE = Motion(0.1, 0.0, 4e5, 4e5)

# Across the closed position, either way, from rest and thrown; out of and back into the stroke.
ACROSS = (Spool(9.0, 5.0, 0.0), Spool(1.0, 5.2, 0.0), Spool(5.0, 4.7, 900.0), Spool(5.1, 5.9, -1e3))
OUT = (Spool(10.0, 9.9, 400.0), Spool(0.0, 0.1, -400.0))
BACK = (Spool(8.0, 10.1, -50.0), Spool(2.0, -0.1, 50.0))


def place(spool: Spool, time: float) -> float:
    """Where the spool is after ``time`` (s), in V."""
    off = [spool.place - spool.target, spool.speed]
    return float(spool.target + (expm(SYSTEM * time) @ off)[0])


def as_array(lands: Lands) -> npt.NDArray[np.float64]:
    """The four numbers of the openings."""
    return np.array([*lands.opening, *lands.closing])


def first_passing(spool: Spool, position: float) -> float:
    """When the spool is first at ``position`` (V), by looking at every hundredth of a radian."""
    times = np.linspace(0.0, LONGEST, 101)
    sides = [place(spool, float(time)) > position for time in times]
    after = next(k for k in range(1, 101) if sides[k] != sides[0])
    ends = float(times[after - 1]), float(times[after])
    return float(brentq(lambda time: place(spool, time) - position, *ends, xtol=1e-15))


@pytest.mark.parametrize("spool", ACROSS)
def test_a_step_ends_where_the_spool_passes_closed(spool: Spool) -> None:
    """At the root that scipy finds; the edges keep their parts up to there, and change then."""
    course = course_from(PLANT, spool)
    forward = spool.place > CLOSED
    assert course.passes
    assert course.lands.forward == forward
    assert course.horizon == pytest.approx(first_passing(spool, CLOSED), abs=1e-10)
    assert openings_after(PLANT, course, course.horizon).forward == forward
    after = course_after(PLANT, course, course.horizon, ANYWHERE)
    assert after.lands.forward != forward
    assert after.spool.place == pytest.approx(CLOSED, abs=2e-15)
    assert after.horizon > 0.0
    # A step that ends before leaves it on its side.
    halfway = course_after(PLANT, course, 0.5 * course.horizon, ANYWHERE)
    assert halfway.lands.forward == forward
    assert halfway.spool.place == pytest.approx(place(spool, 0.5 * course.horizon), abs=1e-12)


@pytest.mark.parametrize(("spool", "end"), [*zip(OUT + BACK, (10.0, 0.0) * 2, strict=True)])
def test_a_step_ends_where_the_spool_meets_the_end_of_its_stroke(spool: Spool, end: float) -> None:
    """From within and from beyond, where the openings had stopped to change; nothing is passed."""
    course = course_from(PLANT, spool)
    assert course.horizon == pytest.approx(first_passing(spool, end), abs=1e-10)
    assert not course.passes
    assert course.lands.forward == (end > CLOSED)
    after = course_after(PLANT, course, course.horizon, ANYWHERE)
    assert after.spool.place == pytest.approx(end, abs=2e-9)
    assert after.lands.forward == course.lands.forward
    # It does not stop there once more.
    assert after.horizon > 0.1 * LONGEST


@pytest.mark.parametrize("spool", [Spool(7.0, 6.0, 0.0), Spool(4.0, 4.0, 90.0)])
def test_a_step_is_at_most_a_radian_of_the_oscillation(spool: Spool) -> None:
    """Where nothing is in the way, and to eternity where the spool rests."""
    course = course_from(PLANT, spool)
    assert course.horizon == pytest.approx(LONGEST, rel=1e-12)
    assert not course.passes
    assert moving(course)
    assert step_on(PLANT, course, 1.0) == course.horizon
    assert step_on(PLANT, course, 1e-5) == 1e-5
    resting = course_from(PLANT, Spool(7.0, 7.0, 0.0))
    assert resting.horizon == math.inf
    assert not moving(resting)
    assert course_after(PLANT, resting, 1e-3, ANYWHERE) == resting


def test_a_spool_that_passes_its_target_goes_on() -> None:
    """It is where it is sent, and does not rest."""
    for speed in (200.0, -200.0):
        spool = Spool(7.0, 7.0, speed)
        course = course_from(PLANT, spool)
        assert moving(course)
        after = course_after(PLANT, course, 1e-4, ANYWHERE)
        assert after.spool.place == pytest.approx(place(spool, 1e-4), abs=1e-12)


@pytest.mark.parametrize("target", [8.0, 2.0])
@pytest.mark.parametrize("speed", [0.0, 300.0])
def test_a_spool_that_leaves_closed_is_on_the_side_it_goes_to(target: float, speed: float) -> None:
    """Within a nanovolt, on either side, thrown or drawn, or the step would have no length."""
    up = target > CLOSED
    for offset in (-5e-10, 5e-10):
        start = Spool(target, CLOSED + offset, speed if up else -speed)
        course = course_from(PLANT, start)
        assert course.lands.forward == up
        assert course.horizon == pytest.approx(LONGEST, rel=1e-12)
        assert not course.passes


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_spool_that_leaves_closed_and_comes_back_is_followed(side: float) -> None:
    """Thrown out of closed against where it is sent: on its own side until it has passed once more.

    A step reaches half of the way to that, at least.
    """
    start = CLOSED if side > 0.0 else CLOSED - 1e-15
    spool = Spool(CLOSED - side * 2.0, start, side * 500.0)
    back = brentq(lambda time: place(spool, time) - CLOSED, 1e-5, LONGEST, xtol=1e-15)
    course, gone = course_from(PLANT, spool), 0.0
    assert 0.5 * back <= course.horizon < back
    while not course.passes:
        assert course.lands.forward == (side > 0.0)
        gone += course.horizon
        course = course_after(PLANT, course, course.horizon, ANYWHERE)
    assert gone + course.horizon == pytest.approx(back, abs=1e-9)
    after = course_after(PLANT, course, course.horizon, ANYWHERE)
    assert after.lands.forward == (side < 0.0)


def test_openings_go_with_the_spool() -> None:
    """They are those of a command that would hold it where it is; beyond its stroke, of the end."""
    other = openings(PLANT, 9.0)
    for spool in (*ACROSS, *OUT, *BACK):
        course = course_from(PLANT, spool)
        assert course.lands == openings(PLANT, min(max(spool.place, 0.0), 10.0))
        assert openings_after(PLANT, course._replace(lands=other), 0.0) == other
        assert spool_of(course) == spool
        for share in (0.3, 0.9):
            voltage = min(max(place(spool, share * course.horizon), 0.0), 10.0)
            found = openings_after(PLANT, course, share * course.horizon)
            assert found.forward == course.lands.forward
            np.testing.assert_allclose(
                as_array(found), as_array(openings(PLANT, voltage)), rtol=1e-9
            )


@pytest.mark.parametrize(
    "spool", [Spool(8.0, 6.5, 600.0), Spool(8.0, 6.5, -600.0), Spool(2.0, 3.5, -300.0)]
)
def test_openings_change_as_the_spool_moves(spool: Spool) -> None:
    """What openings_beside() gives is their central difference in time, by the spool's equation."""
    course = course_from(PLANT, spool)
    beside, often = openings_beside(PLANT, course)
    found = often * (as_array(beside) - as_array(course.lands))
    near = 1e-8  # s
    later, earlier = (as_array(openings(PLANT, place(spool, t))) for t in (near, -near))
    np.testing.assert_allclose(found, (later - earlier) / (2.0 * near), rtol=1e-3)


@pytest.mark.parametrize(("end", "inward"), [(10.0, -1.0), (0.0, 1.0)])
def test_at_the_end_of_the_stroke_openings_change_on_the_way_back_only(
    end: float, inward: float
) -> None:
    """There the change is one-sided: that of what lies inside the stroke."""
    back = course_from(PLANT, Spool(5.0, end, inward * 300.0))
    beside, often = openings_beside(PLANT, back)
    found = often * (as_array(beside) - as_array(back.lands))
    inside = as_array(openings(PLANT, end + inward * 2e-6)) - as_array(openings(PLANT, end))
    np.testing.assert_allclose(found, inside / 2e-6 * 300.0, rtol=1e-3)
    out = course_from(PLANT, Spool(end, end, -inward * 300.0))
    assert openings_beside(PLANT, out)[0] == out.lands
    resting = course_from(PLANT, Spool(end, end, 0.0))
    assert openings_beside(PLANT, resting) == (resting.lands, 0.0)


def test_next_to_closed_openings_change_as_on_their_own_side() -> None:
    """Their curves have a kink there: half a microvolt before it is passed, it is not seen."""
    for sign in (1.0, -1.0):
        course = course_from(PLANT, Spool(CLOSED - sign, CLOSED + sign * 5e-7, -sign * 300.0))
        beside, often = openings_beside(PLANT, course)
        found = often * (as_array(beside) - as_array(course.lands))
        own, further = (as_array(openings(PLANT, CLOSED + sign * v)) for v in (5e-7, 25e-7))
        np.testing.assert_allclose(found, (further - own) / 2e-6 * -300.0, 0.1, 1e-17)


# A spool that is thrown on its way, and a carriage that slides.
THROWN = Spool(8.0, 6.5, 600.0)
SLIDING = Motion(0.06, 0.03, 4.2e5, 2.6e5)
UNITS = np.array([POSITION_ERROR, VELOCITY_ERROR, PRESSURE_ERROR, PRESSURE_ERROR])


def exact(direction: int, step: float) -> npt.NDArray[np.float64]:
    """The motion after ``step`` s by an explicit method of order 8, in units that count as 1."""

    def change(time: float, state: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        lands = openings(PLANT, place(THROWN, time))
        motion = Motion(*(state * UNITS).tolist())
        return np.array(rates(PLANT, lands, motion, direction)) / UNITS

    start = np.array(SLIDING if direction else SLIDING._replace(velocity=0.0)) / UNITS
    result = solve_ivp(change, (0.0, step), start, method="DOP853", rtol=1e-13, atol=1e-7)
    return np.asarray(result.y[:, -1])


def one_step(direction: int, step: float) -> tuple[Motion, float]:
    """One step of the method, sliding or at rest."""
    course = course_from(PLANT, THROWN)
    assert step < course.horizon
    if direction:
        first = sliding_rates(PLANT, SLIDING, inflows(PLANT, course, SLIDING), direction)
        return sliding_step(PLANT, course, SLIDING, direction, first, step)
    resting = SLIDING._replace(velocity=0.0)
    a, b = pressure_rates(PLANT, resting, inflows(PLANT, course, resting), 0.0)
    return sticking_step(PLANT, course, resting, a, b, step)


@pytest.mark.parametrize("direction", [0, 1])
def test_a_step_is_right_to_the_fourth_power_of_its_length(direction: int) -> None:
    """Against DOP853: half the step leaves a sixteenth, and the estimate is more than is left.

    The estimate falls with the third power: it is that of a method of order two.
    """
    errors, estimates = [], []
    for step in (8e-5, 4e-5, 2e-5):
        after, estimate = one_step(direction, step)
        apart = np.abs(np.array(after) / UNITS - exact(direction, step))
        assert estimate > apart.max()
        # At rest nothing moves but air.
        errors.append(apart if direction else apart[2:])
        estimates.append(estimate)
    order = np.log2([errors[0] / errors[1], errors[1] / errors[2]])
    assert order == pytest.approx(4.0, abs=0.6)
    order = np.log2([estimates[0] / estimates[1], estimates[1] / estimates[2]])
    assert order == pytest.approx(3.0, abs=0.4)


def test_at_rest_a_step_moves_nothing_but_air() -> None:
    """However large the difference of the pressures is."""
    after, _ = one_step(0, 1e-4)
    assert (after.position, after.velocity) == (SLIDING.position, 0.0)


def test_openings_that_stay_do_not_move() -> None:
    """Those of a valve without a drive, for good."""
    assert not moving(openings(PLANT, 7.0))
    assert spool_of(openings(PLANT, 7.0)) == ()
    assert step_on(PLANT, openings(PLANT, 7.0), 1e-3) == 1e-3


def test_a_valve_without_dynamics_has_no_steps_to_end() -> None:
    """With hysteresis alone, a command takes the spool along by the play's edge, at once."""
    plant = Plant.of(RigParameters({"valve.hysteresis": 0.02}))
    course = course_at(plant, Spool(6.0, 6.0, 0.0), 7.0)
    assert isinstance(course, Course)
    assert course.spool == Spool(6.9, 6.9, 0.0)
    assert course.horizon == math.inf


@pytest.mark.parametrize("step", [1e-4, 2e-3])
def test_the_error_in_time_is_that_of_a_parabola(step: float) -> None:
    """Of a cubic f: ∫ f − p dt, p through f(0), f'(0) and f(α h), by numpy's polynomials."""
    cubic = Polynomial([3e6, -4e8, 5e11, 6e14])  # Pa/s
    slope = float(cubic.deriv()(0.0))
    bend = (cubic(ALPHA * step) - cubic(0.0) - slope * ALPHA * step) / (ALPHA * step) ** 2
    gap = (cubic - Polynomial([float(cubic(0.0)), slope, float(bend)])).integ()
    expected = abs(float(gap(step))) / PRESSURE_ERROR

    def rate(time: float) -> Motion:
        return Motion(0.0, 0.0, float(cubic(time)), 0.0)

    # What changes is given as any part of it, and how often that part.
    change = Motion(0.0, 0.0, 0.25 * step * slope, 0.0)
    found = in_time_error(rate(0.0), change, 4.0, rate(ALPHA * step), rate(step), step)
    assert found == pytest.approx(expected, rel=1e-6)


def test_of_two_errors_the_worse_counts() -> None:
    """And none that is no number is passed over."""
    assert worse(1.0, 2.0) == worse(2.0, 1.0) == 2.0
    assert worse(0.0, 0.0) == 0.0
    assert math.isnan(worse(math.nan, 1.0))
    assert math.isnan(worse(1.0, math.nan))
