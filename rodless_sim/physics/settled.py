"""What the chambers of a held carriage settle at, once flows and heat balance."""

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

from scipy.optimize import brentq

from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.heat import NetInflow, wall_area
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import flow_into_a, flow_into_b, openings
from rodless_sim.physics.state import AnyMotion, HeatedMotion, Motion
from rodless_sim.physics.streams import stream_into_a, stream_into_b

ChamberFlow = Callable[[Plant, Lands, float], float]
ChamberStream = Callable[[Plant, Lands, float, float], NetInflow]


@lru_cache(maxsize=256)
def settled_pressures(plant: Plant, voltage: float) -> tuple[float, float]:
    """Return P_a and P_b in Pa at which no net air enters either chamber at ``voltage`` (V).

    A valve that seals perfectly leaves both at ambient pressure. Raises SimulationError for one
    that fills a chamber past the supply's pressure.
    """
    lands = openings(plant, voltage)

    def balance(chamber_flow: ChamberFlow) -> float:
        return _without_flow(plant, voltage, lambda p: chamber_flow(plant, lands, p))

    return balance(flow_into_a), balance(flow_into_b)


@lru_cache(maxsize=256)
def settled_temperatures(
    plant: Plant, voltage: float, position: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return P and T (Pa, K) of A and of B at which neither mass nor energy changes.

    The carriage is held at ``position`` (m), the valve at ``voltage`` (V). Raises as
    :func:`settled_pressures`.
    """
    lands, heat = openings(plant, voltage), plant.heat
    known = (plant.air.temperature, heat.wall_temperature, heat.ambient_temperature)
    volumes = volume_a(plant.cylinder, position), volume_b(plant.cylinder, position)

    def balance(chamber: ChamberStream, volume: float) -> tuple[float, float]:
        loss = heat.coefficient * wall_area(heat, volume)

        def pressure(temperature: float) -> float:
            return _without_flow(
                plant, voltage, lambda p: chamber(plant, lands, p, temperature).mass_flow
            )

        def power(temperature: float) -> float:
            flow = chamber(plant, lands, pressure(temperature), temperature)
            return float(flow.enthalpy_flow + loss * (heat.wall_temperature - temperature))

        # The air settles between the coldest and the warmest that it meets.
        low, high = min(known) - 1.0, max(known) + 1.0
        if power(low) == power(high):  # nothing flows, no wall warms: any temperature is settled
            return pressure(heat.wall_temperature), heat.wall_temperature
        temperature = float(brentq(power, low, high, xtol=1e-9, rtol=1e-14))
        return pressure(temperature), temperature

    return balance(stream_into_a, volumes[0]), balance(stream_into_b, volumes[1])


def settled_motion(plant: Plant, voltage: float, position: float) -> AnyMotion:
    """Return the state at rest at ``position`` (m) with the chambers settled at ``voltage`` (V)."""
    if not plant.heat:
        return Motion(position, 0.0, *settled_pressures(plant, voltage))
    a, b = settled_temperatures(plant, voltage, position)
    return HeatedMotion(position, 0.0, a[0], b[0], a[1], b[1])


def _without_flow(plant: Plant, voltage: float, net: Callable[[float], float]) -> float:
    """Return the pressure in Pa at which ``net`` (kg/s by pressure) is zero."""
    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    if net(ambient) <= 0.0:
        return ambient
    # Coefficients beyond any valve overflow, and then no pressure balances either.
    if net(supply) <= 0.0:
        with suppress(ValueError, RuntimeError):
            return float(brentq(net, ambient, supply, xtol=1e-6, rtol=1e-14))
    raise SimulationError(
        f"the chambers do not settle at {voltage:g} V; check valve.area_coefficients and "
        "valve.flow_coefficients"
    )
