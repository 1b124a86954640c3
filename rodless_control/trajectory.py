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
from numpy.polynomial.polynomial import polyval

from rodless_control.references import Reference

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

# From its control points to those of its first and of its second half (de Casteljau).
FIRST_HALF = np.array(
    [[math.comb(point, other) / 2**point for point in range(6)] for other in range(6)]
)
SECOND_HALF = FIRST_HALF[::-1, ::-1]

# Extremes are found to so much of the positions, in so many halvings at most.
FINEST = 1e-12
HALVINGS = 40

# m, by which a way may be off: no carriage knows it.
UNSEEN = 1e-9

# s, by which waypoints are apart at the least: what messages count in.
SHORTEST = 1e-9

# What is asked for is finite, and so is all that follows from it.
LARGEST = {"time": 1e12, "position": 1e6, "velocity": 1e6, "acceleration": 1e9}


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

    def __init__(self, points: Sequence[Waypoint], origin: float = 0.0) -> None:
        """Go through ``points``, whose times count from ``origin`` (s).

        Raises ValueError where times or values are not as they must be; the line names the first
        bad point, counted from 1.
        """
        check_waypoints(points)
        self._go_through(_table(points), origin)

    def _go_through(
        self, table: Array, origin: float, travel: tuple[float, float] = (-math.inf, math.inf)
    ) -> None:
        self._origin, self._table, self._travel = origin, table, travel
        self._times = table[:, 0].tolist()
        self._first, self._last = float(table[0, 1]), float(table[-1, 1])
        # All segments at once: a long trajectory must not keep a controller from its next sample.
        self._durations = np.diff(table[:, 0])
        start = table[:-1, 1, np.newaxis]
        offsets = _control_points(table, self._durations)
        self._hulls = start + offsets
        self._hulls[:, -1] = table[1:, 1]  # as given: rounded it could be beyond a limit
        # From offsets, so that a segment at rest has no velocity, and not that of rounding.
        self._segments = offsets @ POWERS_OF_CONTROL
        self._segments[:, :1] = start
        self._slopes = self._segments[:, 1:] * np.arange(1, 6)

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        position, velocity = self._course(time)
        low, high = self._travel
        if low <= position <= high:
            return position, velocity
        return min(max(position, low), high), 0.0

    def _course(self, time: float) -> tuple[float, float]:
        place, passed = self._where(time)
        if place < 0:
            return self._first, 0.0
        if place == len(self._segments):
            return self._last, 0.0
        position = float(polyval(passed, self._segments[place]))
        return position, float(polyval(passed, self._slopes[place])) / float(self._durations[place])

    def acceleration(self, time: float) -> float:
        """Return the acceleration (m/s²) at ``time`` (s)."""
        place, passed = self._where(time)
        low, high = self._travel
        if not (0 <= place < len(self._segments) and low <= self._course(time)[0] <= high):
            return 0.0
        bends = self._slopes[place, 1:] * np.arange(1, 5)
        return float(polyval(passed, bends)) / float(self._durations[place]) ** 2

    def _where(self, time: float) -> tuple[int, float]:
        """Return which segment ``time`` (s) lies in, and how much of that has passed then."""
        elapsed = time - self._origin
        place = bisect_right(self._times, elapsed) - 1
        if not 0 <= place < len(self._segments):
            return place, 0.0
        return place, (elapsed - self._times[place]) / float(self._durations[place])

    def joined(
        self, now: Reference, time: float, origin: float, travel: tuple[float, float]
    ) -> "Trajectory":
        """Return the way from ``now`` at ``time`` (s) to the first point still ahead, and on.

        Times count from ``origin`` (s). Points that lie behind are left out: on the way to the
        next one, where ``now`` is stands for the last of them. With none ahead, the last position
        is held. Where the way to the next point leaves ``travel`` (m, m), it waits at its end; it
        may begin outside.
        """
        here = time - origin
        ahead = int(np.searchsorted(self._table[:, 0] - here, SHORTEST))
        way = Trajectory.__new__(Trajectory)
        if ahead == len(self._table):
            way._go_through(self._table, origin)
            return way
        position, *motion = _motion(now, time)
        # What the last point behind does not ask for is not asked for here: on a way that is
        # followed already, as one that is sent again, the segment stays what it is.
        asked = np.isfinite(self._table[ahead - 1, 2:]) if ahead else np.full(2, True)
        joint = [here, position, *np.where(asked, motion, np.nan).tolist()]
        low, high = travel
        within = (min(low, position), max(high, position))
        way._go_through(np.vstack([joint, self._table[ahead:]]), origin, within)
        return way

    def excess(self) -> float | None:
        """Return the position (m) furthest beyond what a joined way keeps to, None within it."""
        low, high = self._travel
        least, greatest = self.extremes()
        furthest = least if low - least > greatest - high else greatest
        return furthest if max(low - least, greatest - high) > UNSEEN else None

    def ahead(self, time: float) -> tuple[float, float]:
        """Return the least and the greatest position from ``time`` (s) on, in m."""
        place, passed = self._where(time)
        hulls = self._hulls[max(place, 0) :].copy()
        if place >= 0 and len(hulls):
            hulls[0] = _rest(hulls[0], passed)
        low, high = self._travel
        least, greatest = _extremes(hulls, self._last)
        return max(least, low), min(greatest, high)

    def extremes(self) -> tuple[float, float]:
        """Return the least and the greatest position on the way, in m."""
        return _extremes(self._hulls, self._last)


def _extremes(pieces: Array, last: float) -> tuple[float, float]:
    """Return the least and the greatest position of segments, shape (n, 6), that end at ``last``.

    A piece of a segment lies within the hull of its control points: those that may leave what is
    known are halved until none does.
    """
    least = greatest = last
    for _ in range(HALVINGS):
        least = min(least, float(pieces[:, ::5].min(initial=least)))
        greatest = max(greatest, float(pieces[:, ::5].max(initial=greatest)))
        fine = FINEST * max(1.0, abs(least), abs(greatest))
        beyond = (pieces.min(axis=1) < least - fine) | (pieces.max(axis=1) > greatest + fine)
        if not beyond.any():
            break
        pieces = np.concatenate([pieces[beyond] @ FIRST_HALF, pieces[beyond] @ SECOND_HALF])
    return least, greatest


def _rest(points: Array, passed: float) -> Array:
    """Return the control points, shape (6,), of what is left once ``passed`` of 1 has passed."""
    found = [points[-1]]
    while len(points) > 1:
        points = points[:-1] + passed * np.diff(points)
        found.append(points[-1])
    return np.array(found[::-1])


def check_waypoints(points: Sequence[Waypoint]) -> None:
    """Raise ValueError, in one line, for points that no carriage can go through."""
    if not points:
        raise ValueError("no points")
    before = -math.inf
    for number, point in enumerate(points, 1):
        for name, largest in LARGEST.items():
            value = getattr(point, name)
            if value is not None and not abs(value) <= largest:
                why = f"beyond {largest:g}" if math.isfinite(value) else "not finite"
                raise ValueError(f"point {number}: {name} {value!r} is {why}")
        if point.time - before < SHORTEST:
            raise ValueError(
                f"point {number}: its time, {point.time:g} s, is not after that of the point "
                f"before, {before:g} s"
            )
        before = point.time
    velocity = points[-1].velocity or 0.0
    if abs(velocity) > REST:
        raise ValueError(f"the last point has velocity {velocity:g} m/s, must be 0")


def _motion(reference: Reference, time: float) -> tuple[float, float, float]:
    """Return position, velocity and acceleration, these no larger than a point's may be."""
    position, velocity = reference.sample(time)
    acceleration = reference.acceleration(time) if isinstance(reference, Trajectory) else 0.0
    fastest, hardest = LARGEST["velocity"], LARGEST["acceleration"]
    return (
        position,
        min(max(velocity, -fastest), fastest),
        min(max(acceleration, -hardest), hardest),
    )


def _table(points: Sequence[Waypoint]) -> Array:
    """Return times, positions, velocities and accelerations, shape (n, 4); nan where not asked."""
    rows = [(point.time, point.position, point.velocity, point.acceleration) for point in points]
    return np.array(rows, dtype=float)


def _control_points(table: Array, duration: Array) -> Array:
    """Return those of the quintic between each two rows of ``table``, shape (n - 1, 6).

    They are m from where the segment begins, which lasts for ``duration`` (s), shape (n - 1,).
    Velocities and accelerations that are not asked for are those of a line, or of a cubic.
    """
    distance = np.diff(table[:, 1])
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
            np.zeros(distance.shape),
            leaves / 5.0,
            2.0 * leaves / 5.0 + gains / 20.0,
            distance - 2.0 * arrives / 5.0 + loses / 20.0,
            distance - arrives / 5.0,
            distance,
        ],
        axis=1,
    )
