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
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial

# Speed (m/s) up to which a trajectory counts as ending at rest; that of the standard controller.
REST = float(np.finfo(np.float32).eps)


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
        self._segments = [_segment(a, b) for a, b in pairwise(points)]
        self._slopes = [segment.deriv() for segment in self._segments]

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        place = bisect_right(self._times, time) - 1
        if place < 0:
            return self.points[0].position, 0.0
        if place == len(self._segments):
            return self.points[-1].position, 0.0
        elapsed = time - self._times[place]
        return float(self._segments[place](elapsed)), float(self._slopes[place](elapsed))

    def extremes(self) -> tuple[float, float]:
        """Return the least and the greatest position on the way, in m."""
        reached = [point.position for point in self.points]
        for segment, slope, begin, end in zip(
            self._segments, self._slopes, self._times, self._times[1:], strict=False
        ):
            turns = [float(root.real) for root in slope.roots() if abs(root.imag) < 1e-9]
            reached += [float(segment(turn)) for turn in turns if 0.0 < turn < end - begin]
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


def _segment(a: Waypoint, b: Waypoint) -> Polynomial:
    """Return the position (m) between two points, by the time since the first (s)."""
    duration, distance = b.time - a.time, b.position - a.position
    if a.velocity is None or b.velocity is None:
        return Polynomial([a.position, distance / duration])
    # What is left of the distance, velocity and acceleration at the end, as powers of duration.
    if a.acceleration is None or b.acceleration is None:
        rest = distance - a.velocity * duration
        turn = (b.velocity - a.velocity) * duration
        terms = [3.0 * rest - turn, turn - 2.0 * rest]
        head = [a.position, a.velocity]
    else:
        half = 0.5 * a.acceleration
        rest = distance - duration * (a.velocity + half * duration)
        turn = (b.velocity - a.velocity - a.acceleration * duration) * duration
        bend = (b.acceleration - a.acceleration) * duration**2
        terms = [
            10.0 * rest - 4.0 * turn + 0.5 * bend,
            -15.0 * rest + 7.0 * turn - bend,
            6.0 * rest - 3.0 * turn + 0.5 * bend,
        ]
        head = [a.position, a.velocity, half]
    first = len(head)
    return Polynomial([*head, *(c / duration**k for k, c in enumerate(terms, first))])
