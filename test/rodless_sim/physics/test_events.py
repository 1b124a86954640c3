# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where within a step the carriage stops, breaks away or strikes a cap, by other root finders."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from rodless_sim import RigParameters
from rodless_sim.physics.equations import inflows, net_force, pressure_rates, sliding_rates
from rodless_sim.physics.events import (
    Bracket,
    Event,
    breakaway,
    earlier_end,
    gap_ahead,
    guess,
    later_start,
    narrowed,
    sliding_event,
    stops_within,
)
from rodless_sim.physics.integrator import sliding_step, sticking_step
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

PLANT = Plant.of(RigParameters({"end_stop.restitution": 0.4}))
AREA = math.pi / 4.0 * 0.025**2
CLOSED = openings(PLANT, 5.08)


def test_a_guess_is_where_a_straight_line_is_zero() -> None:
    """From 3 at 2 s to -1 at 4 s: 3.5 s. A level line and one that is zero at once are told."""
    assert guess(Bracket(2.0, 3.0, 4.0, -1.0)) == pytest.approx(3.5, rel=1e-15)
    assert guess(Bracket(4.0, -1.0, 2.0, 3.0)) == pytest.approx(3.5, rel=1e-15)
    assert guess(Bracket(2.0, 1.0, 4.0, 1.0)) == 4.0
    # Never no step at all: the shortest is 1e-12 of the longer end.
    assert guess(Bracket(0.0, 0.0, 4.0, -1.0)) == pytest.approx(4e-12, rel=1e-12, abs=0.0)
    assert guess(Bracket(4.0, -1.0, 0.0, 0.0)) == pytest.approx(4e-12, rel=1e-12, abs=0.0)


def test_a_bracket_keeps_the_change_of_sign() -> None:
    """The newest instant is the end; the value of an end that stays is halved (Illinois)."""
    bracket = Bracket(1.0, 8.0, 3.0, -2.0)
    assert narrowed(bracket, 2.0, -1.0) == (1.0, 4.0, 2.0, -1.0)
    assert narrowed(bracket, 2.0, 5.0) == (3.0, -2.0, 2.0, 5.0)
    assert narrowed(bracket, 2.0, 0.0) == (1.0, 4.0, 2.0, 0.0)
    assert later_start(bracket, 2.0, 5.0) == (2.0, 5.0, 3.0, -2.0)
    assert earlier_end(bracket, 2.0, -1.0) == (1.0, 8.0, 2.0, -1.0)


def test_the_gap_is_the_way_to_the_cap_ahead() -> None:
    """At 50 mm of 200: 150 mm ahead forward, 50 mm in reverse."""
    state = Motion(0.05, 0.0, 1e5, 1e5)
    assert gap_ahead(PLANT, state, 1) == pytest.approx(0.15, rel=1e-15)
    assert gap_ahead(PLANT, state, -1) == 0.05


def test_a_speed_falls_below_zero_where_its_cubic_does() -> None:
    """Random speeds and rates, against the least value of scipy's curve through them."""
    generator = np.random.default_rng(11)
    answers = []
    for _ in range(600):
        speed, after = generator.uniform(0.0, 1.0, 2)
        rate, rate_after = generator.uniform(-20.0, 20.0, 2)
        step = float(generator.uniform(0.01, 1.0))
        curve = CubicHermiteSpline([0.0, step], [speed, after], [rate, rate_after])
        turns = [float(x) for x in curve.derivative().roots(extrapolate=False)]
        lowest = min((float(curve(x)) for x in turns), default=1.0)
        if abs(lowest) > 1e-9:
            answers.append(stops_within(speed, rate, after, rate_after, step))
            assert answers[-1] == (lowest < 0.0)
    assert 60 < sum(answers) < len(answers) - 60


def test_plain_cases_of_a_stop() -> None:
    """At or below zero it has stopped; from rest it has not; even motion and rest do not."""
    assert stops_within(0.1, -10.0, 0.0, -10.0, 0.01)
    assert stops_within(0.0, 1.0, -1e-9, 1.0, 0.01)
    assert not stops_within(0.0, -50.0, 0.1, 50.0, 0.01)
    assert not stops_within(0.1, 0.0, 0.1, 0.0, 0.01)
    assert not stops_within(0.1, 10.0, 0.2, 10.0, 0.01)


def event_of(
    state: Motion, direction: int, step: float, stops: bool, plant: Plant = PLANT
) -> Event:
    """Return what the package finds in one step with the valve closed."""
    first = sliding_rates(plant, state, inflows(plant, CLOSED, state), direction)
    after, _ = sliding_step(plant, CLOSED, state, direction, first, step)
    return sliding_event(plant, CLOSED, state, direction, first, step, after, stops)


def place(state: Motion, direction: int, plant: Plant = PLANT) -> Callable[[float], Motion]:
    """Return the state after a step, as a function of its length."""
    first = sliding_rates(plant, state, inflows(plant, CLOSED, state), direction)
    return lambda time: sliding_step(plant, CLOSED, state, direction, first, time)[0]


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("step", [2e-4, 1e-3])
def test_a_stop_is_where_the_speed_of_the_step_is_zero(direction: int, step: float) -> None:
    """A thrown carriage against even pressures: the instant is that of Brent's method.

    The long step ends with the carriage moving on forward: the stop lies in between.
    """
    state = Motion(0.1, direction * 2e-3, 3e5, 3e5)
    event = event_of(state, direction, step, True)
    along = place(state, direction)
    assert (direction * along(step).velocity > 0.0) == (step == 1e-3)
    time = brentq(lambda t: along(t).velocity, 1e-9, 1.25e-4, xtol=1e-16)
    assert event.elapsed == pytest.approx(time, rel=1e-9)
    assert event.state.velocity == 0.0
    assert event.direction == 0
    assert event.state.position == pytest.approx(along(time).position, abs=1e-14)
    assert event.state.pressure_a == pytest.approx(along(time).pressure_a, rel=1e-12)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_carriage_that_is_pushed_back_goes_on_the_other_way(direction: int) -> None:
    """Stopped by more than it can withstand at rest, it slides back at once."""
    push = direction * 60.0 / AREA
    event = event_of(Motion(0.1, direction * 2e-3, 3e5, 3e5 + push), direction, 1e-3, True)
    assert 0.0 < event.elapsed < 1e-3
    assert (event.state.velocity, event.direction) == (0.0, -direction)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_carriage_released_from_rest_against_its_direction_stays(direction: int) -> None:
    """Without any speed, nothing but friction and a push back: it rests at once, nothing passes."""
    push = direction * 60.0 / AREA
    state = Motion(0.1, 0.0, 3e5, 3e5 + push)
    event = event_of(state, direction, 1e-4, True)
    assert event == Event(state, 0, 0.0)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_dash_from_rest_that_ends_within_the_step(direction: int) -> None:
    """Pushed off by a little more than friction takes, it stops again; the start is no stop.

    A long step from rest with stiff air ends below zero speed, though it starts forward.
    """
    rig = Plant.of(
        RigParameters(
            {
                f"friction.{side}.{name}": value
                for side in ("forward", "reverse")
                for name, value in (("static", 5.0), ("coulomb", 5.0), ("viscous", 0.0))
            }
        )
    )
    push = direction * 6.0 / AREA
    state = Motion(0.1, 0.0, 3e5 + push, 3e5)
    along = place(state, direction, rig)
    assert direction * along(1e-3).velocity > 0.0
    step = next(t for t in np.linspace(0.01, 0.2, 200) if direction * along(t).velocity < 0.0)
    event = event_of(state, direction, float(step), True, rig)
    time = brentq(lambda t: along(t).velocity, 1e-3, step, xtol=1e-16)
    assert event.elapsed == pytest.approx(time, rel=1e-6)
    assert event.state.velocity == 0.0


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("speed", [0.3, 2.0])
def test_an_impact_is_where_the_gap_of_the_step_closes(direction: int, speed: float) -> None:
    """The instant is that of Brent's method; 0.4 of the speed is left, the other way."""
    start = 0.2 - 2e-5 if direction > 0 else 2e-5
    state = Motion(start, direction * speed, 3e5, 3e5)
    event = event_of(state, direction, 1e-3, False)
    along = place(state, direction)
    cap = 0.2 if direction > 0 else 0.0
    time = brentq(lambda t: along(t).position - cap, 1e-9, 1e-3, xtol=1e-17)
    assert event.elapsed == pytest.approx(time, rel=1e-9)
    assert event.state.position == cap
    assert event.state.velocity == pytest.approx(-0.4 * along(time).velocity, rel=1e-9)
    assert event.direction == -direction
    assert event.state.pressure_b == pytest.approx(along(time).pressure_b, rel=1e-10)


def test_an_impact_at_the_very_start_takes_no_time() -> None:
    """A carriage at the cap that still moves into it strikes it at once."""
    event = event_of(Motion(0.2, 0.3, 3e5, 3e5), 1, 1e-3, False)
    assert event.elapsed == 0.0
    assert event.state == pytest.approx((0.2, -0.12, 3e5, 3e5), rel=1e-12)


def test_a_stop_before_the_cap_is_no_impact() -> None:
    """A carriage that friction stops 1 nm before the cap does not strike it."""
    state = Motion(0.1, 2e-3, 3e5, 3e5)
    reach = event_of(state, 1, 1e-3, True).state.position - 0.1
    near = Motion(0.2 - reach - 1e-9, 2e-3, 3e5, 3e5)
    event = event_of(near, 1, 1e-3, True)
    assert event.state.position < 0.2
    assert event.direction == 0


def test_no_event_is_the_end_of_the_step() -> None:
    """What goes on sliding far from a cap is left where the step has led."""
    state = Motion(0.1, 0.5, 3e5, 3e5)
    for stops in (False, True):
        event = event_of(state, 1, 1e-5, stops)
        assert event == Event(place(state, 1)(1e-5), 1, 1e-5)


@pytest.mark.parametrize(("voltage", "limit"), [(7.0, 29.0), (3.0, -36.0)])
def test_breakaway_is_where_the_push_passes_the_limit(voltage: float, limit: float) -> None:
    """The instant is that of Brent's method, within 1e-8 N of the limit."""
    lands = openings(PLANT, voltage)
    state = Motion(0.1, 0.0, 3.6e5 + (limit - math.copysign(0.5, limit)) / AREA, 3.6e5)
    a, b = pressure_rates(PLANT, state, inflows(PLANT, lands, state), 0.0)

    def rested(time: float) -> Motion:
        return sticking_step(PLANT, lands, state, a, b, time)[0]

    step = 1e-3
    assert abs(net_force(PLANT, rested(step))) > abs(limit)
    event = breakaway(PLANT, lands, state, a, b, step, rested(step))
    time = brentq(lambda t: net_force(PLANT, rested(t)) - limit, 1e-9, step, xtol=1e-17)
    assert event.elapsed == pytest.approx(time, rel=1e-7)
    assert net_force(PLANT, event.state) == pytest.approx(limit, abs=2e-8)
    assert event.direction == (1 if limit > 0.0 else -1)
    assert (event.state.position, event.state.velocity) == (0.1, 0.0)


@pytest.mark.parametrize(("voltage", "limit"), [(7.0, 29.0), (3.0, -36.0)])
def test_a_push_at_the_limit_that_grows_breaks_away_at_once(voltage: float, limit: float) -> None:
    """Starting 1 mN past the limit, it is found within a millionth of the step."""
    lands = openings(PLANT, voltage)
    state = Motion(0.1, 0.0, 3.6e5 + (limit + math.copysign(1e-3, limit)) / AREA, 3.6e5)
    a, b = pressure_rates(PLANT, state, inflows(PLANT, lands, state), 0.0)
    after, _ = sticking_step(PLANT, lands, state, a, b, 1e-3)
    event = breakaway(PLANT, lands, state, a, b, 1e-3, after)
    assert 0.0 < event.elapsed < 2e-9
    assert event.direction == (1 if limit > 0.0 else -1)
