# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The pressure at which a closed valve leaves one chamber, without a call back to Python.

Brent's method (Algorithms for Minimization without Derivatives, 1973, chapter 4), step for step as
scipy's ``brentq``, with the same bits: an ensemble settles thousands of rigs, and a call from scipy
for each flow would take as long as a run.
"""

import math

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import HeatedMotion, Motion

# How exactly a pressure is looked for where it balances.
PRESSURE_ERROR = 1e-6  # Pa
RELATIVE_ERROR = 1e-14

MOST_STEPS = 100  # then scipy gives up, too


@kernel
def net_into(
    plant: Plant, lands: Lands, chamber: int, temperature: float | None, pressure: float
) -> float:
    """Net mass flow in kg/s into chamber A (0) or B (1) at ``pressure`` (Pa).

    The other chamber is at ambient pressure and, where air has one, at this ``temperature`` (K).
    """
    ambient = plant.ambient_pressure
    if temperature is not None:
        if chamber == 0:
            warm = HeatedMotion(0.0, 0.0, pressure, ambient, temperature, temperature)
            return inflows(plant, lands, warm).a.mass_flow
        warm = HeatedMotion(0.0, 0.0, ambient, pressure, temperature, temperature)
        return inflows(plant, lands, warm).b.mass_flow
    if chamber == 0:
        return inflows(plant, lands, Motion(0.0, 0.0, pressure, ambient)).a.mass_flow
    return inflows(plant, lands, Motion(0.0, 0.0, ambient, pressure)).b.mass_flow


@outlined_kernel
def settled_chamber(plant: Plant, lands: Lands, chamber: int, temperature: float | None) -> float:
    """Return the pressure in Pa at which nothing enters a chamber, NaN where there is none.

    ``temperature`` (K) is that of its air, None where air has none.
    """
    empty, full = plant.ambient_pressure, plant.supply_pressure
    inward = net_into(plant, lands, chamber, temperature, empty)
    if inward <= 0.0:
        return empty
    outward = net_into(plant, lands, chamber, temperature, full)
    if outward == 0.0:
        return full
    if outward < 0.0:
        return between(plant, lands, chamber, temperature, empty, full, inward, outward)
    return math.nan


@kernel
def between(
    plant: Plant,
    lands: Lands,
    chamber: int,
    temperature: float | None,
    before: float,
    now: float,
    flow_before: float,
    flow_now: float,
) -> float:
    """Return the root (Pa) between two pressures whose flows have opposite signs."""
    # The root is between ``now``, the best so far, and ``behind``.
    behind, flow_behind = before, flow_before
    step_before = step = now - before
    for _ in range(MOST_STEPS):
        if flow_before != 0.0 and flow_now != 0.0 and (flow_before < 0.0) != (flow_now < 0.0):
            behind, flow_behind = before, flow_before
            step_before = step = now - before
        if abs(flow_behind) < abs(flow_now):
            before, now, behind = now, behind, now
            flow_before, flow_now, flow_behind = flow_now, flow_behind, flow_now
        error = (PRESSURE_ERROR + RELATIVE_ERROR * abs(now)) / 2.0
        half = (behind - now) / 2.0
        if flow_now == 0.0 or abs(half) < error:
            return now
        tried = math.inf
        if abs(step_before) > error and abs(flow_now) < abs(flow_before):
            tried = interpolated(before, now, behind, flow_before, flow_now, flow_behind)
        if 2.0 * abs(tried) < min(abs(step_before), 3.0 * abs(half) - error):
            step_before, step = step, tried
        else:
            step_before = step = half
        before, flow_before = now, flow_now
        now += step if abs(step) > error else math.copysign(error, half)
        flow_now = net_into(plant, lands, chamber, temperature, now)
        if math.isnan(flow_now):
            return math.nan
    return math.nan


@kernel
def interpolated(
    before: float,
    now: float,
    behind: float,
    flow_before: float,
    flow_now: float,
    flow_behind: float,
) -> float:
    """Step (Pa) from ``now`` to where a line, or with three pressures a curve, has no flow."""
    if before == behind:
        return -flow_now * (now - before) / (flow_now - flow_before)
    slope = (flow_before - flow_now) / (before - now)
    other = (flow_behind - flow_now) / (behind - now)
    top = -flow_now * (flow_behind * other - flow_before * slope)
    return top / (other * slope * (flow_behind - flow_before))
