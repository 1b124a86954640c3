# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Leaks past the piston and to ambient, from where pressures settle while the valve is closed.

The valve's gaps leak too, between both chambers, supply and ambient: what tells them apart is that
they change with the spool, and leaks do not.
"""

from dataclasses import replace

from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.fit import (
    SUPPLY,
    PressureFit,
    findings_of,
    fit_pressures,
)
from rodless_lab.identification.pressures.unknowns import (
    CLOSED,
    GAP,
    LEAKS,
    closed_voltage,
    dead_volumes,
    gap,
    leak,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters

# Where the search begins at the least, m².
TYPICAL = 5e-9


def identify_leaks(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit the areas of all three leaks, beside dead volumes, gap, supply and closed position.

    Of ``parameters`` the valve's area curve is taken as known. Raises
    :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.identification.excitation import leak_voltages
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = RigParameters({"cylinder.locked": True, "leak.across": 8e-9})
    >>> run = run_of_trace(simulate(rig, leak_voltages(), 1e-3, position=0.06), 621325.0)
    >>> fit = identify_leaks(run, RigParameters())
    >>> round(fit.estimates["leak.across"].value * 1e9, 1)
    8.0
    """
    # From 0, which bounds them, the search would hardly start.
    found = (leak(name, parameters) for name in LEAKS)
    leaks = [replace(unknown, start=max(unknown.start, TYPICAL)) for unknown in found]
    others = [*dead_volumes(parameters), gap(parameters), *closed_voltage(parameters)]
    return fit_pressures(run, parameters, [*leaks, *others])


def leak_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters; dead volumes are for `chambers`."""
    return findings_of(fit, (*LEAKS, GAP, CLOSED, SUPPLY))
