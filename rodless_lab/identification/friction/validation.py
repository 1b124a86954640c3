# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which form of friction a second run confirms: each fitted to the first run, judged there."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.friction.causes import form_text, other_forms
from rodless_lab.identification.friction.curve import Stribeck
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit
from rodless_lab.identification.friction.run import FrictionPoints, fit_points, friction_points
from rodless_lab.identification.validation import Candidate, Selection, robust_squares
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# A point farther than this (N) from the curve counts linearly.
ROBUST = 2.0


def select(
    run: MeasuredRun, second: MeasuredRun, parameters: RigParameters, fit: FrictionFit
) -> Selection:
    """Judge ``fit`` and other forms, fitted to ``run``, by the uniform motion of ``second``.

    Raises :class:`UninformativeRunError` for runs without uniform motion.
    """
    first, other = friction_points(run, parameters), friction_points(second, parameters)
    if not len(other.speeds):
        raise UninformativeRunError(f"the second run has no uniform motion: {other.reason}")
    fits = [(parameters, fit)]
    fits += [(tried, fit_points(first, tried)) for tried in other_forms(parameters)]
    own = len(Stribeck._fields)
    found = [
        Candidate(form_text(tried), _sizes(of), 2 * own, before, losses)
        for tried, of in fits
        for before in [float(np.mean(_losses(first, of)))]
        for losses in [_losses(other, of)]
        if math.isfinite(before) and np.all(np.isfinite(losses))
    ]
    if not found:
        raise UninformativeRunError("no form of friction was found in both directions")
    return Selection(found, "N")


def _losses(points: FrictionPoints, fit: FrictionFit) -> Array:
    """Squares in N² of what the curve leaves of the points of uniform motion, in their order."""
    missed = np.empty(len(points.speeds))
    sides: Sequence[tuple[float, DirectionFit]] = ((1.0, fit.forward), (-1.0, fit.reverse))
    for sign, side in sides:
        here = sign * points.speeds > 0.0
        speeds, forces = sign * points.speeds[here], sign * points.forces[here]
        missed[here] = forces - side.form.force(side.curve, speeds)
    return robust_squares(missed, ROBUST)


def _sizes(fit: FrictionFit) -> str:
    return ", ".join(
        f"{name} F_c {side.coulomb.value:.3g} N, B {side.viscous.value:.4g} N·s/m"
        for name, side in (("forward", fit.forward), ("reverse", fit.reverse))
    )
