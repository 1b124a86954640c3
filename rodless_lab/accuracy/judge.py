# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What one random rig says about the integrator: its error, and how much the rig magnifies one."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import described
from rodless_lab.accuracy.radau import by_radau
from rodless_lab.accuracy.random_rigs import DURATION, PERIOD, Case, case
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import SimulationError, Trace, simulate

Array = npt.NDArray[np.float64]

# What time.tolerance the others are compared with.
CONVERGED = 1e-3

# As large as the error that one step may have: 2 Pa of supply, and in closed loop 10 nm of noise.
DISTURBANCE = 2.0  # Pa
NOISE = 10e-9  # m

# Of so many cases one is solved by Radau too, where it is in open loop.
RADAU_SHARE = 100
# Radau at 1e-10 can take minutes for a rig that bounces all the time.
RADAU_SECONDS = 30.0


class Verdict(NamedTuple):
    """One case in figures: largest differences over all samples; NaN where there is none."""

    number: int
    around: str
    drive: str
    travel: float  # m
    position: float  # m, error at time.tolerance 1
    pressure: float  # Pa, error at time.tolerance 1
    disturbed_position: float  # m, what DISTURBANCE and NOISE change
    disturbed_pressure: float  # Pa, likewise
    radau_position: float  # m, the converged run against Radau's
    radau_pressure: float  # Pa, likewise
    failure: str  # what could not be computed, and why


def judge(number: int) -> Verdict:
    """Run case ``number`` at both tolerances, disturbed, and for a share of them by Radau."""
    chosen = case(number)
    nothing = (math.nan,) * 7
    try:
        coarse, fine = run(chosen), run(chosen, CONVERGED)
        error = largest_difference(coarse, fine)
        moved = largest_difference(run(chosen, CONVERGED, disturbance(chosen)), fine)
    except SimulationError as failure:
        return Verdict(number, chosen.around, chosen.drive, *nothing, described(failure))
    travel = float(np.ptp(fine.position))
    radau, failure_of_radau = against_radau(chosen, fine)
    return Verdict(
        number, chosen.around, chosen.drive, travel, *error, *moved, *radau, failure_of_radau
    )


def run(chosen: Case, tolerance: float = 1.0, changes: dict[str, object] | None = None) -> Trace:
    """Return the run of a case; raises SimulationError."""
    parameters = chosen.parameters.with_values({"time.tolerance": tolerance, **(changes or {})})
    if chosen.voltages is not None:
        return simulate(parameters, chosen.voltages, PERIOD, chosen.position)
    assert chosen.law is not None
    assert chosen.reference is not None
    return closed_loop(parameters, chosen.law, chosen.reference, DURATION, PERIOD, chosen.position)


def disturbance(chosen: Case) -> dict[str, object]:
    """Return the changes that stand for an error as large as a step may have."""
    supply = chosen.parameters.number("supply.pressure")
    sign = -1.0 if supply - DISTURBANCE > chosen.parameters.number("atmosphere.pressure") else 1.0
    changes: dict[str, object] = {"supply.pressure": supply + sign * DISTURBANCE}
    if chosen.voltages is None:
        changes["sensors.position_noise"] = NOISE
    return changes


def largest_difference(one: Trace, other: Trace) -> tuple[float, float]:
    """Largest difference in position (m) and in either pressure (Pa)."""
    return differences(one, columns(other))


def differences(trace: Trace, rows: Array) -> tuple[float, float]:
    """:func:`largest_difference` from ``rows``: position, pressures A and B; shape (n, 3)."""
    away = np.abs(columns(trace) - rows).max(axis=0)
    return float(away[0]), float(away[1:].max())


def columns(trace: Trace) -> Array:
    """Position (m) and pressures A and B (Pa), shape (n, 3)."""
    return np.column_stack([trace.position, trace.pressure_a, trace.pressure_b])


def against_radau(chosen: Case, fine: Trace) -> tuple[tuple[float, float], str]:
    """Return how far the converged run is from Radau's, and why there is no such figure if so."""
    if chosen.voltages is None or chosen.number % RADAU_SHARE:
        return (math.nan, math.nan), ""
    try:
        rows = by_radau(chosen.parameters, chosen.voltages, PERIOD, chosen.position, RADAU_SECONDS)
    except (RuntimeError, TimeoutError) as failure:
        return (math.nan, math.nan), f"Radau: {described(failure)}"
    return differences(fine, rows[:, [0, 2, 3]]), ""
