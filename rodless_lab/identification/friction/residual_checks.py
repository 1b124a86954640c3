# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether the residuals of a fit of friction are what the errors of its points explain."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import linalg

from rodless_lab.identification.friction.curve_fit import Observations, Solution, dropless
from rodless_lab.identification.verdict import Check, Verdict, blocks, check_power

Array = npt.NDArray[np.float64]

# Draws of what the errors leave of a curve that fits, and their seed: a verdict is repeatable.
DRAWS = 400
SEED = 1

# Points of neighbouring speeds of which the median is taken.
GROUP = 3


def verdict_of_residuals(points: Observations, solution: Solution) -> Verdict:
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


def _share_of_errors(points: Observations, solution: Solution) -> Array:
    """Part of each standard error in that with the allowance, shape of the residuals."""
    coulomb, viscous = solution.values[[-3, -1]] if len(solution.values) > 2 else solution.values
    slope = points.form.slope(dropless(np.array([coulomb, viscous])), points.speeds)
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
