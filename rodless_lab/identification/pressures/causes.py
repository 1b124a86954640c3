# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""What a model of valve and chambers that does not fit likely lacks: each effect is tried."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from scipy import stats

from rodless_base.parameters import ParameterError, Value
from rodless_lab.identification.friction.uniform_motion import position_noise
from rodless_lab.identification.plausible import from_gauge
from rodless_lab.identification.pressures.fit import PressureFit, Solution, fit_pressures, solve
from rodless_lab.identification.pressures.problem import Unknown
from rodless_lab.identification.pressures.unknowns import (
    HEAT_TRANSFER,
    SPOOL_START,
    area_factor,
    closed_voltage,
    dead_time,
    dead_volumes,
    heat_transfer,
    hysteresis,
    leak,
    polytropic_index,
    spool_dynamics,
)
from rodless_lab.identification.verdict import FALSE_ALARM
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.physics.heat import ENERGY_BALANCE


def nothing(parameters: RigParameters) -> list[Unknown]:  # noqa: ARG001
    """Return no unknowns: the effect is a choice without a size."""
    return []


Unknowns = Callable[[RigParameters], list[Unknown]]


@dataclass(frozen=True)
class Effect:
    """Something the model may lack: what of it is unknown, and the choices that switch it on."""

    name: str
    unknowns: Unknowns = nothing
    values: tuple[tuple[str, Value], ...] = ()


def _choice(
    name: str, parameter: str, value: str, unknowns: Callable[..., list[Unknown]]
) -> Effect:
    says = f"{name} ({parameter}: {value})"
    return Effect(says, unknowns, ((parameter, value),))


EFFECTS = (
    _choice("heat to the walls", "chambers.thermodynamics", "energy_balance", heat_transfer),
    _choice("polytropic chambers", "chambers.thermodynamics", "polytropic", polytropic_index),
    _choice("adiabatic chambers", "chambers.thermodynamics", "adiabatic", nothing),
    Effect("a leak past the piston", lambda parameters: [leak("leak.across", parameters)]),
    Effect("a leak of chamber A", lambda parameters: [leak("leak.a", parameters)]),
    Effect("a leak of chamber B", lambda parameters: [leak("leak.b", parameters)]),
    _choice("another flow law", "valve.flow_law", "iso_6358", area_factor),
    _choice("another flow law", "valve.flow_law", "nozzle", area_factor),
    _choice("another flow coefficient", "valve.discharge", "constant", area_factor),
    _choice("another flow coefficient", "valve.discharge", "polynomial", area_factor),
    Effect("a valve of another size", area_factor),
    Effect("another closed position of the valve", closed_voltage),
    Effect("other dead volumes", dead_volumes),
    _choice("dynamics of the valve", "valve.dynamics", "second_order", spool_dynamics),
    Effect("dead time of the valve", lambda parameters: [dead_time(parameters)]),
    Effect("hysteresis of the valve", hysteresis),
)


LAG = "sensors.pressure_lag"
NO_LAG = (
    f"readings with the stated lag of the sensors; without it (--sensors ideal, or {LAG} in the "
    "base) the model fits"
)
GAUGE = "absolute pressures; with the atmosphere added to all, as to gauge readings, the model fits"


@dataclass(frozen=True)
class Trial:
    """An effect fitted beside what was: what of it was fitted, and how likely the gain is chance.

    ``name`` is the effect's.
    """

    name: str
    added: Sequence[Unknown]
    solution: Solution
    p_value: float

    @property
    def title(self) -> str:
        """The effect with its sizes."""
        return ", ".join(filter(None, (self.name, self.sizes)))

    @property
    def sizes(self) -> str:
        """What was fitted of the effect, for people."""
        found = self.solution.found
        return ", ".join(
            f"{unknown.name} {found[unknown.name]:.3g} {unknown.unit}".rstrip()
            for unknown in self.added
            if unknown.name != SPOOL_START
        )


def trials(run: MeasuredRun, without: Solution) -> list[Trial]:
    """Fit each of EFFECTS that the model ``without`` lacks beside what it has."""
    found = (_tried(effect, run, without) for effect in EFFECTS)
    return [trial for trial in found if trial is not None]


def with_cause(
    run: MeasuredRun, fit: PressureFit, try_effects: Callable[[], list[Trial]]
) -> PressureFit:
    """Return ``fit``; where it does not fit, its verdict says what the model likely lacks.

    ``try_effects`` makes the :func:`trials` beside it. The one that leaves least is named, if the
    gain passes an F test at FALSE_ALARM, corrected for their number; what is left is correlated, so
    its degrees of freedom are those of the fit.
    """
    if fit.verdict.fits or fit.verdict.cause:
        return fit
    worst = min(fit.verdict.checks, key=lambda check: check.p_value)
    if "supply" in worst.name:
        return replace(fit, verdict=fit.verdict.blaming("a supply that stays constant does not"))
    known = fit.solution.parameters
    if fit_pressures(from_gauge(run, known), known, fit.solution.unknowns).verdict.fits:
        return replace(fit, verdict=fit.verdict.blaming(GAUGE))
    prompt = known.with_values({LAG: 0.0})
    if fit_pressures(run, prompt, fit.solution.unknowns).verdict.fits:
        return replace(fit, verdict=fit.verdict.blaming(NO_LAG))
    tried = try_effects()
    significant = [trial for trial in tried if trial.p_value * len(tried) < FALSE_ALARM]
    best = min(significant, key=lambda trial: trial.solution.cost, default=None)
    cause = _noise(run) if best is None else _said(best, run)
    return replace(fit, verdict=fit.verdict.blaming(cause))


def _tried(effect: Effect, run: MeasuredRun, without: Solution) -> Trial | None:
    """Fit with the effect, from where the fit without it ended; None where it adds nothing."""
    parameters, known = without.parameters, without.found
    values = {name: value for name, value in effect.values if parameters[name] != value}
    if effect.values and not values:
        return None
    try:
        with_effect = parameters.with_values(values)
    except ParameterError:
        return None
    if HEAT_TRANSFER in known and with_effect.text("chambers.thermodynamics") != ENERGY_BALANCE:
        return None  # what was found would stand for nothing
    added = [found for found in effect.unknowns(with_effect) if found.name not in known]
    if not added and not values:
        return None
    begun = [
        replace(unknown, start=min(max(known[unknown.name], unknown.low), unknown.high))
        for unknown in without.unknowns
    ]
    rest = without.values[len(without.unknowns) :]
    found = solve(run, with_effect, [*begun, *added], rest)
    size = max(len(added), 1)
    statistic = (without.cost - found.cost) / size / found.spread
    p_value = float(stats.f.sf(statistic, size, found.freedom))
    return Trial(effect.name, added, found, p_value)


def _said(trial: Trial, run: MeasuredRun) -> str:
    fit = fit_pressures(run, trial.solution.parameters, trial.solution.unknowns)
    enough = "the model then fits" if fit.verdict.fits else "not by itself"
    return f"{trial.title}; it leaves {fit.scatter:.3g} Pa, {enough}"


def _noise(run: MeasuredRun) -> str:
    """Say what to do where nothing helps: perhaps the sensors are not as stated."""
    noise = max(position_noise(run.pressure_a), position_noise(run.pressure_b))
    return (
        f"none of the effects tried; the readings' own noise is {noise:.3g} Pa, check sensors.* "
        "(--sensors ideal, or --base FILE --sensors base)"
    )
