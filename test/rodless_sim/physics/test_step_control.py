# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which step is taken and tried next, where friction falls with speed and where it does not."""

import math

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.force import Force, together
from rodless_sim.physics.motion import (
    advance,
    cruises,
    may_fall,
    sliding_attempt,
    step_in_the_fall,
    sticking_attempt,
)
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

PLANT = Plant.of(RigParameters())
OPEN = openings(PLANT, 7.0)
AREA = math.pi / 4.0 * 0.025**2
STRIBECK = 1.3e-3  # m/s, of Table 2, forward


def test_friction_falls_up_to_three_stribeck_velocities() -> None:
    """There e^-9, a ten-thousandth, is left of the drop; the way does not matter."""
    for speed, answer in ((0.0, True), (2.99e-3, True), (3.01e-3, False), (1.0, False)):
        assert may_fall(speed, 1e-3) == answer
        assert may_fall(-speed, 1e-3) == answer


def test_a_step_is_a_fifth_of_the_time_constant_of_what_runs_away() -> None:
    """Growing by 1000 1/s: a step of 0.3 ms is cut to 0.2 ms; 0.24 ms, or past the fall, is not."""
    assert step_in_the_fall(1e-4, 1e-4, 1000.0, 1e-3, 3e-4) == pytest.approx(2e-4, rel=1e-12)
    assert step_in_the_fall(1e-4, 1e-4, 1000.0, 1e-3, 2.4e-4) == 2.4e-4
    assert step_in_the_fall(4e-3, 4e-3, 1000.0, 1e-3, 3e-4) == 3e-4
    assert step_in_the_fall(1e-4, 1e-4, -1000.0, 1e-3, 3e-4) == 3e-4


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_in_the_fall_changes_the_speed_by_half_a_stribeck_velocity(sign: float) -> None:
    """From 1.2 by 0.4 of one it may; by 0.8 it is cut in half, to 0.4 again."""
    before = 1.2e-3
    assert step_in_the_fall(before, before + sign * 0.4e-3, 0.0, 1e-3, 1e-4) == 1e-4
    found = step_in_the_fall(before, before + sign * 0.8e-3, 0.0, 1e-3, 1e-4)
    assert found == pytest.approx(0.5e-4, rel=1e-12)


def test_a_step_from_above_goes_to_the_edge_of_the_fall_first() -> None:
    """The edge is at 2.5: from 4 to 1 the first part is 4 - 0.96 · 2.5 = 1.6 of 3."""
    found = step_in_the_fall(4e-3, 1e-3, 0.0, 1e-3, 1e-4)
    assert found == pytest.approx(1e-4 * 1.6 / 3.0, rel=1e-12)
    # Never more than nine tenths, or the same step would be tried again.
    assert step_in_the_fall(10e-3, 2.45e-3, 0.0, 1e-3, 1e-4) == pytest.approx(0.9e-4, rel=1e-12)
    # Right above the edge, at least as far as inside.
    found = step_in_the_fall(2.51e-3, 1.51e-3, 0.0, 1e-3, 1e-4)
    assert found == pytest.approx(0.4e-4, rel=1e-12)


def test_a_step_outside_the_fall_is_left_alone() -> None:
    """Both ends above 2.5 Stribeck velocities, however large the change."""
    assert step_in_the_fall(2.6e-3, 0.3, 0.0, 1e-3, 1e-4) == 1e-4
    assert step_in_the_fall(0.3, 2.6e-3, 0.0, 1e-3, 1e-4) == 1e-4


def test_a_carriage_cruises_where_it_can_neither_stop_nor_fall() -> None:
    """Both speeds above three Stribeck velocities, and a rate that cannot use them up."""
    assert cruises(0.1, 50.0, 0.2, 1e-3, 1e-3)
    assert cruises(0.1, -99.0, 0.2, 1e-3, 1e-3)
    assert not cruises(0.1, -101.0, 0.2, 1e-3, 1e-3)
    assert not cruises(0.1, 101.0, 0.2, 1e-3, 1e-3)
    assert not cruises(2.9e-3, 0.0, 0.2, 1e-3, 1e-3)
    assert not cruises(0.2, 0.0, 2.9e-3, 1e-3, 1e-3)
    assert cruises(3.1e-3, 0.0, 3.1e-3, 1e-3, 1e-3)


def sliding(step: float, speed: float, tolerance: float = 1.0) -> object:
    """Try a step of a carriage that slides forward in the middle of its stroke."""
    state = Motion(0.1, speed, 3.8e5, 3e5)
    return sliding_attempt(PLANT, OPEN, state, inflows(PLANT, OPEN, state), 1, step, tolerance)


def test_a_step_with_too_large_an_error_is_not_taken() -> None:
    """The state stays, no time passes, and the next step to try is shorter; a finer tolerance too.

    Refused are a step that is too long and one that a finer tolerance makes so.
    """
    taken = sliding(2e-5, 0.03)
    assert taken.elapsed == 2e-5  # type: ignore[attr-defined]
    assert taken.state.position > 0.1  # type: ignore[attr-defined]
    for step, tolerance in ((1e-3, 1e-9), (2e-5, 1e-12)):
        refused = sliding(step, 0.03, tolerance)
        assert refused[:3] == (Motion(0.1, 0.03, 3.8e5, 3e5), 1, 0.0)  # type: ignore[index]
        assert refused.step <= 0.2 * step  # type: ignore[attr-defined]


def test_the_next_step_follows_the_error_and_the_tolerance() -> None:
    """A tolerance eight times as fine makes the next step half as long."""
    coarse, fine = sliding(1.2e-5, 0.03), sliding(1.2e-5, 0.03, 0.125)
    assert coarse.elapsed == fine.elapsed == 1.2e-5  # type: ignore[attr-defined]
    assert coarse.step / fine.step == pytest.approx(2.0, rel=1e-9)  # type: ignore[attr-defined]


def test_no_tolerance_lets_a_step_jump_the_fall() -> None:
    """However coarse, a step that changes the speed by Stribeck velocities is made shorter."""
    attempt = sliding(2e-4, 1.2 * STRIBECK, 1e9)
    assert attempt.elapsed == 0.0  # type: ignore[attr-defined]
    assert 1e-6 < attempt.step < 2e-4  # type: ignore[attr-defined]
    # A shorter one is taken.
    assert sliding(1e-5, 1.2 * STRIBECK, 1e9).elapsed == 1e-5  # type: ignore[attr-defined]


def test_a_carriage_that_stops_within_a_step_ends_it_there() -> None:
    """Thrown at 0.1 mm/s against even pressures, it rests after 100 µm/s / 29 m/s² = 3.4 µs."""
    state = Motion(0.1, 1e-4, 3e5, 3e5)
    closed = openings(PLANT, 5.08)
    flows = inflows(PLANT, closed, state)
    attempt = sliding_attempt(PLANT, closed, state, flows, 1, 2e-5, 1e9)
    assert attempt.elapsed == pytest.approx(1e-4 / 29.0, rel=0.02)
    assert (attempt.direction, attempt.state.velocity) == (0, 0.0)


@pytest.mark.parametrize(("voltage", "push"), [(7.0, 28.9), (3.0, -35.9)])
def test_a_carriage_at_rest_waits_until_it_breaks_away(voltage: float, push: float) -> None:
    """A step that ends within F_s is taken whole; one that ends beyond ends where F_s is passed."""
    lands = openings(PLANT, voltage)
    waiting = Motion(0.1, 0.0, 3.6e5 + 0.5 * push / AREA, 3.6e5)
    attempt = sticking_attempt(PLANT, lands, waiting, inflows(PLANT, lands, waiting), 1e-5, 1.0)
    assert (attempt.direction, attempt.elapsed) == (0, 1e-5)
    assert attempt.state.pressure_a != waiting.pressure_a
    pushed = Motion(0.1, 0.0, 3.6e5 + push / AREA, 3.6e5)
    attempt = sticking_attempt(PLANT, lands, pushed, inflows(PLANT, lands, pushed), 1e-4, 1.0)
    assert attempt.direction == (1 if push > 0.0 else -1)
    assert 0.0 < attempt.elapsed < 1e-4
    limit = 29.0 if push > 0.0 else -36.0
    force = AREA * (attempt.state.pressure_a - attempt.state.pressure_b)
    assert force == pytest.approx(limit, abs=1e-6)
    refused = sticking_attempt(PLANT, lands, waiting, inflows(PLANT, lands, waiting), 1e-3, 1e-9)
    assert refused[:3] == (waiting, 0, 0.0)


@pytest.mark.parametrize(("voltage", "push"), [(3.5, -35.0), (6.0, 28.0)])
def test_a_period_in_parts_is_the_whole_period(voltage: float, push: float) -> None:
    """20 ms at once or in twenty calls: the same motion within 10 nm, breakaway included."""
    lands = openings(PLANT, voltage)
    start = Motion(0.1, 0.0, 3.6e5 + push / AREA, 3.6e5)
    whole, fault = advance(PLANT, lands, start, 0.02, 1.0)
    parts = start
    for _ in range(20):
        parts, _ = advance(PLANT, lands, parts, 1e-3, 1.0)
    assert fault == 0
    assert (whole.position - 0.1) * (voltage - 5.08) > 1e-6
    assert whole.position == pytest.approx(parts.position, abs=1e-8)
    assert whole.pressure_a == pytest.approx(parts.pressure_a, abs=20.0)
    assert whole.pressure_b == pytest.approx(parts.pressure_b, abs=20.0)


def test_two_forces_add_up_with_their_derivatives() -> None:
    """Each of the three for itself."""
    assert together(Force(1.0, 20.0, 300.0), Force(4.0, 50.0, 600.0)) == (5.0, 70.0, 900.0)
