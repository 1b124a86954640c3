# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A reference through points in time, interpolated as joint_trajectory_controller does."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval

Array = npt.NDArray[np.float64]

# Speed (m/s) up to which a trajectory counts as ending at rest; that of the standard controller.
REST = float(np.finfo(np.float32).eps)

# From the control points of a quintic Bernstein polynomial to its coefficients of the powers 0 to
# 5, a row for each point: what an end's position, velocity and acceleration set is apart so.
POWERS_OF_CONTROL = np.array(
    [
        [
            math.comb(5, power) * math.comb(power, point) * (-1) ** (power - point)
            for power in range(6)
        ]
        for point in range(6)
    ],
    dtype=float,
)

# Powers whose share of the rest is smaller have only rounding in them.
NOTHING = 1e-12


@dataclass(frozen=True)
class Waypoint:
    """A point of a trajectory; what is None is not asked for."""

    time: float  # s
    position: float  # m
    velocity: float | None = None  # m/s
    acceleration: float | None = None  # m/s²; counts with a velocity only


class Trajectory:
    """From waypoint to waypoint; at rest before the first and after the last.

    A segment is linear between positions, cubic where both its ends have velocities, and quintic
    where both have accelerations too (ros2_controllers, joint_trajectory_controller).

    Examples
    --------
    >>> swing = Trajectory([Waypoint(0.0, 0.0, 0.0), Waypoint(2.0, 0.1, 0.0)])
    >>> swing.sample(1.0)
    (0.05, 0.07500000000000001)
    """

    def __init__(self, points: Sequence[Waypoint]) -> None:
        """Go through ``points``; raises ValueError where times or values are not as they must be.

        The line names the first bad point, counted from 1.
        """
        check_waypoints(points)
        self.points = tuple(points)
        self._times = [point.time for point in points]
        # All segments at once: a long trajectory must not keep a controller from its next sample.
        table = _table(points)
        self._durations = np.diff(table[:, 0])
        with np.errstate(over="ignore", invalid="ignore"):
            self._hulls = _control_points(table)
            self._segments = self._hulls @ POWERS_OF_CONTROL
            self._slopes = self._segments[:, 1:] * np.arange(1, 6)
            _check_size(self._slopes / self._durations[:, np.newaxis])

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        place = bisect_right(self._times, time) - 1
        if place < 0:
            return self.points[0].position, 0.0
        if place == len(self._segments):
            return self.points[-1].position, 0.0
        duration = float(self._durations[place])
        passed = (time - self._times[place]) / duration
        position = float(polyval(passed, self._segments[place]))
        return position, float(polyval(passed, self._slopes[place])) / duration

    def extremes(self) -> tuple[float, float]:
        """Return the least and the greatest position on the way, in m."""
        reached = [point.position for point in self.points]
        least, greatest = min(reached), max(reached)
        # A segment lies within the hull of its control points: few may leave what is known.
        beyond = (self._hulls.min(axis=1) < least) | (self._hulls.max(axis=1) > greatest)
        for place in np.flatnonzero(beyond):
            slope = Polynomial(self._slopes[place])
            roots = slope.trim(NOTHING * np.abs(slope.coef).max()).roots()
            turns = roots.real[(abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)]
            reached += polyval(turns, self._segments[place]).tolist()
        return min(reached), max(reached)


def check_waypoints(points: Sequence[Waypoint]) -> None:
    """Raise ValueError, in one line, for points that no carriage can go through."""
    if not points:
        raise ValueError("no points")
    for number, point in enumerate(points, 1):
        for name in ("time", "position", "velocity", "acceleration"):
            value = getattr(point, name)
            if value is not None and not math.isfinite(value):
                raise ValueError(f"point {number}: {name} {value!r} is not finite")
        before = points[number - 2].time if number > 1 else -math.inf
        if not before < point.time:
            raise ValueError(
                f"point {number}: its time, {point.time:g} s, is not after that of the point "
                f"before, {before:g} s"
            )
    velocity = points[-1].velocity or 0.0
    if abs(velocity) > REST:
        raise ValueError(f"the last point has velocity {velocity:g} m/s, must be 0")


def _check_size(speeds: Array) -> None:
    """Raise ValueError where a segment's coefficients, shape (n - 1, 5), are beyond numbers."""
    beyond = np.flatnonzero(~np.isfinite(speeds).all(axis=1))
    if len(beyond):
        number = int(beyond[0]) + 1
        raise ValueError(
            f"points {number} and {number + 1}: their distance, velocities or accelerations are "
            "too large for the time between them"
        )


def _table(points: Sequence[Waypoint]) -> Array:
    """Return times, positions, velocities and accelerations, shape (n, 4); nan where not asked."""
    rows = [(point.time, point.position, point.velocity, point.acceleration) for point in points]
    return np.array(rows, dtype=float)


def _control_points(table: Array) -> Array:
    """Return those (m) of the quintic between each two rows of ``table``, shape (n - 1, 6).

    Velocities and accelerations that are not asked for are those of a line, or of a cubic.
    """
    duration = np.diff(table[:, 0])
    start, end = table[:-1, 1], table[1:, 1]
    distance = end - start
    # As m in a segment's duration.
    leaves, arrives = table[:-1, 2] * duration, table[1:, 2] * duration
    straight = np.isnan(leaves) | np.isnan(arrives)
    leaves, arrives = np.where(straight, distance, leaves), np.where(straight, distance, arrives)
    gains, loses = table[:-1, 3] * duration**2, table[1:, 3] * duration**2
    cubic = straight | np.isnan(gains) | np.isnan(loses)
    gains = np.where(cubic, 6.0 * distance - 4.0 * leaves - 2.0 * arrives, gains)
    loses = np.where(cubic, 2.0 * leaves + 4.0 * arrives - 6.0 * distance, loses)
    return np.stack(
        [
            start,
            start + leaves / 5.0,
            start + 2.0 * leaves / 5.0 + gains / 20.0,
            end - 2.0 * arrives / 5.0 + loses / 20.0,
            end - arrives / 5.0,
            end,
        ],
        axis=1,
    )
