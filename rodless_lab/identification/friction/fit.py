# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction parameters of eq. (29) from uniform motion, breakaways and stops, by direction."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize, stats

from rodless_base.number_rows import LARGEST, measured_numbers, number_rows
from rodless_base.one_line import shown
from rodless_lab.identification.estimate import (
    Estimate,
    covariance,
    judged,
    symmetric,
    unknown,
    within,
)
from rodless_lab.identification.friction.auxiliary_lines import (
    LEAST_APART,
    AuxiliaryLines,
    auxiliary_lines,
)
from rodless_lab.identification.friction.bristle_motion import BristleMotion
from rodless_lab.identification.friction.curve import Stribeck
from rodless_lab.identification.friction.form import PRINTED, FrictionForm
from rodless_lab.identification.verdict import Check, Verdict, blocks, check_power, joined
from rodless_sim import RigParameters
from rodless_sim.single_number import single_number

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

# Draws of what the errors leave of a curve that fits, and their seed: a verdict is repeatable.
DRAWS = 400
SEED = 1

# Points of neighbouring speeds of which the median is taken.
GROUP = 3

# Residuals beyond this many standard errors count linearly instead of squared.
_ROBUST = 2.0

# Parts this precise (N) are taken as no more precise: the equation itself is no better.
_FINEST_ERROR = 1e-6

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

# How far eq. (30) may be from the friction of an almost uniform part (N), whatever the sensors.
FINEST_FORCE = 0.03

# What a force that drives the carriage in place of friction comes from.
SWAPPED = (
    "chambers A and B swapped, positions counted from the end of chamber B, or a pressure bias"
)

UNSTABLE = (
    "uniform runs lie right of the Stribeck minimum, where F_s and v_s have no effect; "
    "needs breakaways and stops from a slow ramp or stick-slip"
)
UNFINISHED = (
    "the points follow no straight line, and end before a Stribeck drop would: needs faster runs"
)
TOO_FEW = (
    "the points follow no straight line, and are too few to tell a Stribeck drop: needs more "
    "speeds, and breakaways and stops from a slow ramp or stick-slip"
)
NO_RUNS = "fewer than three parts of uniform motion in this direction"
ONE_SPEED = "all parts of uniform motion in this direction have one speed"
WIDE = "the data leaves it open within half its value"


@dataclass(frozen=True)
class DirectionFit:
    """Friction of one direction, magnitudes; the points it rests on, m/s and N, shape (n,).

    ``auxiliary`` is the paper's construction on the same points. ``breakaways`` are the forces
    at which the carriage let go, ``stops`` those at which it caught again (N). ``form`` is that of
    the curve; ``residuals`` are those of points, breakaways and stops, in this order, over their
    standard errors, and ``verdict`` what they say of the form.
    """

    static: Estimate
    coulomb: Estimate
    stribeck_velocity: Estimate
    viscous: Estimate
    auxiliary: AuxiliaryLines | None
    speeds: Array
    forces: Array
    breakaways: Array
    stops: Array
    form: FrictionForm = PRINTED
    residuals: Array = field(default_factory=lambda: np.empty(0))
    verdict: Verdict = field(default_factory=lambda: Verdict(()))

    @property
    def curve(self) -> Stribeck:
        """The fitted values for :func:`friction_force`; a drop not informed is left out."""
        coulomb = self.coulomb.value
        static = self.static.value if self.static.informed else coulomb
        velocity = self.stribeck_velocity.value
        if not (self.stribeck_velocity.informed and math.isfinite(velocity)):
            velocity, static = 1e-3, coulomb
        return Stribeck(static, coulomb, velocity, self.viscous.value)


@dataclass(frozen=True)
class FrictionFit:
    """Friction of both directions of motion."""

    forward: DirectionFit
    reverse: DirectionFit
    # Whether the carriage keeps still where friction holds it.
    rest: Verdict = field(default_factory=lambda: Verdict(()))

    @property
    def verdict(self) -> Verdict:
        """Whether the form follows the points of both directions, and nothing gives at rest."""
        return joined([self.forward.verdict, self.reverse.verdict, self.rest])


class _Observations(NamedTuple):
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


class _Solution(NamedTuple):
    values: Array
    jacobian: Array
    residuals: Array

    def variance(self, known: bool) -> float:
        """Variance of a residual: no less than 1 where the errors were known beforehand."""
        freedom = len(self.residuals) - len(self.values)
        if freedom < 1:
            return 1.0 if known else math.nan
        found = robust_sum(self.residuals) / freedom
        return max(found, 1.0) if known else found

    @property
    def freedom(self) -> int:
        return len(self.residuals) - len(self.values)


def fit_friction(
    speeds: npt.ArrayLike,
    forces: npt.ArrayLike,
    *,
    speed_errors: npt.ArrayLike | None = None,
    force_errors: npt.ArrayLike | None = None,
    breakaways: npt.ArrayLike = (),
    breakaway_errors: npt.ArrayLike | None = None,
    stops: npt.ArrayLike = (),
    stop_errors: npt.ArrayLike | None = None,
    form: FrictionForm = PRINTED,
    allowance: float = 0.0,
    motion: BristleMotion | None = None,
    force_bias: float = 0.0,
    speed_stretch: float = 0.0,
) -> FrictionFit:
    """Fit a form of friction, by default eq. (29), to points of uniform motion, per direction.

    By robust least squares.

    Standard errors, where given, weight the points; otherwise scatter about the curve is all that
    is known of them, and all are alike.

    A value that the plant cannot have, such as a viscous coefficient below 0, is not informed; a
    force that drives the carriage in place of friction does not fit.

    Parameters
    ----------
    speeds, forces
        Uniform motion in m/s and N (eq. (30)), shape (n,), signed like the motion.
    speed_errors, force_errors
        Standard errors, shape (n,) or one for all.
    breakaways, stops
        Forces in N, signed, shapes (k,) and (l,), at which the carriage lets go and catches again
        in slow stick-slip (:func:`stick_slip_events`): maximum and minimum of the curve's slow end,
        which uniform motion cannot reach.
    breakaway_errors, stop_errors
        Their standard errors.
    form
        The curve, its own constants taken as known.
    allowance
        How far (N, standard deviation) the reading of points may be off in a way that their errors
        do not hold; the verdict allows for it.
    motion
        The motion that bristles follow, its parts in the order of ``speeds``; None where there are
        no bristles.
    force_bias, speed_stretch
        How far (N) all forces may be off together, and all speeds as a share of themselves: bounds,
        by which the intervals are wider.

    Raises
    ------
    ValueError
        For shapes that differ, and what are no finite numbers, or errors or bounds below 0.

    Examples
    --------
    >>> speeds = np.linspace(4e-3, 40e-3, 12)
    >>> fit = fit_friction(speeds, 12.0 + 4500.0 * speeds, force_errors=0.1)
    >>> round(fit.forward.coulomb.value, 3), round(fit.forward.viscous.value, 3)
    (12.0, 4500.0)
    >>> fit.forward.static.informed, fit.reverse.viscous.informed
    (False, False)
    """
    speed, force = number_rows({"speeds": speeds, "forces": forces})
    given = speed_errors is not None or force_errors is not None
    speed_error = _errors(speed_errors, "speed_errors", speed, 0.0)
    force_error = _errors(force_errors, "force_errors", force, 0.0 if given else 1.0)
    away, stop = _row(breakaways, "breakaways"), _row(stops, "stops")
    default = float(np.median(force_error)) if len(force_error) else 1.0
    away_error = _errors(breakaway_errors, "breakaway_errors", away, default)
    stop_error = _errors(stop_errors, "stop_errors", stop, default)
    allowed = _bound(allowance, "allowance", "newtons")
    bias = _bound(force_bias, "force_bias", "newtons")
    stretch = _bound(speed_stretch, "speed_stretch", "the speeds' share")
    fits = []
    for sign, direction in ((1.0, "forward"), (-1.0, "reverse")):
        here, go, halt = sign * speed > 0.0, sign * away > 0.0, sign * stop > 0.0
        observations = _Observations(
            sign * speed[here],
            sign * force[here],
            speed_error[here],
            np.maximum(force_error[here], _FINEST_ERROR),
            sign * away[go],
            np.maximum(away_error[go], _FINEST_ERROR),
            sign * stop[halt],
            np.maximum(stop_error[halt], _FINEST_ERROR),
            given,
            form,
            allowed,
            direction,
            None if motion is None else motion.along(sign, here),
        )
        found = _fit_direction(observations)
        fits.append(_with_accuracy(found, bias, stretch, direction))
    forward, reverse = fits
    return FrictionFit(forward, reverse)


def _bound(value: float, name: str, unit: str) -> float:
    """Return the size of an error that all points may share; raises ValueError, TypeError."""
    number = single_number(value, name, unit)
    if not 0.0 <= number <= LARGEST:
        raise ValueError(f"{name} {shown(value)} refused: must be from 0 to {LARGEST:g}")
    return number


def _with_accuracy(fit: DirectionFit, force: float, stretch: float, direction: str) -> DirectionFit:
    """Return ``fit`` wider by ``force`` (N) and ``stretch``, and within what the plant can have."""
    of_force, of_scale = "bias of the pressure sensors", "nonlinearity of the scale"
    widened: dict[str, Any] = {
        name: _widened(getattr(fit, name), systematic, cause, LIMITS[name])
        for name, systematic, cause in (
            ("static", force, of_force),
            ("coulomb", force, of_force),
            ("stribeck_velocity", stretch * abs(fit.stribeck_velocity.value), of_scale),
            ("viscous", stretch * abs(fit.viscous.value), of_scale),
        )
    }
    if fit.coulomb.informed and widened["coulomb"].high < 0.0:
        widened["verdict"] = joined([fit.verdict, _pushing(widened["coulomb"], direction)])
    return replace(fit, **widened)


def _pushing(coulomb: Estimate, direction: str) -> Verdict:
    """Say that no friction was found, but a force that drives the carriage."""
    explained = max(coulomb.half_width, FINEST_FORCE)
    check = Check(
        f"force that drives the carriage {direction}", -coulomb.value, explained, "N", 0.0
    )
    return Verdict((check,), SWAPPED)


def _widened(
    estimate: Estimate, systematic: float, cause: str, limits: tuple[float, float]
) -> Estimate:
    if not estimate.informed or systematic == 0.0:
        return within(estimate, *limits)
    note = f"includes ±{systematic:.3g} {estimate.unit} for {cause}"
    return within(estimate.widened(systematic, note), *limits)


def _row(values: npt.ArrayLike, name: str) -> Array:
    """Return numbers in one row, also a single one; raises ValueError for others."""
    return number_rows({name: np.atleast_1d(measured_numbers(values, name))})[0]


def _errors(errors: npt.ArrayLike | None, name: str, of: Array, default: float) -> Array:
    """Return an error for each of the points ``of``, all ``default`` where none are given."""
    row = _row(default if errors is None else errors, name)
    if len(row) not in (1, len(of)):
        raise ValueError(f"{name}: {len(row)} values for {len(of)} points, must be as many, or one")
    if np.any(row < 0.0):
        raise ValueError(f"{name}: {float(row.min()):g} refused, must not be negative")
    return np.array(np.broadcast_to(row, of.shape))


def _fit_direction(points: _Observations) -> DirectionFit:
    if len(points.speeds) < 3:
        return _result(points, [unknown(unit, NO_RUNS) for unit in UNITS])
    if np.ptp(points.speeds) < LEAST_APART:
        return _result(points, [unknown(unit, ONE_SPEED) for unit in UNITS])
    line = _fit_line(points)
    full = _fit_curve(points, line)
    if full is None or not _curve_is_better(points, line, full):
        if not _line_is_enough(points, line):
            # As many values as points follow them all: of the form nothing is tested then.
            reason = TOO_FEW if full is None else UNFINISHED
            return _result(points, [unknown(unit, reason) for unit in UNITS], full)
        return _result(points, _line_estimates(points, line), line)
    return _result(points, _curve_estimates(points, full), full)


def _result(
    points: _Observations, estimates: Sequence[Estimate], solution: _Solution | None = None
) -> DirectionFit:
    breakaway = float(np.median(points.breakaways)) if len(points.breakaways) else None
    try:
        lines = auxiliary_lines(points.speeds, points.forces, breakaway)
    except ValueError:  # too few points, or too much alike
        lines = None
    static, coulomb, stribeck_velocity, viscous = estimates
    return DirectionFit(
        static=static,
        coulomb=coulomb,
        stribeck_velocity=stribeck_velocity,
        viscous=viscous,
        auxiliary=lines,
        speeds=points.speeds,
        forces=points.forces,
        breakaways=points.breakaways,
        stops=points.stops,
        form=points.form,
        residuals=np.empty(0) if solution is None else solution.residuals,
        verdict=Verdict(()) if solution is None else _verdict(points, solution),
    )


def robust_sum(residuals: Array) -> float:
    """Sum of squares of residuals, shape (n,), in which an outlier counts linearly (soft L1)."""
    scaled = (residuals / _ROBUST) ** 2
    return float(np.sum(2.0 * _ROBUST**2 * (np.sqrt(1.0 + scaled) - 1.0)))


def _solved(
    residuals: Callable[[Array], Array], start: Array, bounds: tuple[Array, Array], scale: Array
) -> _Solution:
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
    return _Solution(np.asarray(found.x), np.asarray(found.jac), residuals(found.x))


def _rough_line(points: _Observations, chosen: npt.NDArray[np.intp]) -> tuple[float, float]:
    """F_c and B of the form without its drop, by the median slope through ``chosen`` points."""
    form, speeds = points.form, points.speeds[chosen]
    rest = form.force(_dropless(np.zeros(2)), speeds)
    of_viscous = form.force(_dropless(np.array([0.0, 1.0])), speeds) - rest
    slope, intercept, *_ = stats.theilslopes(points.forces[chosen] - rest, of_viscous)
    return float(intercept), float(slope)


def _fit_line(points: _Observations) -> _Solution:
    """Fit F_c and B of the form without its drop, values in that order: it is linear in both."""
    intercept, slope = _rough_line(points, np.arange(len(points.speeds)))
    steepness = points.form.slope(_dropless(np.array([intercept, slope])), points.speeds)
    error = np.hypot(points.force_errors, steepness * points.speed_errors)

    def residuals(values: Array) -> Array:
        return np.asarray(
            (points.forces - points.form.force(_dropless(values), points.speeds)) / error
        )

    bounds = (np.full(2, -np.inf), np.full(2, np.inf))
    return _solved(residuals, np.array([intercept, slope]), bounds, np.array([10.0, 1e3]))


def _dropless(values: Array) -> Stribeck:
    """Return the curve of F_c and B alone: with F_s = F_c there is no drop, whatever v_s."""
    return Stribeck(values[0], values[0], 1e-3, values[1])


def _verdict(points: _Observations, solution: _Solution) -> Verdict:
    """Hold the residuals, where their errors are known, against draws of such errors.

    Each by itself without the worst tenth, and as medians of neighbours in speed: a wild point or
    two does not make the curve another, while a curve of another shape leaves neighbours alike.
    """
    if not points.known or solution.freedom < 1:
        return Verdict(())
    share = _share_of_errors(points, solution)
    residuals, jacobian = share * solution.residuals, share[:, None] * solution.jacobian
    blind = np.eye(len(jacobian)) - jacobian @ linalg.pinv(jacobian)
    generator = np.random.default_rng(SEED)
    drawn = generator.standard_normal((DRAWS, len(jacobian))) @ blind
    order = np.argsort(points.speeds)
    checks = [_check("residuals", residuals, drawn, _trimmed, points.direction)]
    if len(order) >= 2 * GROUP:
        found, expected = residuals[order], drawn[:, order]
        name = "residuals of neighbours in speed"
        checks.append(_check(name, found, expected, _of_neighbours, points.direction))
    return Verdict(tuple(checks))


def _share_of_errors(points: _Observations, solution: _Solution) -> Array:
    """Part of each standard error in that with the allowance, shape of the residuals."""
    coulomb, viscous = solution.values[[-3, -1]] if len(solution.values) > 2 else solution.values
    slope = points.form.slope(_dropless(np.array([coulomb, viscous])), points.speeds)
    error = np.hypot(points.force_errors, slope * points.speed_errors)
    share = np.ones(len(solution.residuals))
    share[: len(error)] = error / np.hypot(error, points.allowance)
    return share


def _check(
    name: str, found: Array, drawn: Array, square: Callable[[Array], Array], direction: str
) -> Check:
    """Compare a mean ``square`` along the last axis with that of the draws."""
    unit = "standard errors"
    return check_power(f"{name} {direction}", float(square(found)), square(drawn), unit, 1.0)


def _trimmed(residuals: Array) -> Array:
    """Mean square without the worst tenth."""
    squares = np.sort(residuals**2, axis=-1)
    kept = squares.shape[-1] - max(squares.shape[-1] // 10, 1)
    return np.asarray(np.mean(squares[..., :kept], axis=-1))


def _of_neighbours(residuals: Array) -> Array:
    """Mean square of the medians of GROUP neighbours."""
    return np.asarray(np.mean(np.median(blocks(residuals, GROUP), axis=-1) ** 2, axis=-1))


def _curve_residuals(points: _Observations, line: _Solution) -> Callable[[Array], Array]:
    form = points.form
    slope = form.slope(_dropless(line.values), points.speeds)
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


def _fit_curve(points: _Observations, line: _Solution) -> _Solution | None:
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


def _curve_is_better(points: _Observations, line: _Solution, full: _Solution) -> bool:
    """Whether the Stribeck drop shows in the data: by its own observations, or by an F test."""
    if float(np.max(points.speeds)) < _FINISHED * full.values[2]:
        return False
    if len(points.breakaways) or len(points.stops):
        return True
    gain = robust_sum(line.residuals) - robust_sum(full.residuals)
    statistic = gain / 2.0 / max(full.variance(points.known), 1e-300)
    return bool(stats.f.sf(statistic, 2, full.freedom) < _SIGNIFICANCE)


def _line_is_enough(points: _Observations, line: _Solution) -> bool:
    """Whether a line misses the points by no more than their errors, where those are known."""
    if not points.known or line.freedom < 1:
        return True
    # Without the worst tenth: a wild point or two does not make the curve another.
    kept = np.sort(np.abs(line.residuals))[: -max(len(line.residuals) // 10, 1)]
    return bool(stats.chi2.sf(robust_sum(kept), line.freedom) > 1e-3)


def _line_estimates(points: _Observations, line: _Solution) -> list[Estimate]:
    errors = np.sqrt(np.diag(covariance(line.jacobian, line.variance(points.known))))
    coulomb, viscous = (
        symmetric(float(value), float(error), line.freedom, unit)
        for value, error, unit in zip(line.values, errors, ("N", "N·s/m"), strict=True)
    )
    return [_static_alone(points), coulomb, unknown("m/s", UNSTABLE), viscous]


def _static_alone(points: _Observations) -> Estimate:
    """F_s from breakaways without the rest of the curve: never above them."""
    if not len(points.breakaways):
        return unknown("N", UNSTABLE)
    mean = float(np.mean(points.breakaways))
    error = float(np.max(points.breakaway_errors) / math.sqrt(len(points.breakaways)))
    return symmetric(mean, error, len(points.breakaways) - 1, "N")


def _curve_estimates(points: _Observations, full: _Solution) -> list[Estimate]:
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


def _shift_of_velocity(points: _Observations, full: _Solution) -> float:
    """How far (m/s) v_s moves where all points on the drop are off by the same force.

    As far as the allowance, at most: their errors are those of one motion, and do not average out.
    """
    on_the_drop = points.speeds < _DROP_REACHES * full.values[2]
    error = points.force_errors
    shift = np.zeros(len(full.residuals))
    shift[: len(error)] = np.where(on_the_drop, _MOST_OF_ALLOWANCE * points.allowance, 0.0) / error
    return abs(float((linalg.pinv(full.jacobian) @ shift)[2]))
