# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the chambers of a held carriage settle at, once flows and heat balance."""

import math
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.heat import wall_area
from rodless_sim.physics.lands import Arriving, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled_chamber import (
    PRESSURE_ERROR,
    RELATIVE_ERROR,
    settled_chamber,
    settled_warm_chamber,
)
from rodless_sim.physics.state import AnyMotion, HeatedMotion, Motion

# What counts as balanced: heat that would warm a chamber by some microkelvins in a second.
SMALLEST_POWER = 1e-6  # W

# Of heat to a wall: that which the least of leaks carries away is more.
SMALLEST_LOSS = 1e-9  # W/K


def load_for(plant: Plant) -> None:
    """Load what it takes to settle a plant whose chambers depend on each other, or have tubes.

    It takes half as long as to load all else of a node: others do without, and what keeps time does
    it beforehand.
    """
    if plant.leak.across != 0.0 or (plant.heat and plant.tubes):
        import scipy.optimize  # noqa: F401, PLC0415


@lru_cache(maxsize=256)
def settled_pressures(plant: Plant, voltage: float) -> tuple[float, float]:
    """Return P_a and P_b in Pa at which no net air enters either chamber at ``voltage`` (V).

    A valve that seals perfectly leaves both at ambient pressure. Raises SimulationError for one
    that fills a chamber past the supply's pressure.
    """
    lands = openings(plant, voltage)
    if plant.leak.across == 0.0:
        found = _settled_apart(plant, lands)
        if found is None:
            raise _unsettled(voltage)
        return found

    def net(pressure_a: float, pressure_b: float) -> tuple[float, float]:
        a, b = inflows(plant, lands, Motion(0.0, 0.0, pressure_a, pressure_b))
        return a.mass_flow, b.mass_flow

    def balance(chamber_flow: Callable[[float], float]) -> float:
        return _without_flow(plant, voltage, chamber_flow)

    def balance_a(pressure_b: float) -> float:
        return balance(lambda pressure: net(pressure, pressure_b)[0])

    pressure_b = balance(lambda pressure: net(balance_a(pressure), pressure)[1])
    return balance_a(pressure_b), pressure_b


def settled_motion(plant: Plant, voltage: float, position: float) -> AnyMotion:
    """Return the state at rest at ``position`` (m) with the chambers settled at ``voltage`` (V)."""
    if not plant.heated:
        return Motion(position, 0.0, *settled_pressures(plant, voltage))
    return settled_air(plant, voltage, position)


@lru_cache(maxsize=256)
def settled_air(plant: Plant, voltage: float, position: float) -> HeatedMotion:
    """Return the state at rest in which neither mass nor energy of a chamber changes.

    The carriage is held at ``position`` (m), the valve at ``voltage`` (V). Raises as
    :func:`settled_pressures`.
    """
    lands = openings(plant, voltage)
    losses = [
        plant.heat.coefficient * wall_area(plant.heat, volume)
        for volume in (volume_a(plant.cylinder, position), volume_b(plant.cylinder, position))
    ]
    if plant.leak.across == 0.0 and not plant.tubes:
        a, b = (_chamber(plant, lands, voltage, chamber, losses[chamber]) for chamber in (0, 1))
    else:
        a, b = _both(plant, lands, voltage, losses)
    return HeatedMotion(position, 0.0, a[0], b[0], a[1], b[1])


def _wall(plant: Plant) -> float:
    return float(plant.heat.wall_temperature)


def _chamber(
    plant: Plant, lands: Lands, voltage: float, chamber: int, loss: float
) -> tuple[float, float]:
    """Return P and T (Pa, K) of a chamber that has nothing to do with the other.

    ``loss`` is to the walls, in W/K.
    """
    # The air settles between the coldest and the warmest that it meets.
    known = (plant.air.temperature, _wall(plant), plant.heat.ambient_temperature)
    low, high = min(known) - 1.0, max(known) + 1.0
    found = settled_warm_chamber(plant, lands, chamber, loss, low, high)
    if any(map(math.isnan, found)):
        raise _unsettled(voltage)
    return found


def _both(
    plant: Plant, lands: Lands, voltage: float, losses: list[float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return P and T (Pa, K) of chambers that leak into each other, or are behind tubes.

    Looked for from the pressures they settle at with one temperature, which are near.
    """
    from scipy.optimize import root  # noqa: PLC0415  see load_for

    pressures = settled_pressures(plant, voltage)
    if plant.tubes:
        # Air that neither flows nor feels its wall may have any temperature: it takes the wall's.
        losses = [max(loss, SMALLEST_LOSS) for loss in losses]
    warmth = plant.air.temperature
    scale = np.array([*pressures, warmth, warmth])

    def powers(unknown: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        pressure_a, pressure_b, warm_a, warm_b = (scale * unknown).tolist()
        state = HeatedMotion(0.0, 0.0, pressure_a, pressure_b, warm_a, warm_b)
        flows: Any = inflows(plant, _let_in(plant, lands, pressure_a, pressure_b), state)
        a, b = flows
        capacity = a.enthalpy_flow, b.enthalpy_flow
        heat = [
            flow + loss * (_wall(plant) - warm)
            for flow, loss, warm in zip(capacity, losses, (warm_a, warm_b), strict=True)
        ]
        # Mass flows as power too, so that all are of one size.
        per_mass = plant.air.gas_constant * warmth
        return np.array([per_mass * a.mass_flow, per_mass * b.mass_flow, *heat])

    start = np.array([1.0, 1.0, _wall(plant) / warmth, _wall(plant) / warmth])
    # As near as floats can tell: what counts is what is left over.
    found = root(powers, start, tol=1e-14)
    if not np.abs(powers(found.x)).max() <= SMALLEST_POWER:
        raise SimulationError(
            f"the chambers do not settle at {voltage:g} V; check the leak.*, or give pressures "
            "and temperatures to start from"
        )
    pressure_a, pressure_b, warm_a, warm_b = (scale * found.x).tolist()
    return (pressure_a, warm_a), (pressure_b, warm_b)


def _let_in(plant: Plant, lands: Lands, pressure_a: float, pressure_b: float) -> Lands | Arriving:
    """Return what lets air into chambers at these pressures (Pa): the valve, or what tubes bring.

    The valve passes air of the supply's temperature where there are tubes. The few pascals that
    what leaks loses in them are left out.
    """
    if not plant.tubes:
        return lands
    tight = plant._replace(leak=plant.leak._replace(open=False, across=0.0, a=0.0, b=0.0))
    a, b = inflows(tight, lands, Motion(0.0, 0.0, pressure_a, pressure_b))
    return Arriving(float(a.mass_flow), float(b.mass_flow))


def _without_flow(plant: Plant, voltage: float, net: Callable[[float], float]) -> float:
    """Return the pressure in Pa at which ``net`` (kg/s by pressure) is zero."""
    from scipy.optimize import brentq  # noqa: PLC0415  see load_for

    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    if net(ambient) <= 0.0:
        return ambient
    # Coefficients beyond any valve overflow, and then no pressure balances either.
    if net(supply) <= 0.0:
        with suppress(ValueError, RuntimeError):
            return float(brentq(net, ambient, supply, xtol=PRESSURE_ERROR, rtol=RELATIVE_ERROR))
    raise _unsettled(voltage)


def _settled_apart(plant: Plant, lands: Lands) -> tuple[float, float] | None:
    """Return P_a and P_b in Pa of chambers that do not leak into each other, or None."""
    a, b = (settled_chamber(plant, lands, chamber, None) for chamber in (0, 1))
    return None if math.isnan(a) or math.isnan(b) else (a, b)


def _unsettled(voltage: float) -> SimulationError:
    return SimulationError(
        f"the chambers do not settle at {voltage:g} V; check valve.area_coefficients and "
        "valve.flow_coefficients"
    )
