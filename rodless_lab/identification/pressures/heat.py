# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Heat exchange of the chambers with their walls, from how pressures creep after they have jumped.

Air that was compressed is warm, and its pressure falls as it cools. How fast is h A_w over the
heat capacity of the air: known are the wall's area (from the bore and the volumes) and its
temperature, and what flows through the nearly closed valve is fitted too.
"""

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
    HEAT_TRANSFER,
    VOLUMES,
    closed_voltage,
    dead_volumes,
    gap,
    heat_transfer,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.heat import ENERGY_BALANCE

THERMODYNAMICS = "chambers.thermodynamics"


def with_temperatures(parameters: RigParameters) -> RigParameters:
    """Return ``parameters`` with chambers that have temperatures of their own."""
    return parameters.with_values({THERMODYNAMICS: ENERGY_BALANCE})


def identify_heat(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit the heat transfer coefficient h, beside dead volumes, gap, supply and closed position.

    Of ``parameters`` the valve's area and the walls' temperature are taken as known;
    ``chambers.thermodynamics`` need not be ``energy_balance``, the fit is. Raises
    :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = with_temperatures(RigParameters({"cylinder.locked": True}))
    >>> voltages = [5.7] * 500 + [5.08] * 500 + [4.6] * 500 + [5.08] * 500
    >>> run = run_of_trace(simulate(rig, voltages, 1e-3, position=0.06), 621325.0)
    >>> fit = identify_heat(run, rig)
    >>> round(fit.estimates["chambers.heat_transfer_coefficient"].value)
    50
    """
    warm = with_temperatures(parameters)
    unknowns = [*heat_transfer(warm), *dead_volumes(warm), gap(warm), *closed_voltage(warm)]
    return fit_pressures(run, warm, unknowns)


def heat_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters."""
    found = findings_of(fit, (HEAT_TRANSFER, *VOLUMES, GAP, CLOSED, SUPPLY))
    form = ENERGY_BALANCE if found[0].value is not None else None
    return [Finding(THERMODYNAMICS, form, {}), *found]
