# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Stiffness and damping of the bristles of friction, from how far a carriage gives way.

Below breakaway the carriage moves by about F/σ₀, a tenth of a millimetre, and lets back. The
pressures say what F is, and the position, noisy as it is, agrees with one σ₀ over thousands of
samples. The stiffness is searched by its inverse, in which a carriage that sticks is a number, 0,
and not infinity. The damping σ₁ acts beside the viscous coefficient B, which is some times as much:
it is told apart where the carriage slides faster than the bristles' damping lasts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize

from rodless_base.parameters import ParameterError
from rodless_lab.identification.bristles.problem import (
    BIAS,
    BRISTLE_DAMPING,
    COMPLIANCE,
    FORWARD,
    REVERSE,
    Problem,
)
from rodless_lab.identification.estimate import Estimate, judged, symmetric, within
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.plausible import check_run
from rodless_lab.identification.verdict import (
    BEYOND_STATED,
    ZEROED,
    Check,
    Verdict,
    power,
    span_checks,
)
from rodless_lab.runs.measured_run import (
    FEWEST_SAMPLES,
    MeasuredRun,
    UninformativeRunError,
)
from rodless_sim import RigParameters
from rodless_sim.physics.bristles import LUGRE
from rodless_sim.physics.plant import Plant

Array = npt.NDArray[np.float64]

FORM = "friction.dynamics"
STIFFNESS = "friction.bristle_stiffness"
DAMPING = "friction.bristle_damping"

# A run whose force stays within this (N) moves no bristles that could be seen.
LEAST_FORCE = 3.0

# Bristles that may be this stiff (N/m) are not told from a carriage that sticks: F_s moves them by
# 3 µm, and seals are some fifty times softer.
STICKING = 1e7

# Residuals beyond this many standard errors count linearly instead of squared.
ROBUST = 3.0

# Shares of a run that are fitted one after another before the whole.
SHARES = (0.1, 0.3, 0.6, 1.0)


class _Start(NamedTuple):
    """Where a further search begins: the stiffness (N/m), whose friction, shares of the run."""

    stiffness: float
    as_found: bool
    shares: tuple[float, ...]


# Where further searches begin, if what was found does not fit: next to sticking, at a stiffness
# that is held until friction fits, with the friction that was found or is taken to be known. The
# last is the first once more, from what the others have found.
FURTHER = (
    _Start(3e7, True, (1.0,)),
    _Start(3e7, False, (1.0,)),
    _Start(1e7, True, (1.0,)),
    _Start(3e7, False, SHARES),
    _Start(3e7, True, (1.0,)),
)

# Until the whole run is fitted, friction is held to 1/TETHER of what it is taken to be: what the
# beginning does not tell stays there.
TETHER = 2.0

# Tolerances of the two searches, and how many steps each may take.
ROUGH, FINE = 1e-4, 1e-8
MOST_STEPS = 60

# Relative step of the solver's finite differences.
DIFFERENCE = 1e-5

# Errors are those of a linear model, which a carriage that breaks away is not: the margin on top.
MARGIN = 1.2

# How far the damping may be off (share of σ₁ + B, which act together) as the force is smoothed:
# kinks that smoothing rounds are not among the draws.
DAMPING_ACCURACY = 0.02

# Of a reading's noise a right model leaves 1.04 at most (all but one of 90 hidden rigs): its
# parameters take up what the noise of the pressures does. A carriage that may break away or not at
# the next reading scatters by hundreds of that in the draws, which explain anything then.
MOST_LEFT = 1.2

# Below this (m) of a reading's noise that of the pressures shows, whatever the parameters.
FINEST_READING = 1e-6

# Draws of what the sensors leave of a model that fits, and their seed: a verdict is repeatable.
DRAWS = 100
SEED = 1


@dataclass(frozen=True)
class BristleFit:
    """Estimates by parameter, and how the model follows the run.

    ``position`` (m, shape (n,)) is what the model's sensor reads; ``verdict`` says whether the
    sensors explain how far the measured is from it.
    """

    estimates: Mapping[str, Estimate]
    position: Array
    verdict: Verdict


@dataclass(frozen=True)
class _Least:
    """What least squares found: values in natural sizes, the Jacobian to them, the cost."""

    problem: Problem
    scaled: Array
    jacobian: Array
    cost: float


@dataclass(frozen=True)
class _Solution:
    """Values, shape (p,), and what they and the sensors leave.

    ``residuals``, shape (m,), are the readings' over the noise; ``explained``, shape (DRAWS, m),
    and ``errors``, shape (DRAWS, p), what the sensors leave of a model that fits, and its values.
    """

    values: Array
    residuals: Array
    explained: Array
    errors: Array


def identify_bristles(run: MeasuredRun, parameters: RigParameters) -> BristleFit:
    """Fit the stiffness σ₀ of the bristles and their damping σ₁, from one run.

    Beside them the rest of friction is fitted, and not reported; of ``parameters`` the form of
    friction with its own constants, the speed at which σ₁ fades, bore, moving mass, the rail's tilt
    and ``sensors.*`` are taken as known. ``friction.dynamics`` need not be ``lugre``, the fit is.
    Where the run does not tell the bristles from a carriage that sticks, σ₀ is bounded.

    Raises
    ------
    UninformativeRunError
        Where the pressures hardly push.
    RunError
        For a run that is of no such rig.
    ParameterError
        For a carriage that is locked, or held to its piston by magnets.

    Examples
    --------
    >>> from rodless_lab.identification.excitation import bristle_voltages
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters({"friction.dynamics": "lugre", "friction.bristle_stiffness": 3e5})
    >>> run = run_of_trace(simulate(rig, bristle_voltages(), 1e-3, position=0.06), 621325.0)
    >>> fit = identify_bristles(run, RigParameters())
    >>> round(fit.estimates["friction.bristle_stiffness"].value, -4)
    300000.0
    """
    _refuse(parameters)
    check_run(run, parameters, absolute=False)
    change = float(np.ptp(Problem(run, parameters).force))
    if change < LEAST_FORCE:
        raise UninformativeRunError(
            f"the pressures' force changes by only {change:.3g} N, of {LEAST_FORCE:g} N that tell "
            "anything: record a run of `rodless drive bristles`"
        )
    problem = Problem(run, parameters)
    least = first = _least(run, parameters, problem.start, SHARES, [BRISTLE_DAMPING])
    fit = _fitted(least)
    for place, further in enumerate(FURTHER):
        nothing_new = least is first and place == len(FURTHER) - 1
        if fit.verdict.fits or nothing_new:
            break
        start = least.scaled * problem.scale if further.as_found else problem.start.copy()
        start[COMPLIANCE] = 1.0 / further.stiffness
        again = _least(run, parameters, start, further.shares, [COMPLIANCE, BRISTLE_DAMPING])
        if again.cost < least.cost:
            least, fit = again, _fitted(again)
    return fit


def _fitted(least: _Least) -> BristleFit:
    """Say what a solution is worth."""
    problem, solution = least.problem, _solved(least)
    compared = [("scatter of the position", solution.residuals, solution.explained)]
    checks = [
        *span_checks(compared, problem.spacing, "m", problem.noise),
        _of_noise(solution.residuals, problem.noise),
    ]
    values, errors = solution.values, _standard_errors(solution)
    force, stated = abs(float(values[BIAS])), problem.stated_force
    verdict = _if_pushed_by_no_more(Verdict(tuple(checks)), force, float(errors[BIAS]), stated)
    return BristleFit(_estimates(values, errors), problem.modelled(values), verdict)


def _if_pushed_by_no_more(verdict: Verdict, force: float, error: float, stated: float) -> Verdict:
    """Return ``verdict``; one that fits not with a constant ``force`` beyond the ``stated`` (N)."""
    if verdict.fits and force > stated + BEYOND_STATED * error:
        check = Check("constant force", force, stated, "N", 0.0)
        return Verdict((*verdict.checks, check), f"{ZEROED}, or the rail's tilt (rail.tilt)")
    return verdict


def _of_noise(residuals: Array, noise: float) -> Check:
    """Hold the size of the residuals, over the ``noise`` (m) of a reading, against MOST_LEFT.

    This is a bound and no test: the draws of a model that fits are all within.
    """
    left = noise * math.sqrt(float(power(residuals, 1)))
    least = max(noise, FINEST_READING)
    beyond = left > MOST_LEFT * least
    return Check("scatter of the position", left, least, "m", 0.0 if beyond else 1.0)


def _refuse(parameters: RigParameters) -> None:
    """Refuse a base whose carriage is not moved by what the pressures push."""
    kind = parameters.text("coupling.kind")
    if kind != "rigid":
        raise ParameterError(
            f"coupling.kind: {kind} refused, the fit takes the pressures to push the carriage "
            "itself; give a base with coupling.kind: rigid"
        )
    if Plant.of(parameters).cylinder.locked:
        raise ParameterError(
            "cylinder.locked: refused, a carriage that is held tells nothing of its friction; "
            "give a base without"
        )


def _least(
    run: MeasuredRun,
    parameters: RigParameters,
    start: Array,
    shares: Sequence[float],
    last: Sequence[int],
) -> _Least:
    """Minimise the residuals, from ``start``, shape (p,), of ``shares`` of the run in turn.

    The beginning of the run is fitted first: one slide that the start values have wrong is more
    than all the bristles do. Only then the whole, and the values at the places ``last`` with it: a
    damping that takes the place of the viscous coefficient leads astray.
    """
    problem = Problem(run, parameters)
    values = start
    free = np.full(len(values), True)
    free[list(last)] = False
    for share in shares:
        part = Problem(_beginning(run, share), parameters)
        values = _searched(part, values, free, ROUGH, TETHER).x * part.scale
    found = _searched(problem, values, np.full(free.shape, True), FINE, 0.0)
    return _Least(problem, np.asarray(found.x), np.asarray(found.jac), float(found.cost))


def _beginning(run: MeasuredRun, share: float) -> MeasuredRun:
    """Return the first ``share`` of the samples."""
    last = max(round(share * len(run.time)), FEWEST_SAMPLES)
    columns: dict[str, Any] = {name: values[:last] for name, values in run.columns().items()}
    return replace(run, **columns)


def _searched(
    problem: Problem, start: Array, free: npt.NDArray[np.bool_], tolerance: float, tether: float
) -> optimize.OptimizeResult:
    """Minimise over the values that are ``free``, shape (p,); ``x`` of the result has all.

    A ``tether`` holds friction where the problem has it, to within 1/tether of itself.
    """
    # In natural sizes, so that the solver's finite differences suit every one.
    scale = problem.scale
    scaled = start / scale
    # Bristles next to sticking are left by small steps: one of the natural size is all of them.
    steps = np.ones(len(scaled))
    steps[COMPLIANCE] = min(scaled[COMPLIANCE], 1.0)
    held = slice(FORWARD.start, REVERSE.stop)
    expected = problem.start[held]

    def residuals_of(chosen: Array) -> Array:
        values = scaled.copy()
        values[free] = chosen
        values *= scale
        residuals = problem.residuals(values)
        if tether == 0.0:
            return residuals
        strain = (values[held] - expected) / np.maximum(expected, scale[held])
        return np.concatenate([residuals, tether * strain])

    found = optimize.least_squares(
        residuals_of,
        scaled[free],
        bounds=tuple((bound / scale)[free] for bound in problem.bounds),
        x_scale=steps[free],
        diff_step=np.full(np.count_nonzero(free), DIFFERENCE),
        loss="soft_l1",
        f_scale=ROBUST,
        xtol=tolerance,
        ftol=tolerance,
        max_nfev=MOST_STEPS,
    )
    scaled[free] = found.x
    found.x = scaled
    return found


def _solved(least: _Least) -> _Solution:
    """Draw what the sensors leave beside a solution."""
    problem, jacobian = least.problem, least.jacobian
    values = least.scaled * problem.scale
    generator = np.random.default_rng(SEED)
    drawn = problem.draws(values, DRAWS, generator)
    known = generator.standard_normal((DRAWS, len(jacobian) - problem.readings))
    # The fit takes out of each draw what its parameters can follow, as it did of the run.
    errors = np.concatenate([drawn, known], axis=1) @ linalg.pinv(jacobian).T
    explained = drawn - errors @ jacobian[: problem.readings].T
    residuals = problem.residuals(values)[: problem.readings]
    return _Solution(values, residuals, explained, errors * problem.scale)


def _estimates(values: Array, errors: Array) -> dict[str, Estimate]:
    """Return the intervals, from the values and their standard errors, both of shape (p,)."""
    compliance, damping = (
        symmetric(float(values[place]), float(errors[place]), DRAWS, unit)
        for place, unit in ((COMPLIANCE, "m/N"), (BRISTLE_DAMPING, "N·s/m"))
    )
    sides = [values[side][-1] for side in (FORWARD, REVERSE)]
    damping = damping.widened(DAMPING_ACCURACY * (damping.value + float(np.mean(sides))))
    return {STIFFNESS: _stiffness(compliance), DAMPING: _damping(compliance, damping)}


def _standard_errors(solution: _Solution) -> Array:
    """Return the errors of the values, shape (p,), with the scatter beyond the draws' own."""
    excess = float(power(solution.residuals, 1)) / float(np.mean(power(solution.explained, 1)))
    mean_squares = np.mean(solution.errors**2, axis=0)
    return np.asarray(MARGIN * np.sqrt(mean_squares * max(excess, 1.0)))


def _told(compliance: Estimate) -> bool:
    """Whether bristles give way by more than those of a carriage that sticks, as good as."""
    return judged(compliance, "").informed and compliance.low > 1.0 / STICKING


def _stiffness(compliance: Estimate) -> Estimate:
    """Return the stiffness to a compliance: at least so much where that may be 0."""
    value, low = 1.0 / compliance.value, 1.0 / compliance.high
    if _told(compliance):
        declared = RigParameters.DECLARATIONS[STIFFNESS]
        found = Estimate(value, low, 1.0 / compliance.low, "N/m")
        return within(found, declared.minimum, declared.maximum)
    note = f"not told from a carriage that sticks, and at least {low:.3g} N/m"
    return Estimate(value, low, math.inf, "N/m", False, note)


def _damping(compliance: Estimate, found: Estimate) -> Estimate:
    """Return the damping; of bristles that are not told there is none."""
    if not _told(compliance):
        note = "the run does not show that the carriage has bristles"
        return Estimate(found.value, -math.inf, math.inf, found.unit, False, note)
    note = "the run leaves it open within half its value"
    if found.low <= 0.0:
        note = f"not told from 0, and at most {found.high:.3g} {found.unit}"
    declared = RigParameters.DECLARATIONS[DAMPING]
    return within(judged(found, note), declared.minimum, declared.maximum)


def bristle_findings(fit: BristleFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters."""
    found = [
        Finding(name, estimate.value if estimate.informed else None, {name: estimate})
        for name, estimate in fit.estimates.items()
    ]
    form = LUGRE if found[0].value is not None else None
    return [Finding(FORM, form, {}), *found]
