# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What one chamber settles at with the valve held, without a call back to Python.

An ensemble settles thousands of rigs, and a call from scipy for each flow would take as long as a
run, and would keep other threads waiting for the interpreter.
"""

import math
from typing import Any

from rodless_base.kernels import kernel, outlined_kernel
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.root import MOST_STEPS, begun, next_guess
from rodless_sim.physics.state import HeatedMotion, Motion

# How exactly a pressure and a temperature are looked for where they balance.
PRESSURE_ERROR = 1e-6  # Pa
TEMPERATURE_ERROR = 1e-9  # K
RELATIVE_ERROR = 1e-14


@kernel
def warm_inflow(
    plant: Plant, lands: Lands, chamber: int, pressure: float, temperature: float, beside: float
) -> Any:
    """What enters chamber A (0) or B (1) of a heated plant; the other has ambient pressure.

    The other's air is at ``beside`` (K).
    """
    ambient = plant.ambient_pressure
    if chamber == 0:
        warm = HeatedMotion(0.0, 0.0, pressure, ambient, temperature, beside)
        return inflows(plant, lands, warm).a
    warm = HeatedMotion(0.0, 0.0, ambient, pressure, beside, temperature)
    return inflows(plant, lands, warm).b


@kernel
def net_into(
    plant: Plant, lands: Lands, chamber: int, temperature: float | None, pressure: float
) -> float:
    """Net mass flow in kg/s into chamber A (0) or B (1) at ``pressure`` (Pa).

    The other chamber is at ambient pressure and, where air has one, at this ``temperature`` (K).
    """
    if temperature is not None:
        inflow = warm_inflow(plant, lands, chamber, pressure, temperature, temperature)
        return float(inflow.mass_flow)
    ambient = plant.ambient_pressure
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
    if not (inward > 0.0 >= outward):
        return math.nan
    search, flow = begun(empty, full, inward), outward
    for _ in range(MOST_STEPS):
        search = next_guess(search, flow, PRESSURE_ERROR, RELATIVE_ERROR)
        if search.found:
            return search.now
        flow = net_into(plant, lands, chamber, temperature, search.now)
        if math.isnan(flow):
            return math.nan
    return math.nan


@outlined_kernel
def heat_gained(plant: Plant, lands: Lands, chamber: int, loss: float, temperature: float) -> float:
    """Heat (W) that a chamber at ``temperature`` (K) gains at the pressure at which it settles.

    The other chamber is at ambient pressure, as warm as the walls; ``loss`` to them is in W/K.
    """
    pressure = settled_chamber(plant, lands, chamber, temperature)
    wall = plant.heat.wall_temperature
    inflow = warm_inflow(plant, lands, chamber, pressure, temperature, wall)
    return float(inflow.enthalpy_flow + loss * (wall - temperature))


@outlined_kernel
def settled_warm_chamber(
    plant: Plant, lands: Lands, chamber: int, loss: float, low: float, high: float
) -> tuple[float, float]:
    """Return P and T (Pa, K) at which a chamber keeps its air and its heat, NaN where it cannot.

    T lies between ``low`` and ``high`` (K); ``loss`` is to the walls, in W/K.
    """
    wall = plant.heat.wall_temperature
    coldest = heat_gained(plant, lands, chamber, loss, low)
    warmest = heat_gained(plant, lands, chamber, loss, high)
    if coldest == warmest:  # nothing flows, no wall warms: any temperature is settled
        return settled_chamber(plant, lands, chamber, wall), wall
    if coldest == 0.0:
        return settled_chamber(plant, lands, chamber, low), low
    if not (coldest < 0.0 <= warmest or warmest <= 0.0 < coldest):
        return math.nan, math.nan
    search, gained = begun(low, high, coldest), warmest
    for _ in range(MOST_STEPS):
        search = next_guess(search, gained, TEMPERATURE_ERROR, RELATIVE_ERROR)
        if search.found:
            return settled_chamber(plant, lands, chamber, search.now), search.now
        gained = heat_gained(plant, lands, chamber, loss, search.now)
        if math.isnan(gained):
            return math.nan, math.nan
    return math.nan, math.nan
