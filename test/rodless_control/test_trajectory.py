# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Trajectories through waypoints: interpolated as joint_trajectory_controller does, and refused."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.interpolate import BPoly, PPoly

from rodless_control import ControllerParameters, ParameterError
from rodless_control.references import Moving, Reference
from rodless_control.setpoint import SetpointFollower
from rodless_control.trajectory import Trajectory, Waypoint

TIMES = np.linspace(0.0, 3.0, 601)[:-1]
NO_LIMITS = (-math.inf, math.inf)


def derivatives(point: Waypoint, order: int) -> list[float]:
    """Position and the first derivatives of a waypoint."""
    return [point.position, point.velocity, point.acceleration][:order]  # type: ignore[list-item]


def hermite(points: list[Waypoint], order: int) -> BPoly:
    """Scipy's own polynomials with these derivatives at the waypoints."""
    return BPoly.from_derivatives(
        [point.time for point in points], [derivatives(point, order) for point in points]
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_segments_are_hermite_polynomials(order: int) -> None:
    """Linear, cubic, quintic: positions and velocities are those that scipy finds, to 1e-12."""
    generator = np.random.default_rng(order)
    for _ in range(20):
        times = np.concatenate([[0.0], np.cumsum(generator.uniform(0.2, 1.0, 3)), [3.0]])
        values = generator.uniform(-0.2, 0.2, (5, 3))
        values[-1, 1] = 0.0
        given = [
            Waypoint(t, *[v if k < order else None for k, v in enumerate(row)])
            for t, row in zip(times.tolist(), values.tolist(), strict=True)
        ]
        expected = hermite(given, order)
        found = np.array([Trajectory(given).sample(float(time)) for time in TIMES])
        np.testing.assert_allclose(found[:, 0], expected(TIMES), atol=1e-12)
        np.testing.assert_allclose(found[:, 1], expected.derivative()(TIMES), atol=1e-10)


def test_a_segment_takes_what_both_its_ends_have() -> None:
    """Between a point with a velocity and one without, the way is straight."""
    way = Trajectory([Waypoint(0.0, 0.0, 0.3), Waypoint(1.0, 0.1), Waypoint(2.0, 0.1, 0.0)])
    assert way.sample(0.5) == (pytest.approx(0.05), pytest.approx(0.1))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_hold_is_at_rest(order: int) -> None:
    """Between two points at one place position and speed are exact: laws park by a speed of 0."""
    generator = np.random.default_rng(order)
    for position in generator.uniform(0.0, 0.2, 500).round(3).tolist():
        rest = [position, 0.0, 0.0][:order]
        way = Trajectory([Waypoint(0.0, 0.1), Waypoint(1.3, *rest), Waypoint(7.1, *rest)], 1.7e9)
        for later in (1.3, 2.0, 3.7, 7.0, 8.0):
            assert way.sample(1.7e9 + later + 1e-6) == (position, 0.0)


@pytest.mark.parametrize("start", [None, 1.7e9])
def test_what_was_taken_can_be_sampled_whatever_it_is_joined_to(start: float | None) -> None:
    """The way to its first point is made later, from wherever the reference is, and how fast."""
    quick = [Waypoint(1e-9, 0.2), Waypoint(2e-9, 0.0), Waypoint(1.0, 0.1, 0.0, 1e9)]
    hard = [Waypoint(9.0, 0.1, 0.0, 1e-3), Waypoint(10.0, 0.1, 0.0)]
    found: Reference = Moving(0.1, 1e6, 1e12)
    for k in range(40):
        time = 1.7e9 + 0.25e-6 * k
        assert all(map(math.isfinite, found.sample(time)))
        given = Trajectory(quick if k % 2 else hard)
        found = given.joined(found, time, time if start is None else start, NO_LIMITS)


@pytest.mark.parametrize("start", [math.nan, math.inf, 1e300])
def test_a_start_that_is_no_time_is_refused(start: float) -> None:
    """Nothing could be joined to it."""
    with pytest.raises(ParameterError, match=r"its start, .* s, is no time"):
        moving_follower().receive_trajectory([Waypoint(1.0, 0.1)], start)


def test_it_rests_before_its_first_and_after_its_last_point() -> None:
    """The last position is held, whatever the segment's slope was."""
    way = Trajectory([Waypoint(1.0, 0.02), Waypoint(2.0, 0.05)])
    assert way.sample(0.9) == (0.02, 0.0)
    assert way.sample(2.0) == (0.05, 0.0)
    assert way.sample(99.0) == (0.05, 0.0)


def test_extremes_are_those_of_the_curve() -> None:
    """A cubic swings out beyond its points; the extremes are what fine sampling finds."""
    points = [Waypoint(0.0, 0.05, -0.2), Waypoint(1.0, 0.06, 0.3), Waypoint(3.0, 0.1, 0.0)]
    way = Trajectory(points)
    positions = [way.sample(float(time))[0] for time in np.linspace(0.0, 3.0, 30_001)]
    low, high = way.extremes()
    assert (low, high) == (
        pytest.approx(min(positions), abs=1e-9),
        pytest.approx(max(positions), abs=1e-9),
    )
    assert low < 0.05
    assert high > 0.1


@pytest.mark.parametrize("order", [1, 2, 3])
def test_extremes_of_many_segments_are_those_of_the_curve(order: int) -> None:
    """Whatever a segment is, and wherever it swings out: as scipy's roots of its slope have it."""
    generator = np.random.default_rng(order)
    for _ in range(50):
        values = generator.normal(0.0, [0.1, 0.5, 2.0], (8, 3))
        values[-1, 1] = 0.0
        given = [
            Waypoint(t, *[v if k < order else None for k, v in enumerate(row)])
            for t, row in enumerate(values.tolist())
        ]
        curve = hermite(given, order)
        turns = PPoly.from_bernstein_basis(curve.derivative()).roots(False, False)
        reached = curve(np.concatenate([np.arange(8.0), turns[np.isfinite(turns)]]))
        expected = (float(reached.min()), float(reached.max()))
        assert Trajectory(given).extremes() == pytest.approx(expected, abs=2e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_what_is_ahead_is_what_is_left_of_the_curve(order: int) -> None:
    """From any time on, as scipy's own curve is sampled finely."""
    generator = np.random.default_rng(10 + order)
    values = generator.normal(0.0, [0.1, 0.5, 2.0], (5, 3))
    values[-1, 1] = 0.0
    given = [
        Waypoint(t, *[v if k < order else None for k, v in enumerate(row)])
        for t, row in enumerate(values.tolist())
    ]
    way, curve = Trajectory(given, 100.0), hermite(given, order)
    for since in (-1.0, 0.0, 0.3, 1.0, 2.9, 3.999, 4.0, 7.0):
        begin = min(max(since, 0.0), 4.0)
        times = np.concatenate([np.linspace(begin, 4.0, 100_001), np.arange(np.ceil(begin), 5.0)])
        left = curve(times)
        expected = (float(left.min()), float(left.max()))
        assert way.ahead(100.0 + since) == pytest.approx(expected, abs=1e-8)


def test_a_point_at_a_limit_is_within_it() -> None:
    """Wherever the way comes from: 58 mm, reached by adding a distance, is now and then less."""
    for k in range(58, 200):
        place = k / 1000.0
        found = SetpointFollower(ControllerParameters({"reference.minimum": 0.058}))
        found.sample(0.0, place)
        points = [Waypoint(1.0, place), Waypoint(2.0, 0.058), Waypoint(3.0, place)]
        found.receive_trajectory(points)
        found.sample(0.0, 0.0)
        assert found.sample(2.0, 0.0).position == 0.058


def test_a_long_trajectory_costs_little_more_than_its_points() -> None:
    """A controller that takes 20,000 points is soon back: of a polynomial each it made seconds.

    Compared in one run with as many polynomials of numpy's, which are no more than made; the best
    of three tries, in time of this thread: others may be at work beside it.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    given = [
        Waypoint(*row, 0.0)
        for row in np.stack([angles, 0.05 * np.cos(angles), -0.05 * np.sin(angles)]).T.tolist()
    ]
    found: list[tuple[float, float]] = []

    def polynomials() -> None:
        for point in given:
            Polynomial([point.position, 0.0, 0.0]).deriv()

    def least(action: Callable[[], object]) -> float:
        times = []
        for _ in range(3):
            begin = time.thread_time()
            action()
            times.append(time.thread_time() - begin)
        return min(times)

    taken = least(lambda: found.append(Trajectory(given).extremes()))
    assert taken < 0.8 * least(polynomials)
    assert found[0] == (pytest.approx(-0.05), 0.05)


def test_it_may_end_with_the_least_speed_of_the_standard_controller() -> None:
    """That of single precision at 1 m/s, 119 nm/s; no more."""
    least = float(np.finfo(np.float32).eps)
    for velocity in (least, -least):
        Trajectory([Waypoint(0.0, 0.0), Waypoint(1.0, 0.1, velocity)])
        with pytest.raises(ValueError, match="the last point has velocity"):
            Trajectory([Waypoint(0.0, 0.0), Waypoint(1.0, 0.1, 1.01 * velocity)])


BAD = [
    ([], "no points"),
    ([Waypoint(0.0, 0.1), Waypoint(0.0, 0.1)], "point 2: its time, 0 s, is not after"),
    ([Waypoint(1.0, 0.1), Waypoint(0.5, 0.1)], "point 2: its time, 0.5 s, is not after"),
    (
        [*(Waypoint(float(time), 0.1) for time in range(3)), Waypoint(1.5, 0.1)],
        "point 4: its time, 1.5 s, is not after that of the point before, 2 s",
    ),
    ([Waypoint(1.0, math.nan)], "point 1: position nan is not finite"),
    ([Waypoint(1.0, 0.1, math.inf)], "point 1: velocity inf is not finite"),
    ([Waypoint(1.0, 0.1, 0.01)], "the last point has velocity 0.01 m/s, must be 0"),
    ([Waypoint(1.0, 0.1, 1e307), Waypoint(2.0, 0.1, 0.0)], "point 1: velocity 1e+307 is beyond 1e"),
    ([Waypoint(100.0, 0.1, 0.0, 1e306)], "point 1: acceleration 1e+306 is beyond 1e+09"),
    ([Waypoint(1e13, 0.1)], "point 1: time 10000000000000.0 is beyond 1e+12"),
    (
        [Waypoint(0.0, 0.0), Waypoint(5e-324, 0.1)],
        "point 2: its time, 4.94066e-324 s, is not after",
    ),
    ([Waypoint(-0.1, 0.1)], "point 1: time -0.1 s is before its start"),
    ([Waypoint(1.0, 0.21)], "0.21 m refused, must be from reference.minimum"),
    ([Waypoint(1.0, -0.01), Waypoint(2.0, 0.1)], "reference.minimum"),
    ([Waypoint(0.0, 0.19, 0.2), Waypoint(1.0, 0.19, 0.0)], "reference.maximum"),
]


@pytest.mark.parametrize(("points", "line"), BAD, ids=[line for _, line in BAD])
def test_a_bad_trajectory_is_refused_in_one_line_and_changes_nothing(
    points: list[Waypoint], line: str
) -> None:
    """The way in force goes on."""
    found = moving_follower()
    with pytest.raises(ParameterError, match="trajectory: ") as refusal:
        found.receive_trajectory(points)
    assert line in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert found.sample(0.5, 0.0) == (pytest.approx(0.05), pytest.approx(0.1))


def moving_follower(kind: str = "setpoint") -> SetpointFollower:
    """Return a follower on its way from 0 to 0.1 m, from time 0 to 1 s."""
    found = SetpointFollower(ControllerParameters({"reference.type": kind}))
    found.receive_trajectory([Waypoint(1.0, 0.1)])
    found.sample(0.0, 0.0)
    return found


def test_a_trajectory_begins_where_the_reference_is() -> None:
    """Another in mid-way takes over without a jump in position, nor in velocity if it has it."""
    found = moving_follower()
    before = found.sample(0.5, 0.0)
    found.receive_trajectory([Waypoint(1.0, 0.02, 0.0), Waypoint(2.0, 0.1, 0.0)])
    assert found.sample(0.5, 0.0) == pytest.approx(before)
    times = np.linspace(0.5, 3.0, 2501)
    positions = [found.sample(float(time), 0.0)[0] for time in times]
    assert max(abs(b - a) for a, b in pairwise(positions)) < 0.2e-3
    assert positions[1000] == pytest.approx(0.02)
    assert positions[-1] == 0.1


def test_a_stamp_says_when_it_starts() -> None:
    """Times count from it; what lies behind is left out; what is over is refused.

    The reference goes from where it is, 0.1 m, to the point ahead. It does not jump onto the line
    from the point that is left out: a carriage would be driven there at full air.
    """
    found = moving_follower()
    found.sample(2.0, 0.0)
    found.receive_trajectory([Waypoint(0.0, 0.0), Waypoint(2.0, 0.04)], start=1.5)
    assert found.sample(2.5, 0.0) == (pytest.approx(0.1), pytest.approx(-0.06))
    found.receive_trajectory([Waypoint(1.0, 0.1)], start=4.0)
    assert found.sample(3.0, 0.0)[0] == pytest.approx(0.07)
    assert found.sample(4.0, 0.0)[0] == pytest.approx(0.085)
    assert found.sample(5.0, 0.0) == (0.1, 0.0)
    with pytest.raises(ParameterError, match=r"it ended at 4\.9 s, now it is 5 s"):
        found.receive_trajectory([Waypoint(0.9, 0.1)], start=4.0)


def test_a_stamp_in_the_past_makes_no_jump() -> None:
    """A reference at 195 mm goes to the point ahead, in 3 s, and not over the one 1 s behind."""
    found = SetpointFollower(ControllerParameters({}))
    found.receive(0.195)
    found.sample(10.0, 0.0)
    found.receive_trajectory([Waypoint(1.0, 0.02), Waypoint(5.0, 0.1)], start=8.0)
    times = np.linspace(10.0, 13.5, 351)
    positions = [found.sample(time, 0.0)[0] for time in times.tolist()]
    np.testing.assert_allclose(positions, np.interp(times, [10.0, 13.0], [0.195, 0.1]), atol=1e-12)


SWINGING = [Waypoint(1.0, 0.19, 1.0), Waypoint(1.02, 0.195, 0.0)]


def test_the_way_to_the_first_point_keeps_within_the_travel() -> None:
    """To arrive so fast the reference would swing back to -30 mm: refused in one line."""
    found = SetpointFollower(ControllerParameters({}))
    found.sample(0.0, 0.0)
    found.receive(0.001)
    before = found.sample(0.1, 0.0)
    way = hermite([Waypoint(0.0, 0.001, 0.0), *SWINGING[:1]], 2)
    least = float(way(np.linspace(0.0, 1.0, 10_001)).min())
    with pytest.raises(ParameterError) as refusal:
        found.receive_trajectory(SWINGING)
    assert str(refusal.value) == (
        f"trajectory: refused, from 0.001 m, where the reference is, it would reach {least:g} m "
        "before its first point ahead, beyond reference.minimum (0 m); give that point another "
        "time or velocity"
    )
    assert found.sample(0.2, 0.0) == before
    assert found.target == 0.001
    # With less time there is no swing.
    found.receive_trajectory([replace(each, time=each.time - 0.6) for each in SWINGING])


@pytest.mark.parametrize("velocity", [0.3, -0.3])
def test_a_moving_reference_must_find_room_to_turn(velocity: float) -> None:
    """A reference that comes in at 0.3 m/s close to an end would swing over it before it turns."""
    found = SetpointFollower(ControllerParameters({}))
    found.receive_command(0.1 + velocity * 0.3, velocity)
    found.sample(0.0, 0.0)
    limit = "maximum" if velocity > 0.0 else "minimum"
    with pytest.raises(ParameterError, match=rf"before its first .* reference\.{limit}"):
        found.receive_trajectory([Waypoint(1.0, 0.1, 0.0)])
    found.receive_trajectory([Waypoint(0.1, 0.1, 0.0)])


def test_what_is_not_known_yet_waits_at_the_end_of_the_travel() -> None:
    """Before the first sample nobody knows where the carriage is: the reference keeps within."""
    found = SetpointFollower(ControllerParameters({}))
    found.receive_trajectory(SWINGING)
    times = np.linspace(0.0, 1.2, 1201)
    track = [found.sample(time, 0.001) for time in times.tolist()]
    way = hermite([Waypoint(0.0, 0.001, 0.0), *SWINGING], 2)
    expected = np.where(times < 1.02, way(times), 0.195).clip(0.0, 0.2)
    np.testing.assert_allclose([point.position for point in track], expected, atol=1e-12)
    assert {point.velocity for point in track if point.position == 0.0} == {0.0}


def test_a_trajectory_leads_back_from_outside_the_travel() -> None:
    """A carriage that is found beyond its end is led in, and never further out."""
    found = SetpointFollower(ControllerParameters({}))
    assert found.sample(0.0, -0.0011).position == -0.0011
    with pytest.raises(ParameterError, match="before its first point ahead"):
        found.receive_trajectory([Waypoint(1.0, 0.19, 1.0), Waypoint(1.02, 0.195, 0.0)])
    found.receive_trajectory([Waypoint(1.0, 0.05, 0.0)])
    track = [found.sample(0.01 * k, 0.0).position for k in range(120)]
    assert track == sorted(track)
    assert (track[0], track[-1]) == (-0.0011, 0.05)


@pytest.mark.parametrize("motion", [(), (0.04,), (0.04, -0.1), None], ids=str)
def test_a_trajectory_that_is_sent_again_stays_the_same(motion: tuple[float, ...] | None) -> None:
    """Whatever its segments are, and wherever on the way: the path is that of one sent once.

    None stands for points of which every second has a velocity: the way between is straight.
    """
    places = [0.05, 0.08, 0.1, 0.06]
    given = [
        Waypoint(0.7 * k, place, *(motion if motion is not None else (0.03, 0.0)[: k % 2]))
        for k, place in enumerate(places, 1)
    ]
    given.append(Waypoint(4.0, 0.1, *(0.0 for _ in motion or ())))
    once, often = (SetpointFollower(ControllerParameters({})) for _ in range(2))
    for each in (once, often):
        each.receive(0.02)
        each.sample(8.9, 0.0)
        each.receive_trajectory(given, start=9.1)
    for k in range(450):
        time = 9.0 + 0.01 * k
        if k % 7 == 1 and k < 400:
            often.receive_trajectory(given, start=9.1)
        assert often.sample(time, 0.0) == pytest.approx(once.sample(time, 0.0), abs=1e-9)


def test_a_motion_goes_on_where_a_trajectory_with_accelerations_takes_over() -> None:
    """Position, velocity and acceleration are those of the way before: no step in any of them."""
    found = SetpointFollower(ControllerParameters({}))
    found.sample(0.0, 0.02)
    way = [Waypoint(0.0, 0.02, 0.0, 0.0), Waypoint(1.0, 0.1, 0.0, 0.0)]
    found.receive_trajectory(way)
    found.sample(0.0, 0.0)
    found.receive_trajectory([Waypoint(1.0, 0.12, 0.0, 0.0)])
    step = 1e-4
    velocities = [found.sample(0.3 + step * k, 0.0).velocity for k in range(3)]
    old = hermite(way, 3)
    assert velocities[0] == pytest.approx(float(old.derivative()(0.3)))
    slope = (-3.0 * velocities[0] + 4.0 * velocities[1] - velocities[2]) / (2.0 * step)
    assert slope == pytest.approx(float(old.derivative(2)(0.3)), rel=1e-4)


@pytest.mark.parametrize("kind", ["setpoint", "ramp", "move"])
def test_set_points_and_trajectories_take_over_from_each_other(kind: str) -> None:
    """The latest counts, and a reset forgets a trajectory: the carriage stays where it is."""
    found = moving_follower(kind)
    found.receive(0.05)
    found.sample(0.2, 0.0)
    assert found.sample(9.0, 0.0) == (0.05, 0.0)
    found.receive_trajectory([Waypoint(1.0, 0.1)])
    assert found.sample(9.0, 0.0) == (0.05, pytest.approx(0.05))
    found.reset()
    assert found.sample(9.5, 0.07) == (0.07, 0.0)


def test_a_command_with_a_velocity_is_followed_as_it_is() -> None:
    """Position and velocity from the next sample on; the velocity counts for the time-out only."""
    found = SetpointFollower(ControllerParameters({"reference.velocity_timeout": 0.05}))
    found.sample(1.0, 0.01)
    found.receive_command(0.02, 0.3)
    assert found.sample(1.001, 0.01) == (0.02, 0.3)
    assert found.sample(1.05, 0.01) == (0.02, 0.3)
    assert found.sample(1.0511, 0.01) == (0.02, 0.0)
    found.receive_command(0.03, -0.1)
    assert found.sample(1.06, 0.01) == (0.03, -0.1)


@pytest.mark.parametrize(
    ("position", "velocity"),
    [(0.3, 0.0), (math.inf, 0.0), (0.1, math.nan), (0.1, math.inf), (0.1, 1e308)],
)
def test_a_bad_command_changes_nothing(position: float, velocity: float) -> None:
    """Outside the travel, not finite, or faster than anything."""
    found = moving_follower()
    with pytest.raises(ParameterError, match="command: "):
        found.receive_command(position, velocity)
    assert found.sample(0.5, 0.0) == (pytest.approx(0.05), pytest.approx(0.1))


@pytest.mark.parametrize("kind", ["step", "sine"])
def test_a_reference_from_parameters_takes_neither(kind: str) -> None:
    """They are refused as set-points are, with the way out."""
    found = SetpointFollower(ControllerParameters({"reference.type": kind}))
    with pytest.raises(ParameterError, match=f"reference.type is {kind}; set-points need"):
        found.receive_trajectory([Waypoint(1.0, 0.1)])
    with pytest.raises(ParameterError, match=f"reference.type is {kind}; set-points need"):
        found.receive_command(0.1, 0.0)
