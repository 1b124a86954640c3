# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Dead volumes, supply pressure and leak of the gap from a run's pressures; the valve is known."""

from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.fit import (
    SUPPLY,
    PressureFit,
    findings_of,
    fit_pressures,
)
from rodless_lab.identification.pressures.unknowns import GAP, VOLUMES, dead_volumes, gap
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters


def identify_chambers(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit both dead volumes, the gap's effective height and the supply pressure.

    Works on fixed chambers and on moving ones alike. Of ``parameters`` everything else is taken
    as known, the valve's area above all: a valve that passes a tenth more makes the volumes look
    a tenth smaller. Raises :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters({"cylinder.locked": True})
    >>> voltages = [5.7] * 500 + [4.6] * 500
    >>> run = run_of_trace(simulate(rig, voltages, 1e-3, position=0.06), 621325.0)
    >>> fit = identify_chambers(run, rig)
    >>> round(fit.estimates["cylinder.dead_volume_a"].value * 1e6, 1)
    15.0
    """
    return fit_pressures(run, parameters, [*dead_volumes(parameters), gap(parameters)])


def chambers_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters."""
    return findings_of(fit, (*VOLUMES, GAP, SUPPLY))
