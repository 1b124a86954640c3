# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The jerk-limited move: within its limits, exactly there, and as fast as can be."""

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import bisect, linprog

from rodless_control.references import Move, sampled

DISTANCES = (1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.058, 0.2, 1.0)
# m/s, m/s², m/s³: the defaults, soft, stiff, no room for the speed, none for the acceleration.
LIMITS = (
    (0.05, 0.5, 10.0),
    (0.2, 0.1, 0.3),
    (0.5, 50.0, 1e5),
    (1e-3, 2.0, 5.0),
    (2.0, 100.0, 1.0),
)
CASES = [
    pytest.param(start, start + side * distance, *limits, id=f"{side * distance:g}-{limits}")
    for distance, limits, (start, side) in itertools.product(
        DISTANCES, LIMITS, ((0.0, 1.0), (0.0, -1.0))
    )
]
PIECES = 3000
EPSILON = float(np.finfo(float).eps)


def curve(move: Move, begin: float, end: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Spacing in s of samples between two times of the move, and position and velocity at each."""
    times = move.at + np.linspace(begin, end, PIECES + 1)
    positions, velocities = np.array([move.sample(float(time)) for time in times]).T
    return (end - begin) / PIECES, positions, velocities


@pytest.mark.parametrize("end", ["departure", "arrival"])
@pytest.mark.parametrize(("start", "target", "velocity", "acceleration", "jerk"), CASES)
def test_limits_hold_and_velocity_is_the_derivative(
    start: float, target: float, velocity: float, acceleration: float, jerk: float, end: str
) -> None:
    """Differences of the sampled curve show no more speed, acceleration or jerk than allowed."""
    move = Move(start, target, velocity, acceleration, jerk)
    # Long enough for a change of speed; in between a long move cruises.
    window = min(move.duration, 1.2 * ramp_up(velocity, acceleration, jerk))
    begin = 0.0 if end == "departure" else move.duration - window
    spacing, positions, velocities = curve(move, begin, begin + window)
    accelerations = np.diff(velocities) / spacing
    assert np.abs(velocities).max() <= velocity * (1.0 + 1e-12)
    assert np.abs(accelerations).max() <= acceleration * (1.0 + 1e-6)
    assert np.abs(np.diff(accelerations)).max() / spacing <= jerk * (1.0 + 1e-3)
    means = (velocities[1:] + velocities[:-1]) / 2.0
    # What the trapezoidal rule leaves out at full jerk, and the rounding of a position.
    rest = jerk * spacing**2 / 12.0 * 1.001 + 4.0 * EPSILON * abs(target - start) / spacing
    np.testing.assert_allclose(np.diff(positions) / spacing, means, rtol=1e-8, atol=rest)


@pytest.mark.parametrize(("start", "target", "velocity", "acceleration", "jerk"), CASES)
def test_it_goes_straight_from_start_to_target(
    start: float, target: float, velocity: float, acceleration: float, jerk: float
) -> None:
    """It starts and ends at rest, turns nowhere, and stands exactly on its target afterwards."""
    move = Move(start, target, velocity, acceleration, jerk, at=0.25)
    _, positions, velocities = curve(move, 0.0, move.duration)
    side = math.copysign(1.0, target - start)
    assert move.sample(0.25) == (start, 0.0)
    assert (np.diff(side * positions) >= -1e-14 * abs(target - start)).all()
    assert positions[-1] == pytest.approx(target, rel=1e-9)
    assert abs(velocities[-1]) < 1e-9 * np.abs(velocities).max()
    for late in (1e-6, 1.0, 1e6):
        assert move.sample(0.25 + move.duration * (1.0 + late)) == (target, 0.0)


def ramp_up(velocity: float, acceleration: float, jerk: float) -> float:
    """Time from rest to ``velocity``: bang-zero-bang jerk, or bang-bang where there is no room."""
    if velocity * jerk >= acceleration**2:
        return velocity / acceleration + acceleration / jerk
    return 2.0 * math.sqrt(velocity / jerk)


def shortest_time(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Least time, the peak speed of moves without cruise being found by bisection.

    Speed rises symmetrically in time, so that each ramp covers half its speed times its time.
    """

    def covered(peak: float) -> float:
        return peak * ramp_up(peak, acceleration, jerk)

    rest = distance - covered(velocity)
    if rest >= 0.0:
        return 2.0 * ramp_up(velocity, acceleration, jerk) + rest / velocity
    peak = bisect(lambda v: covered(v) / distance - 1.0, 0.0, velocity, xtol=1e-300, rtol=1e-14)
    return 2.0 * ramp_up(peak, acceleration, jerk)


@pytest.mark.parametrize(("start", "target", "velocity", "acceleration", "jerk"), CASES)
def test_it_takes_the_time_of_a_bisection(
    start: float, target: float, velocity: float, acceleration: float, jerk: float
) -> None:
    """Its duration, from closed forms, is that of a search for the highest usable speed."""
    move = Move(start, target, velocity, acceleration, jerk)
    expected = shortest_time(abs(target - start), velocity, acceleration, jerk)
    assert move.duration == pytest.approx(expected, rel=1e-9)


def test_a_long_move_takes_the_textbook_time() -> None:
    """d/v + v/a + a/j with every limit reached: 0.2/0.05 + 0.05/0.5 + 0.5/10 = 4.15 s."""
    assert Move(0.0, 0.2, 0.05, 0.5, 10.0).duration == pytest.approx(4.15, rel=1e-14)


def test_a_short_move_takes_the_textbook_time() -> None:
    """With jerk alone at its limit it is the cube root of 32 d/j: 0.2 mm at 0.1 m/s³ take 0.4 s."""
    assert Move(0.0, 0.0002, 1.0, 1.0, 0.1).duration == pytest.approx(0.4, rel=1e-14)


def farthest(duration: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Farthest rest-to-rest distance in ``duration``: a linear programme over 240 pieces of jerk.

    It knows nothing of the shape of a move, only of its limits.
    """
    pieces = 240
    step = duration / pieces
    sums = np.tril(np.ones((pieces, pieces)))
    to_acceleration = sums * step
    earlier = np.vstack([np.zeros(pieces), to_acceleration[:-1]])
    to_velocity = sums @ (earlier * step + np.eye(pieces) * step**2 / 2.0)
    before = np.vstack([np.zeros(pieces), to_velocity[:-1]])
    to_position = (before * step + earlier * step**2 / 2.0 + np.eye(pieces) * step**3 / 6.0).sum(0)
    within = np.vstack([to_acceleration, -to_acceleration, to_velocity, -to_velocity])
    limits = np.repeat([acceleration, acceleration, velocity, velocity], pieces)
    ends = np.vstack([to_acceleration[-1], to_velocity[-1]])
    unit = jerk * step**3
    found = linprog(
        -to_position / unit * jerk,
        A_ub=within * jerk / limits[:, None],
        b_ub=np.ones(4 * pieces),
        A_eq=ends * jerk / limits[[0, -1], None],
        b_eq=np.zeros(2),
        bounds=(-1.0, 1.0),
    )
    assert found.success, found.message
    return -float(found.fun) * unit


@pytest.mark.parametrize(
    ("distance", "velocity", "acceleration", "jerk"),
    [
        (0.058, 0.05, 0.5, 10.0),
        (0.002, 0.05, 0.5, 10.0),
        (0.0002, 1.0, 1.0, 0.1),
        (0.02, 1.0, 0.2, 2.0),
        (0.5, 0.1, 2.0, 0.5),
    ],
    ids=["all limits", "short of speed", "jerk alone", "no cruise", "no steady acceleration"],
)
def test_no_trajectory_is_faster(
    distance: float, velocity: float, acceleration: float, jerk: float
) -> None:
    """An optimiser given the same limits and time gets no farther, to its own resolution."""
    duration = Move(0.0, distance, velocity, acceleration, jerk).duration
    assert farthest(duration, velocity, acceleration, jerk) == pytest.approx(distance, rel=2e-3)


@pytest.mark.parametrize("place", [0.0, 0.058, -1e6])
def test_no_distance_takes_no_time(place: float) -> None:
    """A move to where it starts is over at once, and finite all the same."""
    move = Move(place, place, 0.05, 0.5, 10.0, at=2.0)
    assert move.duration == 0.0
    assert {move.sample(time) for time in (0.0, 2.0, 2.0 + 1e-12, 9.0)} == {(place, 0.0)}


@pytest.mark.parametrize("distance", [5e-324, 1e-200, 1e-100, 1e-30])
def test_the_tiniest_distances_are_finite(distance: float) -> None:
    """Distances down to the smallest float stay between start and target at every time."""
    move = Move(0.0, distance, 0.05, 0.5, 10.0)
    for time in np.linspace(0.0, move.duration + 1e-12, 50):
        position, velocity = move.sample(float(time))
        assert -1e-9 * distance <= position <= distance * (1.0 + 1e-9)
        assert math.isfinite(velocity)
    assert move.sample(move.duration + 1e-12) == (distance, 0.0)


@pytest.mark.parametrize("acceleration", [2.2e-308, 1e-300, 1e-200, 1e-30, 1e-3, 1e3, 1e30])
def test_one_by_one_and_all_at_once_agree_for_any_limit(acceleration: float) -> None:
    """Where the cruise rounds to less than nothing too: all the numbers are the same."""
    move = Move(0.0, 0.1, 0.1, acceleration, 10.0, at=0.1)
    times = np.concatenate([np.linspace(0.0, 1.0, 50), np.geomspace(1e-3, 1e160, 300)])
    points = sampled(move, times)
    assert points.tolist() == [list(move.sample(time)) for time in times.tolist()]
    assert points[:, 0].min() >= 0.0
