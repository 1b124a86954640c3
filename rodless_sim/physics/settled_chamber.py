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
from rodless_sim.physics.root import MOST_STEPS, begun, next_guess, told
from rodless_sim.physics.state import HeatedMotion, Motion

# How exactly a pressure and a temperature are looked for where they balance.
PRESSURE_ERROR = 1e-6  # Pa
TEMPERATURE_ERROR = 1e-9  # K
RELATIVE_ERROR = 1e-14


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
    if not (inward > 0.0 >= outward):
        return math.nan
    search = begun(empty, full, inward, outward)
    for _ in range(MOST_STEPS):
        search = next_guess(search, PRESSURE_ERROR, RELATIVE_ERROR)
        if search.found:
            return search.now
        flow = net_into(plant, lands, chamber, temperature, search.now)
        if math.isnan(flow):
            return math.nan
        search = told(search, flow)
    return math.nan


@outlined_kernel
def heat_gained(plant: Plant, lands: Lands, chamber: int, loss: float, temperature: float) -> float:
    """Heat (W) that a chamber at ``temperature`` (K) gains at the pressure at which it settles.

    The other chamber is at ambient pressure, as warm as the walls; ``loss`` to them is in W/K.
    """
    pressure = settled_chamber(plant, lands, chamber, temperature)
    ambient, wall = plant.ambient_pressure, plant.heat.wall_temperature
    flows: Any  # of a heated plant, with the heat that they carry
    if chamber == 0:
        flows = inflows(plant, lands, HeatedMotion(0.0, 0.0, pressure, ambient, temperature, wall))
        carried = flows.a.enthalpy_flow
    else:
        flows = inflows(plant, lands, HeatedMotion(0.0, 0.0, ambient, pressure, wall, temperature))
        carried = flows.b.enthalpy_flow
    return float(carried + loss * (wall - temperature))


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
    search = begun(low, high, coldest, warmest)
    for _ in range(MOST_STEPS):
        search = next_guess(search, TEMPERATURE_ERROR, RELATIVE_ERROR)
        if search.found:
            return settled_chamber(plant, lands, chamber, search.now), search.now
        gained = heat_gained(plant, lands, chamber, loss, search.now)
        if math.isnan(gained):
            return math.nan, math.nan
        search = told(search, gained)
    return math.nan, math.nan
