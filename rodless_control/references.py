# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Reference trajectories: position and velocity at a time, ``sample(time) -> (m, m/s)``.

Where a trajectory has ``samples(times)``, shape (n,) to (n, 2), that gives many at once, with the
same bits. All raise ValueError for a number that is not finite.

Examples
--------
>>> step(0.0, 0.058, at=0.5).sample(1.0)
(0.058, 0.0)
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import outlined_kernel
from rodless_base.one_line import shown, traced
from rodless_base.real_number import is_number, only_number

Array = npt.NDArray[np.float64]


class Reference(Protocol):
    """Anything that can be sampled in plant time, such as a class of your own.

    Examples
    --------
    A ramp that never ends, at 10 mm/s:

    >>> class Creep:
    ...     def sample(self, time):
    ...         return 0.01 * time, 0.01
    >>> from rodless_control import Pid
    >>> Creep().sample(2.0)
    (0.02, 0.01)
    """

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""


def sampled(reference: Reference, times: Array) -> Array:
    """Return position (m) and velocity (m/s) at ``times`` (s), shape (n,), as shape (n, 2).

    Raises TypeError for what is no reference, and ValueError for times that are no finite numbers
    in a row, and, with the time, for a reference that raises and an answer that is not two finite
    numbers.
    """
    times = _checked_times(times)
    # A class has the methods of its instances, and answers none.
    asked = None if isinstance(reference, type) else reference
    if callable(at_once := getattr(asked, "samples", None)):
        points = _array(reference, _answer(reference, at_once, times), len(times))
    elif callable(at_one := getattr(asked, "sample", None)):
        points = np.array(
            [_point(reference, time, _answer(reference, at_one, time)) for time in times.tolist()]
        ).reshape(-1, 2)
    else:
        raise TypeError(
            f"{shown(reference)} is no reference: give one of rodless_control.references, or an "
            "object with sample(time) -> (position in m, velocity in m/s)"
        )
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise _no_point(reference, float(times[bad[0]]), tuple(points[bad[0]].tolist()))
    return points


def _answer(reference: object, ask: Callable[[Any], object], time: float | Array) -> object:
    try:
        return ask(time)
    except (Exception, SystemExit) as error:
        at = f"{time:g} s" if isinstance(time, float) else "all times"
        raise ValueError(f"at {at}: reference {_name(reference)} raises {traced(error)}") from error


def _checked_times(times: object) -> Array:
    try:
        found = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = np.empty((0, 0))
    if found.ndim != 1 or not np.isfinite(found).all():
        raise ValueError(f"times {shown(times)} refused: must be finite numbers of s, shape (n,)")
    return found


def _array(reference: object, answer: object, count: int) -> Array:
    """Return what ``samples`` has answered; raises ValueError unless it is numbers, (n, 2)."""
    try:
        points = np.ascontiguousarray(answer)
    except ValueError:  # rows of different lengths
        points = np.empty(0)
    if points.shape != (count, 2) or points.dtype.kind not in "iuf" or np.ma.is_masked(answer):
        raise ValueError(
            f"reference {_name(reference)}: samples(times) answered {shown(answer)} for {count} "
            f"times, must be numbers of shape ({count}, 2): position (m) and velocity (m/s)"
        )
    return points.astype(np.float64, copy=False)


def _point(reference: object, time: float, answer: object) -> tuple[float, float]:
    try:
        numbers: list[object] = list(answer)  # type: ignore[call-overload]
        position, velocity = (float(each) for each in numbers if is_number(each))
    except (TypeError, ValueError, OverflowError) as error:
        raise _no_point(reference, time, answer) from error
    if len(numbers) != 2:
        raise _no_point(reference, time, answer)
    return position, velocity


def _no_point(reference: object, time: float, answer: object) -> ValueError:
    return ValueError(
        f"at {time:g} s: reference {_name(reference)} answered {shown(answer)}, must be two finite "
        "numbers: position (m) and velocity (m/s)"
    )


def _name(reference: object) -> str:
    return type(reference).__name__


def _points(position: Array | float, velocity: Array | float, times: Array) -> Array:
    """Return both as columns, one row for each of ``times``."""
    found = np.empty((len(times), 2))
    found[:, 0], found[:, 1] = position, velocity
    return found


@outlined_kernel
def _sine_samples(centre: float, amplitude: float, rate: float, at: float, times: Array) -> Array:
    # numpy's sine need not have the bits of math's.
    found = np.empty((times.size, 2))
    for k in range(times.size):
        if times[k] < at:
            found[k, 0], found[k, 1] = centre, 0.0
        else:
            angle = rate * (times[k] - at)
            found[k, 0] = centre + amplitude * math.sin(angle)
            found[k, 1] = amplitude * rate * math.cos(angle)
    return found


@dataclass(frozen=True)
class _Finite:
    """What has numbers only, none of them NaN or infinite: with one, the valve would close.

    They are kept as floats, whatever kind of number they were.
    """

    def __post_init__(self) -> None:
        for field in fields(self):
            given = getattr(self, field.name)
            value = only_number(given)
            if not is_number(value):
                raise TypeError(f"{field.name} {shown(given)} refused: must be a number")
            if not _is_finite(value):
                raise ValueError(f"{field.name} {shown(given)} refused: must be finite")
            object.__setattr__(self, field.name, float(value))


def _is_finite(value: object) -> bool:
    try:
        return math.isfinite(value)  # type: ignore[arg-type]
    except OverflowError:  # a whole number too large for a float
        return False


@dataclass(frozen=True)
class Constant(_Finite):
    """A position held for ever, m."""

    position: float

    def sample(self, time: float) -> tuple[float, float]:  # noqa: ARG002
        """Return the position and no velocity."""
        return self.position, 0.0

    def samples(self, times: Array) -> Array:
        """Return :meth:`sample` at each of ``times``."""
        return _points(self.position, 0.0, times)


@dataclass(frozen=True)
class Moving(_Finite):
    """A position (m) to be held with a ``velocity`` (m/s), which counts until ``until`` (s)."""

    position: float
    velocity: float
    until: float

    def sample(self, time: float) -> tuple[float, float]:
        """Return the position as it was given, and the velocity while it counts."""
        return self.position, (self.velocity if time < self.until else 0.0)


@dataclass(frozen=True)
class Step(_Finite):
    """``before`` (m) until time ``at`` (s), ``after`` (m) from then on."""

    before: float
    after: float
    at: float = 0.0

    def sample(self, time: float) -> tuple[float, float]:
        """Return the position on this side of the step; the jump itself has no velocity."""
        return (self.before if time < self.at else self.after), 0.0

    def samples(self, times: Array) -> Array:
        """Return :meth:`sample` at each of ``times``."""
        return _points(np.where(times < self.at, self.before, self.after), 0.0, times)


@dataclass(frozen=True)
class Ramp(_Finite):
    """From ``start`` to ``target`` (m) at ``velocity`` (m/s, positive), from time ``at`` (s)."""

    start: float
    target: float
    velocity: float
    at: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_positive("velocity", self.velocity)

    def sample(self, time: float) -> tuple[float, float]:
        """Return a point on the ramp, at rest before and after."""
        distance = self.target - self.start
        elapsed = time - self.at
        if elapsed < 0.0:
            return self.start, 0.0
        if elapsed * self.velocity >= abs(distance):
            return self.target, 0.0
        velocity = math.copysign(self.velocity, distance)
        return self.start + velocity * elapsed, velocity

    def samples(self, times: Array) -> Array:
        """Return :meth:`sample` at each of ``times``."""
        distance = self.target - self.start
        elapsed = times - self.at
        velocity = math.copysign(self.velocity, distance)
        before, after = elapsed < 0.0, elapsed * self.velocity >= abs(distance)
        position = np.where(after, self.target, self.start + velocity * elapsed)
        return _points(
            np.where(before, self.start, position),
            np.where(before | after, 0.0, velocity),
            times,
        )


# No plant runs longer, s: 2^63 ns.
LONGEST = 1e10


@dataclass(frozen=True)
class Sine(_Finite):
    """``centre`` until ``at`` (s), then centre + amplitude·sin(2π·frequency·t): m, m, Hz."""

    centre: float
    amplitude: float
    frequency: float
    at: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        rate = 2.0 * math.pi * self.frequency
        reached = (
            rate * (LONGEST + abs(self.at)),
            self.amplitude * rate,
            abs(self.centre) + abs(self.amplitude),
        )
        if not all(map(_is_finite, reached)):
            raise ValueError(
                f"centre {shown(self.centre)}, amplitude {shown(self.amplitude)}, frequency "
                f"{shown(self.frequency)} and at {shown(self.at)} refused: too large for a sine "
                "that can be computed"
            )

    def sample(self, time: float) -> tuple[float, float]:
        """Return a point on the sine."""
        if time < self.at:
            return self.centre, 0.0
        rate = 2.0 * math.pi * self.frequency
        angle = rate * (time - self.at)
        return (
            self.centre + self.amplitude * math.sin(angle),
            self.amplitude * rate * math.cos(angle),
        )

    def samples(self, times: Array) -> Array:
        """Return :meth:`sample` at each of ``times``."""
        rate = 2.0 * math.pi * self.frequency
        return _sine_samples(self.centre, self.amplitude, rate, self.at, times)


# A distance (m) that no carriage knows: shorter moves need not be computed in all their digits.
SMALLEST = 1e-12


@dataclass(frozen=True)
class Move(_Finite):
    """Rest to rest from ``start`` to ``target`` (m), from time ``at`` (s), as fast as limits allow.

    The limits are ``velocity`` (m/s), ``acceleration`` (m/s²) and ``jerk`` (m/s³), all positive.
    Seven phases of constant jerk (Biagiotti and Melchiorri, *Trajectory Planning for Automatic
    Machines and Robots*, 2008, section 3.4).
    """

    start: float
    target: float
    velocity: float
    acceleration: float
    jerk: float
    at: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("velocity", "acceleration", "jerk"):
            _require_positive(name, getattr(self, name))
        if not self._arrives():
            raise ValueError(
                f"velocity {self.velocity!r}, acceleration {self.acceleration!r} and jerk "
                f"{self.jerk!r} refused: no move over {abs(self.target - self.start):g} m can be "
                "computed with limits so small or so large"
            )

    def _arrives(self) -> bool:
        """Whether the phases end at the target: limits near the ends of what a float holds do not.

        They overflow, underflow, or divide by zero.
        """
        distance = abs(self.target - self.start)
        position = velocity = acceleration = 0.0
        try:
            for jerk, t in self._phases():
                position += t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0))
                velocity += t * (acceleration + t * jerk / 2.0)
                acceleration += t * jerk
        except (ZeroDivisionError, OverflowError):
            return False
        return math.isfinite(distance) and abs(position - distance) <= 1e-6 * distance + SMALLEST

    @property
    def duration(self) -> float:
        """Time from start to target in s."""
        return sum(duration for _, duration in self._phases())

    def sample(self, time: float) -> tuple[float, float]:
        """Return a point of the move, at rest before and after."""
        elapsed = time - self.at
        if elapsed <= 0.0:
            return self.start, 0.0
        side = math.copysign(1.0, self.target - self.start)
        position = velocity = acceleration = 0.0
        for jerk, duration in self._phases():
            t = min(elapsed, duration)
            position += t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0))
            velocity += t * (acceleration + t * jerk / 2.0)
            acceleration += t * jerk
            elapsed -= t
            if elapsed <= 0.0:
                return self.start + side * position, side * velocity
        return self.target, 0.0

    def samples(self, times: Array) -> Array:
        """Return :meth:`sample` at each of ``times``."""
        elapsed = times - self.at
        before = elapsed <= 0.0
        side = math.copysign(1.0, self.target - self.start)
        position, velocity = np.zeros(len(times)), np.zeros(len(times))
        acceleration = np.zeros(len(times))
        for jerk, duration in self._phases():
            # A cruise that rounds to less than nothing must not draw those back who have arrived.
            t = np.where(elapsed > 0.0, np.minimum(elapsed, duration), 0.0)
            position += t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0))
            velocity += t * (acceleration + t * jerk / 2.0)
            acceleration += t * jerk
            elapsed = elapsed - t
        after = ~before & (elapsed > 0.0)
        return _points(
            np.where(
                before, self.start, np.where(after, self.target, self.start + side * position)
            ),
            np.where(before | after, 0.0, side * velocity),
            times,
        )

    def _phases(self) -> tuple[tuple[float, float], ...]:
        """Jerk and duration of the seven phases, in the direction of the move."""
        distance = abs(self.target - self.start)
        velocity, acceleration = self._peaks(distance)
        if velocity == 0.0:
            return ()
        building = acceleration / self.jerk
        steady = velocity / acceleration - building
        cruise = distance / velocity - velocity / acceleration - building
        jerk = self.jerk
        return (
            (jerk, building),
            (0.0, steady),
            (-jerk, building),
            (0.0, cruise),
            (-jerk, building),
            (0.0, steady),
            (jerk, building),
        )

    def _peaks(self, distance: float) -> tuple[float, float]:
        """Velocity and acceleration that a move over ``distance`` (m) reaches."""
        limit, jerk = self.acceleration, self.jerk
        # Reaching velocity v covers v·(v/a + a/j)/2; the move needs that twice.
        with_steady = 0.5 * (
            math.sqrt((limit * limit / jerk) ** 2 + 4.0 * limit * distance) - limit * limit / jerk
        )
        without_steady = (distance * distance * jerk / 4.0) ** (1.0 / 3.0)
        reachable = with_steady if with_steady * jerk >= limit * limit else without_steady
        velocity = min(self.velocity, reachable)
        return velocity, min(limit, math.sqrt(velocity * jerk))


constant, step, ramp, sine, move = Constant, Step, Ramp, Sine, Move


def _require_positive(name: str, value: float) -> None:
    if not value > 0.0:
        raise ValueError(f"{name} {value!r} refused: must be positive")
