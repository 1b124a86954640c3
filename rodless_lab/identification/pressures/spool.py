# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How the valve's spool follows its command, from what the chambers' pressures do meanwhile.

A step of the command that lasts some milliseconds lets in as much air as the spool was open for:
its delay and its shape show natural frequency, damping and dead time. A slow voltage up and down
through the closed position shows the hysteresis: pressures depend on nothing as much.
"""

from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.fit import (
    PressureFit,
    findings_of,
    fit_pressures,
)
from rodless_lab.identification.pressures.unknowns import (
    DAMPING,
    DEAD_TIME,
    FREQUENCY,
    HYSTERESIS,
    area_factor,
    closed_voltage,
    dead_time,
    gap,
    hysteresis,
    spool_dynamics,
)
from rodless_lab.identification.pressures.valve import valve_findings
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.spool import SECOND_ORDER

DYNAMICS = "valve.dynamics"


def with_dynamics(parameters: RigParameters) -> RigParameters:
    """Return ``parameters`` with a spool that swings."""
    return parameters.with_values({DYNAMICS: SECOND_ORDER})


def identify_spool(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit natural frequency, damping, hysteresis and dead time of the valve.

    Beside them the closed position, a factor on the area curve, gap and supply. Of ``parameters``
    the shape of the area curve, the dead volumes and the lag of the pressure sensors are taken as
    known: an error of that lag looks like dead time. ``valve.dynamics`` need not be
    ``second_order``, the fit is. Raises :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.identification.excitation import spool_voltages
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = with_dynamics(RigParameters({"valve.hysteresis": 0.003}))
    >>> run = run_of_trace(simulate(rig, spool_voltages(), 1e-3, position=0.06), 621325.0)
    >>> fit = identify_spool(run, RigParameters())
    >>> round(fit.estimates["valve.natural_frequency"].value)
    115
    """
    swinging = with_dynamics(parameters)
    unknowns = [
        *spool_dynamics(swinging),
        *hysteresis(swinging),
        dead_time(swinging),
        *closed_voltage(swinging),
        *area_factor(swinging),
        gap(swinging),
    ]
    return fit_pressures(run, swinging, unknowns)


def spool_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters."""
    found = findings_of(fit, (FREQUENCY, DAMPING, HYSTERESIS, DEAD_TIME))
    form = SECOND_ORDER if found[0].value is not None else None
    return [Finding(DYNAMICS, form, {}), *found, *valve_findings(fit)]
