# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Do the intervals hold? Rigs with hidden parameters are run, measured, identified, compared.

``python -m rodless_lab.identification.coverage --draws 100`` prints, for every parameter, in how
many draws its 95 % interval covered the truth and how wide it was.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_base.constants import absolute
from rodless_lab.identification.estimate import Estimate
from rodless_lab.identification.excitation import EXCITATIONS, PERIOD
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.pressures.chambers import GAP, VOLUMES, identify_chambers
from rodless_lab.identification.pressures.fit import SUPPLY
from rodless_lab.identification.pressures.valve import AREA, AREA_FACTOR, CLOSED, identify_valve
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET, Instruments, read_trace

Array = npt.NDArray[np.float64]
Values = dict[str, float]
Row = tuple[bool, bool, float]

FRICTION_NAMES = ("static", "coulomb", "stribeck_velocity", "viscous")

# What whoever identifies knows of the rig: the defaults, and the sensors' data sheet.
KNOWN = RigParameters(DATA_SHEET)


@dataclass(frozen=True)
class Subject:
    """One kind of identification: what is hidden, the voltages (V, shape (n,)), and the fit."""

    hide: Callable[[np.random.Generator], tuple[RigParameters, Values]]
    voltages: Array
    identify: Callable[[MeasuredRun], Mapping[str, Estimate]]


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


def hidden_chambers(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw dead volumes, gap height and supply pressure."""
    truth = {name: generator.uniform(8e-6, 30e-6) for name in VOLUMES}
    truth |= {GAP: generator.uniform(4e-6, 8e-6), SUPPLY: _supply(generator)}
    return KNOWN.with_values(truth), truth


def hidden_valve(generator: np.random.Generator) -> tuple[RigParameters, Values]:
    """Draw closed position, size of the openings, gap height and supply pressure."""
    truth = {
        CLOSED: generator.uniform(4.98, 5.18),
        AREA_FACTOR: generator.uniform(0.8, 1.25),
        GAP: generator.uniform(4e-6, 8e-6),
        SUPPLY: _supply(generator),
    }
    amplitude = np.where(np.arange(9) % 3, 1.0, truth[AREA_FACTOR])
    area = tuple((amplitude * KNOWN.numbers(AREA)).tolist())
    values = {name: value for name, value in truth.items() if name != AREA_FACTOR}
    return KNOWN.with_values({**values, AREA: area}), truth


def _supply(generator: np.random.Generator) -> float:
    return absolute(float(generator.uniform(0.4e6, 0.6e6)))


def _friction(run: MeasuredRun) -> Mapping[str, Estimate]:
    fit = identify_friction(run, KNOWN)
    return {
        f"friction.{side}.{name}": getattr(direction, name)
        for side, direction in (("forward", fit.forward), ("reverse", fit.reverse))
        for name in FRICTION_NAMES
    }


SUBJECTS = {
    "friction": Subject(hidden_friction, EXCITATIONS["friction"](), _friction),
    "chambers": Subject(
        hidden_chambers,
        EXCITATIONS["chambers"](),
        lambda run: identify_chambers(run, KNOWN).estimates,
    ),
    "valve": Subject(
        hidden_valve, EXCITATIONS["valve"](), lambda run: identify_valve(run, KNOWN).estimates
    ),
}


def measured_run(
    parameters: RigParameters, voltages: Array, generator: np.random.Generator
) -> MeasuredRun:
    """Run the rig open loop from 60 mm and return what its instruments, chosen anew, show."""
    tools = Instruments.specimen(parameters, generator)
    trace = simulate(parameters, voltages, PERIOD, position=0.06)
    seen = read_trace(trace, parameters, generator, tools)
    supply = np.full(trace.time.shape, parameters.number(SUPPLY))
    return MeasuredRun(
        trace.time,
        seen.position,
        seen.pressure_a,
        seen.pressure_b,
        tools.supply_pressure.measure(supply, PERIOD, generator),
        trace.voltage,
    )


def round_trips(
    name: str, draws: int, show: Callable[[int], None] = lambda _: None
) -> dict[str, Coverage]:
    """Hide, run, measure and identify ``draws`` rigs of a subject, seeds 0 to draws-1."""
    rows: dict[str, list[Row]] = {}
    for seed in range(draws):
        for parameter, row in round_trip(name, seed).items():
            rows.setdefault(parameter, []).append(row)
        show(seed + 1)
    return {parameter: _coverage(row) for parameter, row in rows.items()}


def round_trip(name: str, seed: int) -> dict[str, Row]:
    """Return of one rig, for each parameter: informed, truth covered, half width over truth."""
    subject = SUBJECTS[name]
    generator = np.random.default_rng(seed)
    parameters, truth = subject.hide(generator)
    estimates = subject.identify(measured_run(parameters, subject.voltages, generator))
    return {
        parameter: (found.informed, found.covers(true), found.half_width / abs(true))
        for parameter, true in truth.items()
        for found in [estimates[parameter]]
    }


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
    """Return 0 if every interval covered the truth in 95 of 100 informed draws."""
    parser = argparse.ArgumentParser(prog="round_trip", description=__doc__)
    parser.add_argument("subjects", nargs="*", help=", ".join(SUBJECTS))
    parser.add_argument("--draws", type=int, default=100)
    options = parser.parse_args(arguments)

    def show(done: int) -> None:
        if sys.stderr.isatty():
            print(f"\r{done}/{options.draws}", end="", file=sys.stderr, flush=True)

    good = True
    for name in options.subjects or SUBJECTS:
        for parameter, found in round_trips(name, options.draws, show).items():
            good &= found.covered >= 0.95 * found.informed
            print(
                f"\r{parameter:36} covered {found.covered:4d} of {found.informed:4d} informed "
                f"({found.draws} draws), ±{found.half_width:.2%}",
                flush=True,
            )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
