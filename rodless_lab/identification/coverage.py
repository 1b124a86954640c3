# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Do the intervals hold? Rigs with hidden parameters are run, measured, identified, compared.

``python -m rodless_lab.identification.coverage --draws 100`` prints, for every parameter, in how
many draws its 95 % interval covered the truth and how wide it was, and how often the verdict was a
false alarm. With ``--effects`` the rigs have effects that the model leaves out, one at a time: in
how many draws the verdict says so, and in how many neither it nor the intervals do.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from rodless_base.constants import absolute
from rodless_lab.identification.bristles.fit import DAMPING as BRISTLE_DAMPING
from rodless_lab.identification.bristles.fit import FORM as FRICTION_DYNAMICS
from rodless_lab.identification.bristles.fit import STIFFNESS, BristleFit, identify_bristles
from rodless_lab.identification.estimate import Estimate
from rodless_lab.identification.excitation import EXCITATIONS, PERIOD
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.hidden_effects import EFFECTS, any_size, outcome
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.fit import SUPPLY, PressureFit
from rodless_lab.identification.pressures.heat import identify_heat, with_temperatures
from rodless_lab.identification.pressures.leaks import identify_leaks
from rodless_lab.identification.pressures.spool import identify_spool, with_dynamics
from rodless_lab.identification.pressures.unknowns import (
    AREA_FACTOR,
    CLOSED,
    DAMPING,
    DEAD_TIME,
    FREQUENCY,
    GAP,
    HEAT_TRANSFER,
    HYSTERESIS,
    LEAKS,
    VOLUMES,
)
from rodless_lab.identification.pressures.valve import AREA, identify_valve
from rodless_lab.identification.verdict import Verdict
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError
from rodless_sim import Rig, RigParameters, Trace, simulate
from rodless_sim.instruments.instruments import DATA_SHEET, Instruments, read_trace
from rodless_sim.physics.bristles import LUGRE
from rodless_sim.physics.plant import Plant

Array = npt.NDArray[np.float64]
Values = dict[str, float]
Row = tuple[bool, bool, float]

MASS = "cylinder.moving_mass"
FRICTION_NAMES = ("static", "coulomb", "stribeck_velocity", "viscous")

# What is promised: of the intervals on right rigs, the false alarms there, and the draws on wrong
# rigs in which a parameter's interval misses and the verdict does not say so.
LEAST_COVERAGE = 0.95
MOST_FALSE_ALARMS = 0.05
MOST_SILENT = 0.10

# A count is more than a rate explains where the rate yields as many once in so many times.
CHANCE = 1000


def most(rate: float, draws: int) -> int:
    """Return up to how many of ``draws`` a ``rate`` explains: all but once in CHANCE times.

    Examples
    --------
    >>> most(0.05, 30)
    6
    """
    return int(stats.binom.ppf(1.0 - 1.0 / CHANCE, draws, rate))


# What whoever identifies knows of the rig: the defaults, and the sensors' data sheet.
KNOWN = RigParameters(DATA_SHEET)


@dataclass(frozen=True)
class Subject:
    """One kind of identification: what is hidden, the voltages (V, shape (n,)), and the fit.

    ``known`` are parameters that whoever identifies knows of the rig beyond KNOWN.
    """

    hide: Callable[[np.random.Generator], tuple[RigParameters, Values]]
    voltages: Array
    identify: Callable[[MeasuredRun, RigParameters], tuple[Mapping[str, Estimate], Verdict]]
    known: tuple[str, ...] = ()


@dataclass(frozen=True)
class Coverage:
    """Of one parameter over all draws: informed, covered among those, median width (relative)."""

    draws: int
    informed: int
    covered: int
    half_width: float


def hidden_friction(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw friction of both directions, with and without an unstable branch, and the supply."""
    truth: Values = {}
    for side in ("forward", "reverse"):
        coulomb = generator.uniform(9.0, 16.0)
        truth[f"friction.{side}.static"] = coulomb + generator.uniform(10.0, 25.0)
        truth[f"friction.{side}.coulomb"] = coulomb
        truth[f"friction.{side}.stribeck_velocity"] = generator.uniform(1.3e-3, 4e-3)
        truth[f"friction.{side}.viscous"] = generator.uniform(3500.0, 5500.0)
    return KNOWN.with_values({**truth, SUPPLY: _supply(generator)}), truth


def hidden_bristled(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw friction as :func:`hidden_friction`, on bristles that are known."""
    rig, truth = hidden_friction(generator)
    return rig.with_values(EFFECTS["lugre"](generator)), truth


def hidden_chambers(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw dead volumes, gap height and supply pressure."""
    truth = {name: generator.uniform(8e-6, 30e-6) for name in VOLUMES}
    truth |= {GAP: generator.uniform(4e-6, 8e-6), SUPPLY: _supply(generator)}
    return KNOWN.with_values(truth), truth


def hidden_valve(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw closed position, size of the openings, gap height and supply pressure."""
    truth = {
        CLOSED: _closed(generator),
        AREA_FACTOR: generator.uniform(0.8, 1.25),
        GAP: generator.uniform(4e-6, 8e-6),
        SUPPLY: _supply(generator),
    }
    amplitude = np.where(np.arange(9) % 3, 1.0, truth[AREA_FACTOR])
    area = tuple((amplitude * KNOWN.numbers(AREA)).tolist())
    values = {name: value for name, value in truth.items() if name != AREA_FACTOR}
    return KNOWN.with_values({**values, AREA: area}), truth


def hidden_heat(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw the heat transfer coefficient, closed position, and as :func:`hidden_chambers`."""
    rig, others = hidden_chambers(generator)
    truth = {HEAT_TRANSFER: any_size(generator, 20.0, 200.0), CLOSED: _closed(generator)}
    return with_temperatures(rig).with_values(truth), {**truth, **others}


def hidden_leaks(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw the areas of all leaks, closed position, and as :func:`hidden_chambers`.

    Dead volumes are hidden, but not among what is found.
    """
    rig, others = hidden_chambers(generator)
    truth = {name: any_size(generator, 2e-9, 2e-8) for name in LEAKS}
    truth[CLOSED] = _closed(generator)
    return rig.with_values(truth), {**truth, GAP: others[GAP], SUPPLY: others[SUPPLY]}


def hidden_spool(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw all of the spool's drive, closed position, and as :func:`hidden_chambers`.

    Dead volumes are hidden, but not among what is found. The rig is integrated more finely than
    by default: its own error over hundreds of moves of the spool would be up to 0.7 % in the
    frequency, which is more than the sensors' noise.
    """
    rig, others = hidden_chambers(generator)
    truth = {
        FREQUENCY: any_size(generator, 60.0, 200.0),
        DAMPING: generator.uniform(0.4, 1.0),
        HYSTERESIS: any_size(generator, 5e-4, 4e-3),
        DEAD_TIME: any_size(generator, 5e-4, 5e-3),
        CLOSED: _closed(generator),
    }
    found = {**truth, GAP: others[GAP], SUPPLY: others[SUPPLY]}
    return with_dynamics(rig).with_values({**truth, "time.tolerance": 0.01}), found


def hidden_bristles(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw stiffness and damping of the bristles, the rest of friction, and the known mass.

    The rest of friction is hidden, but not among what is found.
    """
    truth = {
        STIFFNESS: any_size(generator, 1e5, 5e5),
        BRISTLE_DAMPING: any_size(generator, 200.0, 1500.0),
    }
    others = {
        name: KNOWN.number(name) * generator.uniform(0.7, 1.3)
        for side in ("forward", "reverse")
        for name in (f"friction.{side}.{part}" for part in FRICTION_NAMES)
    }
    mass = {MASS: generator.uniform(0.7, 2.0)}
    return KNOWN.with_values({**truth, **others, **mass, FRICTION_DYNAMICS: LUGRE}), truth


def _closed(generator: np.random.Generator) -> float:
    return float(generator.uniform(4.98, 5.18))


def _supply(generator: np.random.Generator) -> float:
    return absolute(float(generator.uniform(0.4e6, 0.6e6)))


def _friction(run: MeasuredRun, known: RigParameters) -> tuple[Mapping[str, Estimate], Verdict]:
    fit = identify_friction(run, known)
    estimates = {
        f"friction.{side}.{name}": getattr(direction, name)
        for side, direction in (("forward", fit.forward), ("reverse", fit.reverse))
        for name in FRICTION_NAMES
    }
    return estimates, fit.verdict


def _judged(
    identify: Callable[[MeasuredRun, RigParameters], PressureFit | BristleFit],
) -> Callable[[MeasuredRun, RigParameters], tuple[Mapping[str, Estimate], Verdict]]:
    def found(run: MeasuredRun, known: RigParameters) -> tuple[Mapping[str, Estimate], Verdict]:
        fit = identify(run, known)
        return fit.estimates, fit.verdict

    return found


SUBJECTS = {
    "bristles": Subject(
        hidden_bristles, EXCITATIONS["bristles"](), _judged(identify_bristles), known=(MASS,)
    ),
    "friction": Subject(hidden_friction, EXCITATIONS["friction"](), _friction),
    "chambers": Subject(hidden_chambers, EXCITATIONS["chambers"](), _judged(identify_chambers)),
    "heat": Subject(hidden_heat, EXCITATIONS["heat"](), _judged(identify_heat)),
    "leak": Subject(hidden_leaks, EXCITATIONS["leak"](), _judged(identify_leaks)),
    "spool": Subject(hidden_spool, EXCITATIONS["spool"](), _judged(identify_spool)),
    "valve": Subject(hidden_valve, EXCITATIONS["valve"](), _judged(identify_valve)),
}


# Those, and what is tried besides: a subject on a base that states more.
TRIED = {
    **SUBJECTS,
    "friction on bristles": Subject(
        hidden_bristled, EXCITATIONS["friction"](), _friction, (FRICTION_DYNAMICS, STIFFNESS)
    ),
}


def measured_run(
    parameters: RigParameters, voltages: Array, generator: np.random.Generator
) -> MeasuredRun:
    """Run the rig open loop from 60 mm and return what its instruments, chosen anew, show."""
    tools = Instruments.specimen(parameters, generator)
    trace = simulate(parameters, voltages, PERIOD, position=0.06)
    seen = read_trace(trace, parameters, generator, tools)
    supply = _supply_at_valve(parameters, trace)
    return MeasuredRun(
        trace.time,
        seen.position,
        seen.pressure_a,
        seen.pressure_b,
        tools.supply_pressure.measure(supply, PERIOD, generator),
        trace.voltage,
    )


def _supply_at_valve(parameters: RigParameters, trace: Trace) -> Array:
    """Return the supply's true pressure (Pa) at each sample; traces lack what is known in time."""
    plant = Plant.of(parameters)
    if not plant.ripple and not (plant.full and plant.full.supply.acting):
        return np.full(trace.time.shape, parameters.number(SUPPLY))
    rig = Rig(parameters)
    rig.reset(float(trace.position[0]))
    pressures = [rig.truth.supply_pressure]
    for voltage in trace.voltage[:-1]:
        rig.advance(float(voltage), PERIOD)
        pressures.append(rig.truth.supply_pressure)
    return np.array(pressures)


@dataclass(frozen=True)
class Trial:
    """One rig: for each parameter whether it was informed, covered, and its relative half width."""

    rows: dict[str, Row]
    verdict: Verdict

    @property
    def covered(self) -> bool:
        """Whether all intervals that are claimed hold the truth."""
        return all(covers for informed, covers, _ in self.rows.values() if informed)


def trials(
    name: str, draws: int, effect: str = "", show: Callable[[int], None] = lambda _: None
) -> list[Trial]:
    """Hide, run, measure and identify ``draws`` rigs of a subject, seeds 0 to draws-1.

    With an ``effect`` the rigs have that too, and who identifies them does not know.
    """
    found = []
    for seed in range(draws):
        found.append(round_trip(name, seed, effect))
        show(seed + 1)
    return found


def round_trip(name: str, seed: int, effect: str = "") -> Trial:
    """Hide, run, measure and identify one rig."""
    subject = TRIED[name]
    generator = np.random.default_rng(seed)
    parameters, truth = subject.hide(generator)
    if effect:
        parameters = parameters.with_values(EFFECTS[effect](generator))
    run = measured_run(parameters, subject.voltages, generator)
    try:
        known = KNOWN.with_values({name: parameters[name] for name in subject.known})
        estimates, verdict = subject.identify(run, known)
    except UninformativeRunError:
        return Trial({}, Verdict(()))
    rows = {
        parameter: (found.informed, found.covers(true), found.half_width / abs(true))
        for parameter, true in truth.items()
        for found in [estimates[parameter]]
    }
    return Trial(rows, verdict)


def left_out(name: str) -> list[str]:
    """Return the effects that a subject does not identify itself."""
    generator = np.random.default_rng(0)
    _, truth = TRIED[name].hide(generator)
    found = {*truth, *TRIED[name].known}
    return [effect for effect, draw in EFFECTS.items() if not found & draw(generator).keys()]


def coverage_of(found: Sequence[Trial]) -> dict[str, Coverage]:
    """Count, for each parameter, the intervals that cover."""
    rows: dict[str, list[Row]] = {}
    for trial in found:
        for parameter, row in trial.rows.items():
            rows.setdefault(parameter, []).append(row)
    return {parameter: _coverage(row) for parameter, row in rows.items()}


def _coverage(rows: Sequence[Row]) -> Coverage:
    informed = [row for row in rows if row[0]]
    widths = [row[2] for row in informed]
    return Coverage(
        len(rows),
        len(informed),
        sum(row[1] for row in informed),
        float(np.median(widths)) if widths else np.nan,
    )


def main(arguments: Sequence[str]) -> int:
    """Return 0 if the intervals and verdicts keep what docs/identification.md promises."""
    parser = argparse.ArgumentParser(prog="coverage", description=__doc__)
    parser.add_argument("subjects", nargs="*", help=", ".join(TRIED))
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument(
        "--effects",
        nargs="*",
        choices=[*EFFECTS],
        metavar="EFFECT",
        help=f"left out: {', '.join(EFFECTS)}; none named: all of them",
    )
    options = parser.parse_args(arguments)
    unknown = [name for name in options.subjects if name not in TRIED]
    if unknown:
        parser.error(f"{', '.join(unknown)}: no such subject; there are {', '.join(TRIED)}")

    def show(done: int) -> None:
        if sys.stderr.isatty():
            print(f"\r{done}/{options.draws}", end="", file=sys.stderr, flush=True)

    good = True
    for name in options.subjects or TRIED:
        if options.effects is None:
            good &= _right_rigs(name, options.draws, show)
        else:
            for effect in options.effects or left_out(name):
                good &= _wrong_rigs(name, options.draws, effect, show)
    return 0 if good else 1


def _right_rigs(name: str, draws: int, show: Callable[[int], None]) -> bool:
    done = trials(name, draws, show=show)
    good = True
    for parameter, found in coverage_of(done).items():
        good &= found.covered >= LEAST_COVERAGE * found.informed
        print(
            f"\r{parameter:36} covered {found.covered:4d} of {found.informed:4d} informed "
            f"({found.draws} draws), ±{found.half_width:.2%}",
            flush=True,
        )
    alarms = outcome([(trial.verdict.fits, trial.covered) for trial in done]).refused
    print(f"{name:36} false alarms {alarms} of {draws}", flush=True)
    return good and alarms <= MOST_FALSE_ALARMS * draws


def _wrong_rigs(name: str, draws: int, effect: str, show: Callable[[int], None]) -> bool:
    done = trials(name, draws, effect, show)
    found = outcome([(trial.verdict.fits, trial.covered) for trial in done])
    worst = silent_in_one(done)
    print(
        f"\r{name:10} without {effect:14} does not fit {found.refused:4d} of {found.draws}, "
        f"all intervals cover {found.covered:4d}, silently wrong {found.silent:4d}, "
        f"in one parameter at most {worst:4d}",
        flush=True,
    )
    return worst <= MOST_SILENT * draws


def silent_in_one(found: Sequence[Trial]) -> int:
    """Return in how many draws the interval of one parameter misses silently, of the worst.

    Of many intervals that hold in 95 % each, one or another misses more often.
    """
    missed = Counter(
        parameter
        for trial in found
        if trial.verdict.fits
        for parameter, (informed, covers, _) in trial.rows.items()
        if informed and not covers
    )
    return max(missed.values(), default=0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
