# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a run can be of the rig that is taken as known: its units and bounds."""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_lab.runs.measured_run import MeasuredRun, RunError, UninformativeRunError
from rodless_sim import RigParameters

SUPPLY = "supply.pressure"
STROKE = "cylinder.stroke"
CHAMBERS = ("pressure_a", "pressure_b")
PRESSURES = (*CHAMBERS, "supply_pressure")

# How far beyond the stroke a carriage may be read (share of the stroke): what sensors are off by.
BEYOND = 0.05

# Pressures are absolute: a reading below this (Pa) is a gauge pressure or in another unit.
LOWEST_PRESSURE = 5e4

# How many times the highest supply pressure that can be stated is read nowhere: what ripples, a
# compressor and sensors add is less, and so is what a carriage compresses that bounces.
COMPRESSED = 2.0

# A carriage that is read to move by more than this (m) has pressures that change, by more than that
# (Pa): no sensor tells less.
SMALLEST_MOTION = 1e-3
SMALLEST_CHANGE = 1e-3

# A pressure that is the same over so much travel (m) and so many samples, while nearly all others
# differ from the next. The change (Pa) right before is larger than that of one that settles, and
# right after than that of one that sets out.
FROZEN_TRAVEL = 20e-3
SETTLED = 1e-6
SMALLEST_EDGE = 1.0
NOISY_SHARE = 0.9
FEWEST_FROZEN = 100

# A position that is the same for so long (s), and then elsewhere faster (m/s) than any carriage.
FROZEN_TIME = 0.1
FASTEST = 10.0

# Samples of a window that is looked at, at the least.
FEWEST = 5

# s between samples of any run that shows how a rig moves.
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-6, 1.0


def check_run(
    run: MeasuredRun,
    known: RigParameters,
    window: float = 0.0,
    absolute: bool = True,
    longest: float = LONGEST_PERIOD,
) -> None:
    """Raise RunError, with the first sample that it cannot have, where ``run`` is of no such rig.

    ``known`` is what is taken as known of the rig: its stroke. Unless positions are ``absolute``,
    from the end of chamber A, they may be counted from anywhere. A run shorter than a ``window``
    (s) that is looked at informs nothing: UninformativeRunError. Samples are ``longest`` (s) apart
    at the most.
    """
    _check_clock(run, window, longest)
    _check_absolute(run)
    stroke = known.number(STROKE)
    origin = 0.5 * stroke if absolute else float(np.median(run.position))
    reach = (0.5 if absolute else 1.0) * stroke + BEYOND * stroke
    _check(
        run,
        "position",
        (origin - reach, origin + reach),
        f"m, the stroke is {stroke:g} m; positions are in m"
        + (", from the end of chamber A" if absolute else "")
        + f", and another cylinder needs a base with its {STROKE}",
    )
    most = COMPRESSED * RigParameters.DECLARATIONS[SUPPLY].maximum
    for name in PRESSURES:
        _check(run, name, (0.0, most), f"Pa, no rig has more than {most:g} Pa")
    _check_chambers(run)
    _check_position(run)
    _check_frozen(run)


def from_gauge(run: MeasuredRun, known: RigParameters) -> MeasuredRun:
    """Return ``run`` as it is if its pressures are gauge readings, counted from the atmosphere.

    That is what ``known`` has.
    """
    atmosphere = known.number("atmosphere.pressure")
    pressures: dict[str, Any] = {name: getattr(run, name) + atmosphere for name in PRESSURES}
    return replace(run, **pressures)


def _check_clock(run: MeasuredRun, window: float, longest: float) -> None:
    if not SHORTEST_PERIOD <= run.period <= longest:
        raise RunError(
            f"a sample every {run.period:.3g} s refused, must be from {SHORTEST_PERIOD:g} to "
            f"{longest:g} s; time is in s"
        )
    if window and run.period > window / FEWEST:
        raise RunError(
            f"a sample every {run.period:.3g} s refused, {FEWEST} in {window:g} s are needed"
        )
    if run.period * len(run.time) < window * (1.0 - 1e-9):
        raise UninformativeRunError(
            f"{run.period * len(run.time):.3g} s of samples, at least {window:g} s are needed: "
            "record a run of `rodless drive`"
        )


def _check_absolute(run: MeasuredRun) -> None:
    for name in PRESSURES:
        lowest = float(np.min(getattr(run, name)))
        if lowest < LOWEST_PRESSURE:
            raise RunError(f"{name} falls to {lowest:.6g} Pa; absolute pressures are needed, in Pa")


def _check_chambers(run: MeasuredRun) -> None:
    """Refuse pressures that were not read: their difference moves the carriage."""
    difference = run.pressure_a - run.pressure_b
    if _moves(run) and float(np.ptp(difference)) < SMALLEST_CHANGE:
        raise RunError(
            f"pressure_a is {difference[0]:.6g} Pa above pressure_b in all samples, while the "
            "carriage moves: sensors that are frozen or not connected, or one read for both"
        )


def _check_position(run: MeasuredRun) -> None:
    """Refuse a position that was not read for a while: it stands still, and jumps."""
    for first, last in _constant(run.position, FROZEN_TIME / run.period):
        if last == len(run.position):
            continue
        jump = abs(float(run.position[last] - run.position[first]))
        if jump > FASTEST * run.period:
            raise RunError(
                f"position is {run.position[first]:.6g} m from {run.time[first]:.6g} s on, and at "
                f"sample {last}, at {run.time[last]:.6g} s, jumps by {jump * 1e3:.3g} mm: its "
                "sensor was frozen, or samples were lost"
            )


def _check_frozen(run: MeasuredRun) -> None:
    """Refuse the pressure of a chamber that was not read for a while: its noise ends at once.

    That of an ideal sensor ends by and by, where the pressure settles, and one of coarse steps has
    little.
    """
    for name in CHAMBERS:
        values = getattr(run, name)
        steps = np.abs(np.diff(values))
        changes = np.count_nonzero(steps)
        for first, last in _constant(values, FEWEST_FROZEN):
            beside = len(steps) - (last - 1 - first)
            if (
                changes > NOISY_SHARE * beside
                and _at_once(steps, first, last)
                and float(np.ptp(run.position[first:last])) >= FROZEN_TRAVEL
            ):
                raise RunError(
                    f"{name} is {values[first]:.6g} Pa from {run.time[first]:.6g} to "
                    f"{run.time[last - 1]:.6g} s, while the carriage moves: its sensor was frozen, "
                    "or samples were lost; cut the run there"
                )


def _at_once(steps: npt.NDArray[np.float64], first: int, last: int) -> bool:
    """Whether values whose ``steps`` (n,) are 0 from ``first`` to ``last`` changed right before.

    Of those that begin the run: whether they change right after it.
    """
    if first:
        return bool(steps[first - 1] > SETTLED)
    return bool(np.any(steps[last - 1 : last] >= SMALLEST_EDGE))


def frozen_sensors(run: MeasuredRun) -> list[str]:
    """Say of which chamber the pressure never changes, while the carriage moves."""
    return [
        f"{name} is {getattr(run, name)[0]:.6g} Pa in all samples, while the carriage moves: "
        "unless that is a stated value, the sensor is frozen, and the results do not hold"
        for name in CHAMBERS
        if _moves(run) and float(np.ptp(getattr(run, name))) < SMALLEST_CHANGE
    ]


def _moves(run: MeasuredRun) -> bool:
    return float(np.ptp(run.position)) > SMALLEST_MOTION


def _constant(values: npt.NDArray[np.float64], fewest: float) -> list[tuple[int, int]]:
    """Return first and end of each stretch of ``fewest`` or more equal ``values``, shape (n,)."""
    ends = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [len(values)]])
    long = np.flatnonzero(np.diff(ends) >= fewest)
    return list(zip(ends[long].tolist(), ends[long + 1].tolist(), strict=True))


def _check(run: MeasuredRun, name: str, limits: tuple[float, float], words: str) -> None:
    values = getattr(run, name)
    beyond = np.flatnonzero((values < limits[0]) | (values > limits[1]))
    if len(beyond):
        place = int(beyond[0])
        raise RunError(
            f"{name}: sample {place}, at {run.time[place]:.6g} s, is {values[place]:.6g} {words}"
        )
