"""Chamber pressures of a held carriage once the flows through valve and leaks balance."""

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

from scipy.optimize import brentq

from rodless_sim.physics.equations import inflows
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion


@lru_cache(maxsize=256)
def settled_pressures(plant: Plant, voltage: float) -> tuple[float, float]:
    """Return P_a and P_b in Pa at which no net air enters either chamber at ``voltage`` (V).

    A valve that seals perfectly leaves both at ambient pressure. Raises SimulationError for one
    that fills a chamber past the supply's pressure.
    """
    lands = openings(plant, voltage)
    supply, ambient = plant.supply_pressure, plant.ambient_pressure

    def net(pressure_a: float, pressure_b: float) -> tuple[float, float]:
        a, b = inflows(plant, lands, Motion(0.0, 0.0, pressure_a, pressure_b))
        return a.mass_flow, b.mass_flow

    def balance(chamber_flow: Callable[[float], float]) -> float:
        if chamber_flow(ambient) <= 0.0:
            return ambient
        # Coefficients beyond any valve overflow, and then no pressure balances either.
        if chamber_flow(supply) <= 0.0:
            with suppress(ValueError, RuntimeError):
                return float(brentq(chamber_flow, ambient, supply, xtol=1e-6, rtol=1e-14))
        raise SimulationError(
            f"the chambers do not settle at {voltage:g} V; check valve.area_coefficients and "
            "valve.flow_coefficients"
        )

    def balance_a(pressure_b: float) -> float:
        return balance(lambda pressure: net(pressure, pressure_b)[0])

    if plant.leak.across == 0.0:
        return balance_a(ambient), balance(lambda pressure: net(ambient, pressure)[1])
    pressure_b = balance(lambda pressure: net(balance_a(pressure), pressure)[1])
    return balance_a(pressure_b), pressure_b
