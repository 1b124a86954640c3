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
    Unknown,
    findings_of,
    fit_pressures,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant

VOLUMES = ("cylinder.dead_volume_a", "cylinder.dead_volume_b")
GAP = "valve.gap_height"


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
    return fit_pressures(
        run, parameters, [*(_volume(parameters, name) for name in VOLUMES), gap(parameters)]
    )


def chambers_findings(run: MeasuredRun, parameters: RigParameters) -> list[Finding]:
    """Identify the chambers; return what that says of the plant's parameters."""
    return findings_of(identify_chambers(run, parameters), (*VOLUMES, GAP, SUPPLY))


def gap(parameters: RigParameters) -> Unknown:
    """Return the effective height of the valve's gaps as an unknown."""

    def apply(plant: Plant, value: float) -> Plant:
        return plant._replace(valve=plant.valve._replace(gap_height=value))

    return Unknown.parameter(GAP, parameters, 1e-6, apply)


def _volume(parameters: RigParameters, name: str) -> Unknown:
    def apply(plant: Plant, value: float) -> Plant:
        cylinder = plant.cylinder
        if name == VOLUMES[0]:
            return plant._replace(cylinder=cylinder._replace(dead_volume_a=value))
        return plant._replace(cylinder=cylinder._replace(dead_volume_b=value))

    return Unknown.parameter(name, parameters, 1e-5, apply)
