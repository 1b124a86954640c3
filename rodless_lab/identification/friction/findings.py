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


def friction_findings(fit: FrictionFit, base: RigParameters) -> list[Finding]:
    """Return the friction parameters of both directions.

    F_s is never below F_c, whether they are loaded alone or on top of ``base``.
    """
    return [
        finding
        for side, direction in (("forward", fit.forward), ("reverse", fit.reverse))
        for finding in _direction(side, direction, base)
    ]


def _direction(side: str, fit: DirectionFit, base: RigParameters) -> list[Finding]:
    estimates: dict[str, Estimate] = {
        name: getattr(fit, name) for name in ("static", "coulomb", "stribeck_velocity", "viscous")
    }
    findings = []
    for name, estimate in estimates.items():
        value = max(estimate.value, 0.0) if estimate.informed else None
        findings.append(Finding(f"friction.{side}.{name}", value, {LABELS[name]: estimate}))
    if fit.coulomb.informed:
        findings[0] = _not_below_coulomb(findings[0], fit, base)
    else:
        findings[1] = _not_above_static(findings[1], findings[0].value, fit.coulomb, base)
    return findings


def _not_below_coulomb(static: Finding, fit: DirectionFit, base: RigParameters) -> Finding:
    """Keep F_s at F_c or above: the plant refuses a smaller one, also its own or the base's."""
    coulomb = fit.coulomb.value
    if isinstance(static.value, float):
        return replace(static, value=max(static.value, coulomb))
    if min(_there(static.name, base)) >= coulomb:
        return static
    note = f"{fit.static.note}; set to F_c, which exceeds that of the default or the base"
    return replace(static, value=coulomb, estimates={"F_s": replace(fit.static, note=note)})


def _not_above_static(
    coulomb: Finding, static: object, estimate: Estimate, base: RigParameters
) -> Finding:
    """Keep F_c at F_s or below where the run does not tell it: what is there may be above."""
    if not isinstance(static, float) or static >= max(_there(coulomb.name, base)):
        return coulomb
    note = f"{estimate.note}; set to F_s, which that of the default or the base exceeds"
    return replace(coulomb, value=static, estimates={"F_c": replace(estimate, note=note)})


def _there(name: str, base: RigParameters) -> tuple[float, float]:
    """Return what a parameter is where no file gives it: by default, and with the base."""
    return RigParameters().number(name), base.number(name)
