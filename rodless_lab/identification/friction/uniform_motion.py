# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Find by itself where a run moves at uniform speed, and say why where it never does."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_base.number_rows import number_rows
from rodless_lab.runs.measured_run import even_period
from rodless_sim.single_number import positive_number

Array = npt.NDArray[np.float64]

# Length in s of the stretches a run is judged by, and the change of speed over one, as a share of
# the speed, up to which the motion passes as uniform.
WINDOW = 0.25
TOLERANCE = 0.05

# Slower than this (m/s), and slower than three standard errors, is standing still.
STANDSTILL = 5e-5

# A stretch whose distance from a smooth curve exceeds the noise by this factor contains a stick
# or a slip.
LARGEST_ROUGHNESS = 1.5

# Where noise is too small to measure, position is taken as known to this (m).
FINEST_POSITION = 1e-9


@dataclass(frozen=True)
class UniformPart:
    """A stretch of uniform motion: samples ``first`` to ``last`` (exclusive), times in s.

    ``speed`` is signed (m/s), ``speed_error`` its standard error, ``acceleration`` in m/s².
    """

    first: int
    last: int
    start: float
    end: float
    speed: float
    speed_error: float
    acceleration: float

    def mean(self, values: Array) -> float:
        """Mean of ``values``, shape (n,), sampled with the run, over this part."""
        return float(np.mean(values[self.first : self.last]))


@dataclass(frozen=True)
class UniformSearch:
    """What :func:`uniform_parts` found; ``reason`` says why where ``parts`` is empty."""

    parts: tuple[UniformPart, ...]
    reason: str

    @property
    def longest(self) -> UniformPart:
        """The longest part; raises ValueError with the reason where there is none."""
        if not self.parts:
            raise ValueError(f"no uniform motion: {self.reason}")
        return max(self.parts, key=lambda part: part.end - part.start)


@dataclass(frozen=True)
class _Stretch:
    first: int
    last: int
    speed: float
    error: float
    acceleration: float
    roughness: float

    @property
    def moving(self) -> bool:
        return abs(self.speed) > max(STANDSTILL, 3.0 * self.error)


def position_noise(position: Array) -> float:
    """Standard deviation in m of white noise on ``position``, shape (n,), from third differences.

    Third differences remove any smooth motion; the median keeps stick and slip out of it.
    """
    third = np.diff(position, 3)
    if not len(third):
        return FINEST_POSITION
    return max(float(np.median(np.abs(third)) / (0.6745 * np.sqrt(20.0))), FINEST_POSITION)


def uniform_parts(
    time: Array, position: Array, window: float = WINDOW, tolerance: float = TOLERANCE
) -> UniformSearch:
    """Find the parts of a run at uniform speed.

    Parameters
    ----------
    time, position
        Shape (n,): s, increasing and evenly spaced, and m.
    window
        Shortest part in s.
    tolerance
        Share of its own mean within which the speed of a part stays.

    Raises
    ------
    ValueError
        For a run shorter than one window; for what is no even run of numbers (``RunError``, or with
        the name of the argument); for a window or tolerance that is not positive.

    Examples
    --------
    >>> time = np.arange(2000) * 1e-3
    >>> search = uniform_parts(time, 0.05 + 0.01 * time)
    >>> round(search.longest.speed, 6)
    0.01
    """
    time, position = number_rows({"time": time, "position": position})
    window = positive_number(window, "window", "seconds")
    tolerance = positive_number(tolerance, "tolerance", "1, a share of the speed")
    stretches = _stretches(time, position, window)
    if not stretches:
        raise ValueError(f"a run of {len(time)} samples is shorter than one window of {window:g} s")
    uniform = [_is_uniform(stretch, tolerance, window) for stretch in stretches]
    groups: list[list[_Stretch]] = []
    before = False
    for stretch, good in zip(stretches, uniform, strict=True):
        if good and before and _joins(stretch, groups[-1], tolerance):
            groups[-1].append(stretch)
        elif good:
            groups.append([stretch])
        before = good
    noise = position_noise(position)
    parts = tuple(_part(time, position, group, noise) for group in groups)
    return UniformSearch(parts, "" if parts else _reason(stretches))


def _stretches(time: Array, position: Array, window: float) -> list[_Stretch]:
    samples = round(min(window / even_period(time), len(time) + 1))
    if samples < 5:
        return []
    noise = position_noise(position)
    firsts = range(0, len(time) - samples + 1, samples)
    return [_stretch(time, position, first, first + samples, noise) for first in firsts]


def _stretch(time: Array, position: Array, first: int, last: int, noise: float) -> _Stretch:
    centred = time[first:last] - time[first:last].mean()
    curve = np.polynomial.Polynomial.fit(centred, position[first:last], 2)
    residual = position[first:last] - curve(centred)
    # A position of exactly 0 throughout has no coefficients but the first.
    _, speed, half_acceleration = np.resize([*curve.convert().coef, 0.0, 0.0], 3)
    return _Stretch(
        first,
        last,
        speed=float(speed),
        error=noise / float(np.sqrt(np.sum(centred**2))),
        acceleration=float(2.0 * half_acceleration),
        roughness=float(np.sqrt(np.mean(residual**2))) / noise,
    )


def _is_uniform(stretch: _Stretch, tolerance: float, window: float) -> bool:
    """Whether speed varies over the stretch by no more than the tolerance or its own error."""
    change = abs(stretch.acceleration) * window
    # The change of speed over a window has about seven times the error of the mean speed.
    allowed = max(tolerance * abs(stretch.speed), 14.0 * stretch.error)
    small = 14.0 * stretch.error <= 0.5 * abs(stretch.speed)
    smooth = stretch.roughness <= LARGEST_ROUGHNESS or _noiseless(stretch)
    return stretch.moving and small and change <= allowed and smooth


def _noiseless(stretch: _Stretch) -> bool:
    """Whether what a parabola misses is far below what any sensor shows (noise-free runs)."""
    return stretch.error < 1e-3 * STANDSTILL


def _joins(stretch: _Stretch, group: list[_Stretch], tolerance: float) -> bool:
    mean = float(np.mean([member.speed for member in group]))
    return abs(stretch.speed - mean) <= 0.5 * tolerance * abs(mean)


def _part(time: Array, position: Array, group: list[_Stretch], noise: float) -> UniformPart:
    first, last = group[0].first, group[-1].last
    whole = _stretch(time, position, first, last, noise)
    return UniformPart(
        first,
        last,
        float(time[first]),
        float(time[last - 1]),
        whole.speed,
        whole.error,
        whole.acceleration,
    )


def _reason(stretches: list[_Stretch]) -> str:
    moving = np.array([stretch.moving for stretch in stretches])
    if not moving.any():
        return "the carriage never moves"
    stops = int(np.sum(moving[:-1] & ~moving[1:]))
    starts = int(np.sum(~moving[:-1] & moving[1:]))
    if (stops and starts > 1) or stops > 1:
        return f"stick-slip: the carriage stops {stops} times and starts again {starts} times"
    last = next(stretch for stretch in reversed(stretches) if stretch.moving)
    if last.roughness > LARGEST_ROUGHNESS:
        return "stick-slip: the motion is jerky throughout"
    return (
        f"never uniform: at {last.speed * 1e3:.3g} mm/s the speed still changes by "
        f"{last.acceleration * 1e3:.3g} mm/s²"
    )
