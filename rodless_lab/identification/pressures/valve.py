# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Closed position, size of the openings and gap of the valve from a run's pressures."""

from rodless_lab.identification.estimate import Estimate, within
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.fit import (
    SUPPLY,
    PressureFit,
    findings_of,
    fit_pressures,
)
from rodless_lab.identification.pressures.unknowns import (
    AREA_FACTOR,
    CLOSED,
    GAP,
    area_factor,
    closed_voltage,
    gap,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.flow_laws import iso_6358

AREA = "valve.area_coefficients"
CONDUCTANCE = "valve.sonic_conductance"


def identify_valve(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit the closed position, a factor on the whole area curve, and the gap's height.

    Pressures in the cylinder show only the product of flow coefficient and area, so C_v is left
    alone and the shape of the curve, eq. (5), is kept; a flow meter measures both
    (:func:`fit_area_curve`, :func:`fit_flow_coefficient`). The dead volumes are taken as known
    from ``parameters``: while the carriage rests, a factor on both looks like one on the area.
    Raises :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters({"cylinder.locked": True})
    >>> voltages = [5.7] * 500 + [4.6] * 500
    >>> run = run_of_trace(simulate(rig, voltages, 1e-3, position=0.06), 621325.0)
    >>> fit = identify_valve(run, rig)
    >>> round(fit.estimates["valve.closed_voltage"].value, 2)
    5.08
    """
    unknowns = [*closed_voltage(parameters), *area_factor(parameters), gap(parameters)]
    return fit_pressures(run, parameters, unknowns)


def valve_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters, from what they were before."""
    parameters, factor = fit.solution.parameters, fit.estimates[AREA_FACTOR]
    findings = findings_of(fit, (CLOSED, GAP, SUPPLY))
    if parameters.text("valve.flow_law") == iso_6358.NAME:
        return [*findings, _conductance(parameters, factor, fit.estimates[CLOSED])]
    return [*findings, Finding(AREA, _scaled(parameters, factor), {AREA_FACTOR: factor})]


def _conductance(parameters: RigParameters, factor: Estimate, closed: Estimate) -> Finding:
    """C with which the valve passes what it was found to pass: the curve only shares C out."""
    found = parameters.with_values({CLOSED: closed.value}) if closed.informed else parameters
    reach = iso_6358.widest_opening_of(found) / iso_6358.widest_opening_of(parameters)
    before = parameters.number(CONDUCTANCE) * reach
    declared = RigParameters.DECLARATIONS[CONDUCTANCE]
    low, high = declared.minimum, declared.maximum
    kept = within(factor, low / before, high / before)
    value = min(max(before * kept.value, low), high) if kept.informed else None
    return Finding(CONDUCTANCE, value, {AREA_FACTOR: kept})


def _scaled(parameters: RigParameters, factor: Estimate) -> tuple[float, ...] | None:
    if not factor.informed:
        return None
    coefficients = parameters.numbers(AREA)
    # Every third number, from the first, is the amplitude of a sine.
    return tuple(
        value if place % 3 else value * factor.value for place, value in enumerate(coefficients)
    )
