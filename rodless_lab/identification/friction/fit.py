# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction parameters of eq. (29) from uniform motion, breakaways and stops, by direction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.number_rows import LARGEST, measured_numbers, number_rows
from rodless_base.one_line import shown
from rodless_lab.identification.estimate import (
    Estimate,
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
from rodless_lab.identification.friction.curve_fit import (
    LIMITS,
    UNITS,
    Observations,
    Solution,
    curve_estimates,
    curve_is_better,
    fit_curve,
    fit_line,
    line_estimates,
    line_is_enough,
)
from rodless_lab.identification.friction.form import PRINTED, FrictionForm
from rodless_lab.identification.friction.residual_checks import verdict_of_residuals
from rodless_lab.identification.verdict import Check, Verdict, joined
from rodless_sim.single_number import single_number

Array = npt.NDArray[np.float64]

# Parts this precise (N) are taken as no more precise: the equation itself is no better.
_FINEST_ERROR = 1e-6

# How far eq. (30) may be from the friction of an almost uniform part (N), whatever the sensors.
FINEST_FORCE = 0.03

# What a force that drives the carriage in place of friction comes from.
SWAPPED = (
    "chambers A and B swapped, positions counted from the end of chamber B, or a pressure bias"
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
        observations = Observations(
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


def _fit_direction(points: Observations) -> DirectionFit:
    if len(points.speeds) < 3:
        return _result(points, [unknown(unit, NO_RUNS) for unit in UNITS])
    if np.ptp(points.speeds) < LEAST_APART:
        return _result(points, [unknown(unit, ONE_SPEED) for unit in UNITS])
    line = fit_line(points)
    full = fit_curve(points, line)
    if full is None or not curve_is_better(points, line, full):
        if not line_is_enough(points, line):
            # As many values as points follow them all: of the form nothing is tested then.
            reason = TOO_FEW if full is None else UNFINISHED
            return _result(points, [unknown(unit, reason) for unit in UNITS], full)
        return _result(points, line_estimates(points, line), line)
    return _result(points, curve_estimates(points, full), full)


def _result(
    points: Observations, estimates: Sequence[Estimate], solution: Solution | None = None
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
        verdict=Verdict(()) if solution is None else verdict_of_residuals(points, solution),
    )
