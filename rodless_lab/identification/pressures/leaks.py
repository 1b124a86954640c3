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
    Solution,
    findings_of,
    fit_of,
    solve,
)
from rodless_lab.identification.pressures.problem import Unknown
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

# How far from the base's closed voltage (V) the search begins, one after another. Where it begins
# 60 mV off and more, it may run away: leaks that are not there stand for a valve that is closed
# elsewhere, and ever larger chambers for leaks.
CLOSED_BESIDE = (0.0, 0.08, -0.08)

# Left per reading, over its variance, where the search has ended well: 0.9 to 1 where the model
# fits, hundreds where the search has run away.
WELL = 2.0


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
    others = [*dead_volumes(parameters), gap(parameters)]
    return fit_of(_least(run, parameters, [*leaks, *others]))


def _least(run: MeasuredRun, parameters: RigParameters, unknowns: list[Unknown]) -> Solution:
    """Fit ``unknowns`` and the closed voltage, from one beginning after another until it ends well.

    The least of all where none does: a run of no such model is judged by that.
    """
    found = []
    for beside in CLOSED_BESIDE:
        closed = [
            replace(unknown, start=unknown.start + beside) for unknown in closed_voltage(parameters)
        ]
        found.append(solve(run, parameters, [*unknowns, *closed]))
        if found[-1].cost < WELL * found[-1].problem.readings:
            break
    return min(found, key=lambda solution: solution.cost)


def leak_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters; dead volumes are for `chambers`."""
    return findings_of(fit, (*LEAKS, GAP, CLOSED, SUPPLY))
