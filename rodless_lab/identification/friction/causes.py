# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Another form of friction, where the one that was fitted does not follow the points."""

from collections.abc import Iterator
from itertools import product

from scipy import stats

from rodless_base.parameters import ParameterError
from rodless_lab.identification.friction.curve_fit import robust_sum
from rodless_lab.identification.friction.fit import FrictionFit
from rodless_lab.identification.friction.run import fit_points, friction_points
from rodless_lab.identification.verdict import FALSE_ALARM, Verdict, joined
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.friction import FORMS

# A form's own constants are tried at these multiples of what the base has.
FACTORS = (0.5, 1.0, 2.0)


def with_form(fit: FrictionFit, run: MeasuredRun, parameters: RigParameters) -> Verdict:
    """Return the verdict of ``fit``; where it does not fit, with a form that does better.

    Named is the one that leaves least, if that passes an F test at FALSE_ALARM, corrected for the
    number of forms tried.
    """
    moving = joined([fit.forward.verdict, fit.reverse.verdict])
    if moving.fits or moving.cause:  # no form follows a force that drives the carriage
        return fit.verdict
    causes = [fit.rest.cause, _other_form(fit, run, parameters)]
    return fit.verdict.blaming("; ".join(filter(None, causes)))


def _other_form(fit: FrictionFit, run: MeasuredRun, parameters: RigParameters) -> str:
    points = friction_points(run, parameters)
    trials = [(_cost(fit_points(points, tried)), tried) for tried in _others(parameters)]
    if not trials:
        return "no other friction.form"
    (left, number), best = min(trials, key=lambda trial: trial[0])
    before, _ = _cost(fit)
    freedom = max(number - 8, 1)
    size = max(len(FORMS[best.choice("friction.form")].PARAMETERS), 1)
    p_value = float(stats.f.sf((before - left) / size / (left / freedom), size, freedom))
    if p_value * len(trials) > FALSE_ALARM:
        return "no other friction.form follows the points"
    return f"another form of friction, {_said(best)}"


def _others(parameters: RigParameters) -> Iterator[RigParameters]:
    """Yield the base with each form and its own constants about those it has, but as it is."""
    for form in FORMS:
        own = list(form.PARAMETERS)
        for factors in product(FACTORS, repeat=len(own)):
            scaled = {
                name: parameters.number(name) * factor
                for name, factor in zip(own, factors, strict=True)
            }
            try:
                tried = parameters.with_values({"friction.form": form.NAME, **scaled})
            except ParameterError:
                continue
            same_form = parameters.text("friction.form") == form.NAME
            if not same_form or any(factor != 1.0 for factor in factors):
                yield tried


def _cost(fit: FrictionFit) -> tuple[float, int]:
    """Robust sum of squares of both directions, and the number of residuals."""
    sides = [fit.forward.residuals, fit.reverse.residuals]
    return sum(robust_sum(side) for side in sides), sum(len(side) for side in sides)


def _said(parameters: RigParameters) -> str:
    form = FORMS[parameters.choice("friction.form")]
    own = [f"{name} near {parameters.number(name):g}" for name in form.PARAMETERS]
    return ", ".join([f"friction.form: {form.NAME}", *own])
