# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a friction fit says of the plant's parameters."""

from dataclasses import replace

from rodless_lab.identification.estimate import Estimate
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit
from rodless_lab.identification.parameter_writer import Finding
from rodless_sim import RigParameters

LABELS = {
    "static": "F_s",
    "coulomb": "F_c",
    "stribeck_velocity": "v_s",
    "viscous": "B",
}


def friction_findings(fit: FrictionFit) -> list[Finding]:
    """Return the friction parameters of both directions; F_s is never below F_c."""
    return [
        finding
        for side, direction in (("forward", fit.forward), ("reverse", fit.reverse))
        for finding in _direction(side, direction)
    ]


def _direction(side: str, fit: DirectionFit) -> list[Finding]:
    estimates: dict[str, Estimate] = {
        name: getattr(fit, name) for name in ("static", "coulomb", "stribeck_velocity", "viscous")
    }
    findings = []
    for name, estimate in estimates.items():
        value = max(estimate.value, 0.0) if estimate.informed else None
        findings.append(Finding(f"friction.{side}.{name}", value, {LABELS[name]: estimate}))
    if fit.coulomb.informed:
        findings[0] = _not_below_coulomb(side, findings[0], fit)
    else:
        findings[1] = _not_above_static(side, findings[1], findings[0].value, fit.coulomb)
    return findings


def _not_below_coulomb(side: str, static: Finding, fit: DirectionFit) -> Finding:
    """Keep F_s at F_c or above: the plant refuses a smaller one, also its own default."""
    coulomb = fit.coulomb.value
    if isinstance(static.value, float):
        return replace(static, value=max(static.value, coulomb))
    if RigParameters().number(f"friction.{side}.static") >= coulomb:
        return static
    note = f"{fit.static.note}; set to F_c, which exceeds the default"
    return replace(static, value=coulomb, estimates={"F_s": replace(fit.static, note=note)})


def _not_above_static(side: str, coulomb: Finding, static: object, estimate: Estimate) -> Finding:
    """Keep F_c at F_s or below where the run does not tell it: its default may be above."""
    default = RigParameters().number(f"friction.{side}.coulomb")
    if not isinstance(static, float) or static >= default:
        return coulomb
    note = f"{estimate.note}; set to F_s, below which the default is not"
    return replace(coulomb, value=static, estimates={"F_c": replace(estimate, note=note)})
