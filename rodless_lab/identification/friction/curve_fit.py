# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Least squares for one direction of motion: the form of friction, or a line without its drop."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize, stats

from rodless_lab.identification.estimate import (
    Estimate,
    covariance,
    judged,
    symmetric,
    unknown,
    within,
)
from rodless_lab.identification.friction.bristle_motion import BristleMotion
from rodless_lab.identification.friction.curve import Stribeck
from rodless_lab.identification.friction.form import PRINTED, FrictionForm
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# Of F_s, F_c, v_s, B: natural size for the solver; unit and bounds as the plant declares them,
# the same for both directions.
_SCALE = np.array([10.0, 10.0, 1e-3, 1e3])
_DECLARED = [RigParameters.DECLARATIONS[f"friction.forward.{name}"] for name in Stribeck._fields]
UNITS = [parameter.unit for parameter in _DECLARED]
_LOW = np.array([parameter.minimum for parameter in _DECLARED])
_HIGH = np.array([parameter.maximum for parameter in _DECLARED])

# The same by name: (least, greatest).
LIMITS = dict(zip(Stribeck._fields, zip(_LOW.tolist(), _HIGH.tolist(), strict=True), strict=True))

# Stribeck velocities (m/s) the search starts from; the cost has a minimum of its own near many.
_STARTS = np.geomspace(5e-4, 1.2e-2, 6)

# Residuals beyond this many standard errors count linearly instead of squared.
_ROBUST = 2.0

# The curve is preferred to a straight line if chance would do as well in one case of ten: a drop
# that is overlooked spoils F_c and B, one that is not there only widens their intervals.
_SIGNIFICANCE = 0.1

# How many times the allowance, a root mean square, the points on the drop are off together at most:
# 0.1 N on this rig, 0.2 N with a bore of 15 mm. Those are slower than so many Stribeck velocities.
_MOST_OF_ALLOWANCE = 3.5
_DROP_REACHES = 3.0

# The drop is over at this many Stribeck velocities. If the runs end before, what the curve follows
# is something else.
_FINISHED = 2.0

UNSTABLE = (
    "uniform runs lie right of the Stribeck minimum, where F_s and v_s have no effect; "
    "needs breakaways and stops from a slow ramp or stick-slip"
)
WIDE = "the data leaves it open within half its value"


class Observations(NamedTuple):
    """Magnitudes of one direction with standard errors; ``known`` if those were given."""

    speeds: Array
    forces: Array
    speed_errors: Array
    force_errors: Array
    breakaways: Array
    breakaway_errors: Array
    stops: Array
    stop_errors: Array
    known: bool
    form: FrictionForm
    allowance: float
    direction: str
    motion: BristleMotion | None

    def curve_forces(self, curve: Stribeck) -> Array:
        """Forces (N) at the points where friction is ``curve``: of bristles, if there are any."""
        if self.motion is None:
            return self.form.force(curve, self.speeds)
        return self.motion.forces(self.form, curve)


class Solution(NamedTuple):
    """Fitted values (p,), residuals (n,) over their standard errors, and their Jacobian (n, p)."""

    values: Array
    jacobian: Array
    residuals: Array

    def variance(self, known: bool) -> float:
        """Variance of a residual: no less than 1 where the errors were known beforehand."""
        if self.freedom < 1:
            return 1.0 if known else math.nan
        found = robust_sum(self.residuals) / self.freedom
        return max(found, 1.0) if known else found

    @property
    def freedom(self) -> int:
        """How many residuals there are beyond the values."""
        return len(self.residuals) - len(self.values)


def robust_sum(residuals: Array) -> float:
    """Sum of squares of residuals, shape (n,), in which an outlier counts linearly (soft L1)."""
    scaled = (residuals / _ROBUST) ** 2
    return float(np.sum(2.0 * _ROBUST**2 * (np.sqrt(1.0 + scaled) - 1.0)))


def _solved(
    residuals: Callable[[Array], Array], start: Array, bounds: tuple[Array, Array], scale: Array
) -> Solution:
    inside = np.clip(start, bounds[0] + 1e-9 * scale, bounds[1] - 1e-9 * scale)
    found = optimize.least_squares(
        residuals,
        inside,
        bounds=bounds,
        x_scale=scale,
        loss="soft_l1",
        f_scale=_ROBUST,
        xtol=1e-9,
        ftol=1e-9,
        gtol=1e-9,
        max_nfev=100,
    )
    return Solution(np.asarray(found.x), np.asarray(found.jac), residuals(found.x))


def _rough_line(points: Observations, chosen: npt.NDArray[np.intp]) -> tuple[float, float]:
    """F_c and B of the form without its drop, by the median slope through ``chosen`` points."""
    form, speeds = points.form, points.speeds[chosen]
    rest = form.force(dropless(np.zeros(2)), speeds)
    of_viscous = form.force(dropless(np.array([0.0, 1.0])), speeds) - rest
    slope, intercept, *_ = stats.theilslopes(points.forces[chosen] - rest, of_viscous)
    return float(intercept), float(slope)


def fit_line(points: Observations) -> Solution:
    """Fit F_c and B of the form without its drop, values in that order: it is linear in both."""
    intercept, slope = _rough_line(points, np.arange(len(points.speeds)))
    steepness = points.form.slope(dropless(np.array([intercept, slope])), points.speeds)
    error = np.hypot(points.force_errors, steepness * points.speed_errors)

    def residuals(values: Array) -> Array:
        return np.asarray(
            (points.forces - points.form.force(dropless(values), points.speeds)) / error
        )

    bounds = (np.full(2, -np.inf), np.full(2, np.inf))
    return _solved(residuals, np.array([intercept, slope]), bounds, np.array([10.0, 1e3]))


def dropless(values: Array) -> Stribeck:
    """Return the curve of F_c and B alone: with F_s = F_c there is no drop, whatever v_s."""
    return Stribeck(values[0], values[0], 1e-3, values[1])


def _curve_residuals(points: Observations, line: Solution) -> Callable[[Array], Array]:
    form = points.form
    slope = form.slope(dropless(line.values), points.speeds)
    error = np.hypot(points.force_errors, slope * points.speed_errors)

    def residuals(values: Array) -> Array:
        curve = Stribeck(*values)
        ends = form.turning_points(curve)
        return np.concatenate(
            [
                (points.forces - points.curve_forces(curve)) / error,
                (points.breakaways - ends.hump) / points.breakaway_errors,
                (points.stops - ends.valley) / points.stop_errors,
            ]
        )

    return residuals


def fit_curve(points: Observations, line: Solution) -> Solution | None:
    """Fit eq. (29), values (F_s, F_c, v_s, B); None where there are no more points than values."""
    if len(points.speeds) + len(points.breakaways) + len(points.stops) <= 4:
        return None
    residuals = _curve_residuals(points, line)
    intercept, slope = max(line.values[0], 0.0), max(line.values[1], 0.0)
    slowest = points.forces[np.argmin(points.speeds)]
    top = np.median(points.breakaways) if len(points.breakaways) else max(slowest, intercept + 1.0)
    lines = [(intercept, slope)]
    if points.form.name != PRINTED.name:
        # Where the viscous force bends, the drop is no small part of the line through all points.
        fast = np.argsort(points.speeds)[len(points.speeds) // 2 :]
        coulomb, viscous = _rough_line(points, fast)
        lines.append((max(coulomb, 0.0), max(viscous, 0.0)))
    solutions = [
        _solved(residuals, np.array([top, begin[0], velocity, begin[1]]), (_LOW, _HIGH), _SCALE)
        for begin in lines
        for velocity in _STARTS
    ]
    return min(solutions, key=lambda solution: robust_sum(solution.residuals))


def curve_is_better(points: Observations, line: Solution, full: Solution) -> bool:
    """Whether the Stribeck drop shows in the data: by its own observations, or by an F test."""
    if float(np.max(points.speeds)) < _FINISHED * full.values[2]:
        return False
    if len(points.breakaways) or len(points.stops):
        return True
    gain = robust_sum(line.residuals) - robust_sum(full.residuals)
    statistic = gain / 2.0 / max(full.variance(points.known), 1e-300)
    return bool(stats.f.sf(statistic, 2, full.freedom) < _SIGNIFICANCE)


def line_is_enough(points: Observations, line: Solution) -> bool:
    """Whether a line misses the points by no more than their errors, where those are known."""
    if not points.known or line.freedom < 1:
        return True
    # Without the worst tenth: a wild point or two does not make the curve another.
    kept = np.sort(np.abs(line.residuals))[: -max(len(line.residuals) // 10, 1)]
    return bool(stats.chi2.sf(robust_sum(kept), line.freedom) > 1e-3)


def line_estimates(points: Observations, line: Solution) -> list[Estimate]:
    """Return F_s, F_c, v_s and B where no drop shows: v_s is unknown, F_s by breakaways alone."""
    errors = np.sqrt(np.diag(covariance(line.jacobian, line.variance(points.known))))
    coulomb, viscous = (
        symmetric(float(value), float(error), line.freedom, unit)
        for value, error, unit in zip(line.values, errors, ("N", "N·s/m"), strict=True)
    )
    return [_static_alone(points), coulomb, unknown("m/s", UNSTABLE), viscous]


def _static_alone(points: Observations) -> Estimate:
    """F_s from breakaways without the rest of the curve: never above them."""
    if not len(points.breakaways):
        return unknown("N", UNSTABLE)
    mean = float(np.mean(points.breakaways))
    error = float(np.max(points.breakaway_errors) / math.sqrt(len(points.breakaways)))
    return symmetric(mean, error, len(points.breakaways) - 1, "N")


def curve_estimates(points: Observations, full: Solution) -> list[Estimate]:
    """Return F_s, F_c, v_s and B of the whole curve, within what the plant can have."""
    errors = np.sqrt(np.diag(covariance(full.jacobian, full.variance(points.known))))
    static, coulomb, velocity, viscous = (
        symmetric(float(value), float(error), full.freedom, unit)
        for value, error, unit in zip(full.values, errors, UNITS, strict=True)
    )
    systematic = _shift_of_velocity(points, full)
    if systematic > 0.0:
        note = f"includes ±{systematic:.3g} m/s for motion that is not quite uniform"
        velocity = velocity.widened(systematic, note)
    return [
        within(judged(estimate, WIDE), low, high)
        for estimate, low, high in zip(
            (static, coulomb, velocity, viscous), _LOW, _HIGH, strict=True
        )
    ]


def _shift_of_velocity(points: Observations, full: Solution) -> float:
    """How far (m/s) v_s moves where all points on the drop are off by the same force.

    As far as the allowance, at most: their errors are those of one motion, and do not average out.
    """
    on_the_drop = points.speeds < _DROP_REACHES * full.values[2]
    error = points.force_errors
    shift = np.zeros(len(full.residuals))
    shift[: len(error)] = np.where(on_the_drop, _MOST_OF_ALLOWANCE * points.allowance, 0.0) / error
    return abs(float((linalg.pinv(full.jacobian) @ shift)[2]))
