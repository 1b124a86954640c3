# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a recording holds of supply and valve, for a rig that repeats it.

The supply was read at the valve, behind all that makes it sink or fail, and the voltage is what the
valve followed, behind its faults. Parameters that would do either once more are off in that rig.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters, Scenario
from rodless_sim.scenario import MOST_ENTRIES
from rodless_sim.timing import step_nanoseconds

Array = npt.NDArray[np.float64]

PRESSURE = "supply.pressure"
SENSOR_OFFSET = "fault.supply_pressure.offset"
NOISE = ("sensors.pressure_noise", "fault.supply_pressure.noise")

# What acts on the supply before it is read at the valve. The default of each switches it off.
BEFORE_THE_READING = (
    "supply.kind",
    "supply.droop",
    "supply.ripple_amplitude",
    "fault.supply.loss",
)

# What acts on the command before valve/state has it.
BEFORE_THE_VALVE = ("fault.valve.spool", "fault.valve.offset")

# Readings within this (±Pa) are of one supply pressure, and so is the atmosphere's, beyond what the
# noise of the sensor makes.
STEADY = 2e3

# By how much a converter and noise may shift the mean of a recording (Pa); a sensor's bias is more.
OF_THE_MEAN = 100.0

# Of a normal noise one reading in a million is farther off, in standard deviations.
FARTHEST_NOISE = 5.0


class RecordedDrive(NamedTuple):
    """A rig as it was driven, and what its supply did on the way."""

    rig: RigParameters
    scenario: Scenario | None  # of a supply pressure that has changed
    supply: Array  # Pa at each sample
    remark: str  # what the recording stands in for; empty where that is as the parameters have it


def held_in(run: MeasuredRun) -> tuple[str, ...]:
    """Return the parameters whose effect on supply and valve the readings of a run hold."""
    return BEFORE_THE_READING if run.commanded else BEFORE_THE_READING + BEFORE_THE_VALVE


def recorded_drive(parameters: RigParameters, recorded: MeasuredRun) -> RecordedDrive:
    """Return a rig of ``parameters`` with the recorded supply, for the recorded voltage.

    Raises ParameterError for a supply pressure that no rig has.
    """
    readings = recorded.supply_pressure - parameters.number(SENSOR_OFFSET)
    noise = _noise(parameters)
    found = steady_pieces(readings, STEADY + noise)
    pieces = [(start, _no_vacuum(pressure, parameters)) for start, pressure in found]
    off = held_in(recorded)
    rig = parameters.with_values(
        {name: parameters.DECLARATIONS[name].default for name in off} | {PRESSURE: pieces[0][1]}
    )
    starts = [start for start, _ in pieces]
    lengths = np.diff([*starts, len(readings)])
    supply = np.repeat([pressure for _, pressure in pieces], lengths)
    remark = _remark(parameters, rig, supply, noise)
    return RecordedDrive(rig, _scenario(pieces, recorded.period), supply, remark)


def _noise(parameters: RigParameters) -> float:
    """Return how far (±Pa) noise alone takes a reading of the supply."""
    return FARTHEST_NOISE * math.hypot(*(parameters.number(name) for name in NOISE))


def steady_pieces(pressure: Array, steady: float = STEADY) -> list[tuple[int, float]]:
    """Return where each stretch of one supply pressure begins, and its mean (Pa).

    A stretch spans no more than twice ``steady`` (Pa). There are no more than a scenario has
    entries: where that takes wider stretches, they are.
    """
    width = 2.0 * steady
    while len(starts := _starts(pressure, width)) > MOST_ENTRIES:
        width *= 2.0
    ends = [*starts[1:], len(pressure)]
    return [
        (start, float(pressure[start:end].mean())) for start, end in zip(starts, ends, strict=True)
    ]


def _starts(pressure: Array, width: float) -> list[int]:
    """Return where stretches begin that lie within ``width`` (Pa), each as long as can be."""
    starts, lowest, highest = [0], float(pressure[0]), float(pressure[0])
    if np.ptp(pressure) <= width:
        return starts
    for place, value in enumerate(pressure.tolist()):
        lowest, highest = min(lowest, value), max(highest, value)
        if highest - lowest > width:
            starts.append(place)
            lowest = highest = value
    return starts


def _no_vacuum(pressure: float, parameters: RigParameters) -> float:
    """Return a supply (Pa) that was read a little below the atmosphere as the atmosphere itself."""
    ambient = parameters.number("atmosphere.pressure")
    return ambient if ambient - STEADY <= pressure < ambient else pressure


def _scenario(pieces: list[tuple[int, float]], period: float) -> Scenario | None:
    if len(pieces) == 1:
        return None
    # Of the samples as they are simulated, to the nanosecond.
    seconds = step_nanoseconds(period, "period") * SECONDS_PER_NANOSECOND
    return Scenario(
        ((start * seconds, {PRESSURE: pressure}) for start, pressure in pieces[1:]),
        "the recorded supply pressure",
    )


def _remark(parameters: RigParameters, rig: RigParameters, supply: Array, noise: float) -> str:
    """Say which ``parameters`` the recording stands in for, if they are others than in ``rig``."""
    replaced = [name for name in BEFORE_THE_READING if rig[name] != parameters[name]]
    off = supply - parameters.number(PRESSURE)
    explained = OF_THE_MEAN + noise / math.sqrt(len(off))
    if np.max(np.abs(off)) > STEADY + noise or abs(np.mean(off)) > explained:
        replaced.insert(0, PRESSURE)
    of_valve = [name for name in BEFORE_THE_VALVE if rig[name] != parameters[name]]
    clauses = []
    if replaced:
        clauses.append(f"{_read(parameters, supply)} in place of {_list(parameters, replaced)}")
    if of_valve:
        clauses.append(f"the valve's voltage in place of {_list(parameters, of_valve)}")
    return f"taken from the recording: {'; '.join(clauses)}" if clauses else ""


def _read(parameters: RigParameters, supply: Array) -> str:
    less = f" less {_list(parameters, [SENSOR_OFFSET])}" if parameters[SENSOR_OFFSET] else ""
    low, high = float(supply.min()), float(supply.max())
    course = f"{low:.0f} Pa" if low == high else f"{low:.0f} to {high:.0f} Pa"
    return f"a supply of {course}{less}"


def _list(parameters: RigParameters, names: list[str]) -> str:
    """Return the parameters with their values and units."""
    texts = []
    for name in names:
        value = parameters[name]
        text = f"{value:.7g}" if isinstance(value, float) else str(value)
        texts.append(f"{name} {text} {parameters.DECLARATIONS[name].unit}".rstrip())
    return ", ".join(texts)
