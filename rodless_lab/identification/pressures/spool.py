# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Dynamics, hysteresis and dead time of the valve's spool, from the pressures that it lets in.

Nobody sees the spool. Pressures are integrals of what passes it: a command that arrives late shifts
them, a spool that swings passes more or less of a short pulse, and one with play stops at another
place where it comes from above than where it comes from below.

The natural frequency is searched by its time constant 1/ω, in which a spool that follows at once is
a number, 0, and not infinity.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from rodless_lab.identification.estimate import Estimate
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.fit import (
    SUPPLY,
    PressureFit,
    findings_of,
    fit_pressures,
    solve,
)
from rodless_lab.identification.pressures.problem import Unknown
from rodless_lab.identification.pressures.unknowns import (
    CLOSED,
    DAMPING,
    DEAD_TIME,
    FREQUENCY,
    GAP,
    HYSTERESIS,
    TIME_CONSTANT,
    closed_voltage,
    dead_time,
    dead_volumes,
    gap,
    hysteresis,
    spool_damping,
    time_constant,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.spool import SECOND_ORDER

DYNAMICS = "valve.dynamics"

# Where the two searches begin at the least, s.
DEAD_TIMES = (3e-3, 1e-3)

FASTEST = RigParameters.DECLARATIONS[FREQUENCY].maximum  # Hz


def with_dynamics(parameters: RigParameters) -> RigParameters:
    """Return ``parameters`` with a spool that swings."""
    return parameters.with_values({DYNAMICS: SECOND_ORDER})


def identify_spool(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit natural frequency, damping ratio, hysteresis and dead time of the valve's spool.

    Beside them dead volumes, gap, supply and closed position are fitted; of ``parameters`` the
    valve's area curve and the lag of the pressure sensors are taken as known;
    ``valve.dynamics`` need not be ``second_order``, the fit is. Where the run does not tell the
    spool from one that follows at once, the damping ratio is that of ``parameters``, and the
    frequency is bounded.
    Raises :class:`UninformativeRunError` where no pressure changes.

    Examples
    --------
    >>> from rodless_lab.identification.excitation import spool_voltages
    >>> from rodless_lab.runs.measured_run import run_of_trace
    >>> from rodless_sim import simulate
    >>> rig = with_dynamics(RigParameters({"cylinder.locked": True, "valve.dead_time": 2e-3}))
    >>> run = run_of_trace(simulate(rig, spool_voltages(), 1e-3, position=0.06), 621325.0)
    >>> fit = identify_spool(run, RigParameters())
    >>> round(fit.estimates["valve.natural_frequency"].value)
    115
    >>> round(fit.estimates["valve.dead_time"].value * 1e3, 2)
    2.0
    """
    swinging = with_dynamics(parameters)
    fit = _with_all(run, swinging)
    if _told(fit.estimates[TIME_CONSTANT]):
        return _reported(fit)
    unknowns = _begun([u for u in fit.solution.unknowns if u.name != DAMPING], fit.solution.found)
    return _reported(fit_pressures(run, swinging, unknowns))


def _with_all(run: MeasuredRun, parameters: RigParameters) -> PressureFit:
    """Fit from a closed position found first; if no model fits so, from nothing known.

    A closed position that is off by 0.1 V leads the search for all at once astray, and one found
    without the spool can do the same.
    """
    first = solve(run, parameters, closed_voltage(parameters))
    unknowns = _begun(_unknowns(parameters, DEAD_TIMES[0]), first.found)
    fit = fit_pressures(run, parameters, unknowns, first.values[len(first.unknowns) :])
    if fit.verdict.fits:
        return fit
    again = fit_pressures(run, parameters, _unknowns(parameters, DEAD_TIMES[1]))
    return min(fit, again, key=lambda found: found.solution.cost)


def _unknowns(parameters: RigParameters, least: float) -> list[Unknown]:
    """Return all that is fitted; the dead time from ``least`` (s) on."""
    late = dead_time(parameters)
    late = replace(late, start=max(parameters.number(DEAD_TIME), least))
    spool = [time_constant(parameters), spool_damping(parameters), *hysteresis(parameters), late]
    return [*spool, *dead_volumes(parameters), gap(parameters), *closed_voltage(parameters)]


def _begun(unknowns: Sequence[Unknown], found: Mapping[str, float]) -> list[Unknown]:
    """Return ``unknowns`` that start where they were ``found``."""
    return [replace(unknown, start=found.get(unknown.name, unknown.start)) for unknown in unknowns]


def _reported(fit: PressureFit) -> PressureFit:
    """Return ``fit`` with the estimates of the valve's parameters."""
    damping = fit.estimates.get(DAMPING, _assumed(fit.solution.parameters))
    frequency = _frequency(fit.estimates[TIME_CONSTANT])
    return replace(fit, estimates={**fit.estimates, FREQUENCY: frequency, DAMPING: damping})


def _told(found: Estimate) -> bool:
    """Whether a time constant is known, and told from that of the fastest spool there may be."""
    return found.informed and _natural_frequency(found.low) < FASTEST


def _assumed(parameters: RigParameters) -> Estimate:
    """Return the damping ratio of a spool too fast to show it."""
    value = parameters.number(DAMPING)
    note = f"the run does not show how the spool swings; {value:g} of the base is taken"
    return Estimate(value, -math.inf, math.inf, "", False, note)


def _frequency(found: Estimate) -> Estimate:
    """Return the natural frequency to a time constant: at least so much where that may be 0."""
    value, least, most = map(_natural_frequency, (found.value, found.high, found.low))
    least = min(least, FASTEST)
    if _told(found):
        return Estimate(value, least, most, "Hz")
    note = f"not told from a spool that follows at once, and at least {least:.3g} Hz"
    return Estimate(value, least, math.inf, "Hz", False, note)


def _natural_frequency(time: float) -> float:
    """Return the natural frequency (Hz) to a time constant (s)."""
    return 1.0 / (2.0 * math.pi * time) if time > 0.0 else math.inf


def spool_findings(fit: PressureFit) -> list[Finding]:
    """Return what the fit says of the plant's parameters; dead volumes are for `chambers`."""
    found = findings_of(fit, (FREQUENCY, DAMPING, HYSTERESIS, DEAD_TIME, GAP, CLOSED, SUPPLY))
    form = SECOND_ORDER if found[0].value is not None else None
    return [Finding(DYNAMICS, form, {}), *found]
