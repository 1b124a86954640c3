# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Grey-box fit of valve and chambers: the rig's own equations against measured pressures."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize

from rodless_base.parameters import ParameterError
from rodless_lab.identification.estimate import Estimate, covariance, judged, symmetric, within
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.plausible import check_run
from rodless_lab.identification.pressures.problem import (
    FINEST_PRESSURE,
    Problem,
    Unknown,
    reading_noise,
)
from rodless_lab.identification.pressures.unknowns import HYSTERESIS, SPOOL_START, spool_start
from rodless_lab.identification.verdict import (
    BEYOND_STATED,
    ZEROED,
    Check,
    Verdict,
    span_checks,
)
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant

Array = npt.NDArray[np.float64]

SUPPLY = "supply.pressure"

# Whose bias each of the last values is.
SENSORS = ("chamber A", "chamber B", "the supply")

# s between samples, at the most: a chamber fills in a few times that, and fits to samples farther
# apart go on for hours.
MOST_BETWEEN_SAMPLES = 0.1

# A run whose pressures stay within this many standard deviations of their noise informs nothing.
LEAST_CHANGE = 20.0

# Standard errors are those of a linear model with Gaussian errors, which neither the chambers nor a
# sensor's bound are; in 100 hidden rigs they came out true, and this is the margin on top.
MARGIN = 1.2

# Relative step of the solver's finite differences.
DIFFERENCE = 1e-5

# Below this share of its natural size a value is 0, and its step is this share.
AT_ZERO = 1e-6
STEP_AT_ZERO = 1e-3

# Residuals beyond this many standard errors count linearly instead of squared.
ROBUST = 3.0

# Draws of what the sensors leave of a model that fits, and their seed: a verdict is repeatable.
DRAWS = 100
SEED = 1


@dataclass(frozen=True)
class Solution:
    """What least squares found, before it is judged.

    The model is that of ``parameters`` with ``unknowns`` fitted. ``values``, shape (p,), are those
    of the problem; ``residuals``, shape (2 m,), and ``jacobian`` are over the standard errors.
    ``cost`` is the robust sum of squares left, ``spread`` what one of ``freedom`` degrees of
    freedom has of it.
    """

    problem: Problem
    parameters: RigParameters
    unknowns: Sequence[Unknown]
    values: Array
    residuals: Array
    jacobian: Array
    cost: float
    inflation: float

    @property
    def variance(self) -> float:
        """Variance of a residual, no less than the sensors' own."""
        count = self.problem.readings - len(self.values)
        return max(float(self.residuals @ self.residuals) / count, 1.0)

    @property
    def spread(self) -> float:
        """Variance of a residual, times what its correlation in time adds to that of a mean."""
        return self.variance * self.inflation

    @property
    def freedom(self) -> float:
        """Number of residuals that are independent, less what was fitted."""
        return (self.problem.readings - len(self.values)) / self.inflation

    @property
    def sizes(self) -> list[tuple[Unknown, float]]:
        """The unknowns, each with its value."""
        return list(zip(self.unknowns, self.values.tolist(), strict=False))

    @property
    def found(self) -> dict[str, float]:
        """The unknowns by name."""
        return {unknown.name: value for unknown, value in self.sizes}


@dataclass(frozen=True)
class PressureFit:
    """Estimates by name, and how the model follows the run.

    ``pressure_a`` and ``pressure_b`` (Pa, shape (n,)) are the model's readings; ``scatter`` (Pa) is
    that of the measured about them; ``correlation_time`` (s) that of the scatter. ``verdict`` says
    whether the sensors explain them; ``solution`` is what least squares found.
    """

    estimates: Mapping[str, Estimate]
    pressure_a: Array
    pressure_b: Array
    scatter: float
    correlation_time: float
    verdict: Verdict
    solution: Solution


def fit_pressures(
    run: MeasuredRun,
    parameters: RigParameters,
    unknowns: Sequence[Unknown],
    rest: Array | None = None,
) -> PressureFit:
    """Fit ``unknowns`` to the chamber pressures of ``run``; everything else is as ``parameters``.

    ``rest`` is as in :func:`solve`.

    Intervals come from the Jacobian and the scatter of the residuals, widened by how far these are
    correlated in time, and by the bias of the sensors as ``parameters`` state it. Raises
    :class:`UninformativeRunError` where no pressure changes.
    """
    return fit_of(solve(run, parameters, unknowns, rest))


def fit_of(solution: Solution) -> PressureFit:
    """Return the intervals and the verdict of what least squares found."""
    problem, values = solution.problem, solution.values
    modelled = problem.modelled(values)
    return PressureFit(
        estimates_of(solution),
        modelled[:, 0],
        modelled[:, 1],
        float(np.std(solution.residuals)) * problem.noise,
        solution.inflation * problem.spacing,
        _verdict(solution),
        solution,
    )


def solve(
    run: MeasuredRun,
    parameters: RigParameters,
    unknowns: Sequence[Unknown],
    rest: Array | None = None,
    known: Sequence[tuple[Unknown, float]] = (),
) -> Solution:
    """Minimise the residuals; raises as :func:`fit_pressures`.

    Raises RunError, too, for a run that is of no such rig.

    The search begins at ``rest`` for what is fitted beside ``unknowns``, where it has as many.
    ``known`` have the sizes given, whatever ``parameters`` say.
    """
    check_run(run, parameters, longest=MOST_BETWEEN_SAMPLES)
    plant = Plant.of(parameters)
    rippling = parameters.number("supply.ripple_amplitude") > 0.0
    if plant.tubes or rippling or (plant.full and plant.full.supply.acting):
        raise ParameterError(
            "tubes.model, supply.ripple_amplitude, supply.droop, supply.kind: refused, the fit "
            "takes air to arrive at once, and the supply to have the mean of its readings; "
            "identify without"
        )
    has_play = parameters.number(HYSTERESIS) > 0.0
    if has_play and SPOOL_START not in {unknown.name for unknown in unknowns}:
        unknowns = [*unknowns, spool_start()]
    check_change(run, parameters)
    problem = Problem(run, parameters, unknowns, known)
    start = problem.start.copy()
    if rest is not None and len(rest) == len(start) - len(unknowns):
        start[len(unknowns) :] = rest
    # In natural sizes, so that the solver's finite differences suit every one.
    scale = problem.scale

    def residuals_of(scaled: Array) -> Array:
        return problem.residuals(scaled * scale)

    found = optimize.least_squares(
        residuals_of,
        np.clip(start, *problem.bounds) / scale,
        bounds=(problem.bounds[0] / scale, problem.bounds[1] / scale),
        diff_step=np.full(scale.shape, DIFFERENCE),
        loss="soft_l1",
        f_scale=ROBUST,
        xtol=1e-7,
        ftol=1e-7,
        gtol=1e-7,
        max_nfev=200,
    )
    values = np.asarray(found.x) * scale
    residuals = problem.residuals(values)[: problem.readings]
    inflation = _correlation(residuals.reshape(2, -1))
    scaled, solved = np.asarray(found.x), np.asarray(found.jac)
    jacobian = _jacobian(residuals_of, scaled, solved, problem.blur) / scale
    cost = 2.0 * float(found.cost)
    return Solution(problem, parameters, unknowns, values, residuals, jacobian, cost, inflation)


def check_change(run: MeasuredRun, parameters: RigParameters) -> None:
    """Raise UninformativeRunError where the pressures of ``run`` stay within their noise."""
    change = max(float(np.ptp(run.pressure_a)), float(np.ptp(run.pressure_b)))
    least = LEAST_CHANGE * reading_noise(parameters)
    if change < least:
        raise UninformativeRunError(
            f"the pressures change by only {change:.3g} Pa, of {least:.3g} Pa that tell anything: "
            "record a run of `rodless drive`"
        )


def _jacobian(
    residuals_of: Callable[[Array], Array], scaled: Array, found: Array, blur: Array
) -> Array:
    """Return the solver's Jacobian with the columns of what ended at 0 made anew.

    The solver's steps are relative, and vanish there: a column would be 0, the interval endless.
    Rows are weighted as the solver weights them for its loss. ``scaled`` and ``blur`` are in
    natural sizes.
    """
    at_zero = np.flatnonzero(np.abs(scaled) < np.maximum(blur, AT_ZERO))
    if not len(at_zero):
        return found
    jacobian: Array = found.copy()
    residuals = residuals_of(scaled)
    weight = (1.0 + (residuals / ROBUST) ** 2) ** -0.75
    for column in at_zero:
        beside = scaled.copy()
        step = max(float(blur[column]), STEP_AT_ZERO)
        beside[column] += step
        jacobian[:, column] = weight * (residuals_of(beside) - residuals) / step
    return jacobian


def _errors(solution: Solution) -> Array:
    """Return the standard errors of the values, shape (p,), with their margin."""
    # What is known beforehand of the biases does not share the residuals' scatter.
    jacobian = solution.jacobian.copy()
    jacobian[: solution.problem.readings] /= math.sqrt(solution.spread)
    return np.asarray(MARGIN * np.sqrt(np.diag(covariance(jacobian, 1.0))))


def estimates_of(solution: Solution) -> dict[str, Estimate]:
    """Return the intervals of the unknowns and of the supply pressure, by name."""
    problem, values, errors = solution.problem, solution.values, _errors(solution)
    estimates = {
        unknown.name: _estimate(unknown, float(value), float(error), solution.freedom)
        for unknown, value, error in zip(solution.unknowns, values, errors, strict=False)
    }
    pressure = problem.supply - float(values[-1])
    supply = symmetric(pressure, float(errors[-1]), solution.freedom, "Pa")
    declared = RigParameters.DECLARATIONS[SUPPLY]
    # A run may have more than a plant that loads the file can.
    estimates[SUPPLY] = within(supply, declared.minimum, declared.maximum)
    return estimates


def _estimate(unknown: Unknown, value: float, error: float, freedom: float) -> Estimate:
    """Return the interval of an unknown within its range; of a small one how large it may be."""
    found = symmetric(value, error, freedom, unknown.unit)
    note = "the run leaves it open within half its value"
    if unknown.low == 0.0 and found.low <= 0.0 and math.isfinite(found.high):
        note = f"not told from 0, and at most {found.high:.3g} {unknown.unit}".rstrip()
    return within(judged(found, note), unknown.low, unknown.high)


def _verdict(solution: Solution) -> Verdict:
    """Hold the residuals against draws of what the sensors leave of such a fit.

    The fit takes out of each draw what its parameters can follow, as it did of the run. What it
    takes for a sensor's bias is held against what is stated of that.
    """
    problem, residuals = solution.problem, solution.residuals
    generator = np.random.default_rng(SEED)
    drawn = problem.draws(solution.values, DRAWS, generator).reshape(DRAWS, -1)
    explained = left_of(drawn, problem, solution.jacobian)
    supply = problem.supply_residuals()
    still = generator.standard_normal((DRAWS, len(supply)))
    still -= still.mean(axis=1, keepdims=True)
    compared = (
        ("scatter of the pressures", residuals.reshape(2, -1), explained),
        ("scatter of the supply", supply, still),
    )
    verdict = Verdict(tuple(span_checks(compared, problem.spacing, "Pa", problem.noise)))
    return with_biases(verdict, solution)


def with_biases(verdict: Verdict, solution: Solution, times: float = 1.0) -> Verdict:
    """Return ``verdict``; one that fits not with biases beyond ``times`` what is stated.

    A model that does not fit may bend the biases: then they say nothing.
    """
    beyond = _biases(solution, times) if verdict.fits else []
    return Verdict((*verdict.checks, *beyond), ZEROED) if beyond else verdict


def _biases(solution: Solution, times: float) -> list[Check]:
    """Return the biases of pressure sensors that are surely beyond ``times`` what is stated."""
    stated = max(solution.problem.bias, FINEST_PRESSURE)
    sizes = np.abs(solution.values[-3:])
    beyond = sizes > times * stated + BEYOND_STATED * _errors(solution)[-3:]
    return [
        Check(f"bias of the sensor of {name}", float(size), stated, "Pa", 0.0)
        for name, size, is_beyond in zip(SENSORS, sizes, beyond, strict=True)
        if is_beyond
    ]


def left_of(drawn: Array, problem: Problem, jacobian: Array) -> Array:
    """Return draws, shape (DRAWS, 2 m), less what a fit can follow, shape (DRAWS, 2, m)."""
    # In natural sizes, so that none is taken for nothing.
    jacobian = jacobian * problem.scale
    solved = linalg.pinv(jacobian)[:, : problem.readings]
    kept: Array = drawn - drawn @ solved.T @ jacobian[: problem.readings].T
    return kept.reshape(DRAWS, 2, -1)


def _correlation(residuals: Array) -> float:
    """Factor by which correlation in time multiplies a mean's variance; residuals shape (2, n).

    One plus twice the sum of the autocorrelation up to its first value within chance of zero.
    """
    factors = []
    for row in residuals:
        centred = row - row.mean()
        power = float(centred @ centred)
        if power == 0.0:
            return 1.0
        longest = len(row) // 4
        spectrum = np.fft.rfft(centred, 2 * len(row))
        correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:longest] / power
        chance = np.flatnonzero(correlation < 2.0 / math.sqrt(len(row)))
        last = int(chance[0]) if len(chance) else longest
        factors.append(1.0 + 2.0 * float(np.sum(correlation[1:last])))
    return max(*factors, 1.0)


def findings_of(fit: PressureFit, names: Sequence[str]) -> list[Finding]:
    """Return the parameters ``names`` as the fit has them."""
    return [
        Finding(name, estimate.value if estimate.informed else None, {name: estimate})
        for name in names
        for estimate in [fit.estimates[name]]
    ]
