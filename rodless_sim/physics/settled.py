"""Chamber pressures of a held carriage once the flows through the valve balance."""

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

from scipy.optimize import brentq

from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import flow_into_a, flow_into_b, openings

ChamberFlow = Callable[[Plant, Lands, float], float]


@lru_cache(maxsize=256)
def settled_pressures(plant: Plant, voltage: float) -> tuple[float, float]:
    """Return P_a and P_b in Pa at which no net air enters either chamber at ``voltage`` (V).

    A valve that seals perfectly leaves both at ambient pressure. Raises SimulationError for one
    that fills a chamber past the supply's pressure.
    """
    lands = openings(plant, voltage)
    supply, ambient = plant.supply_pressure, plant.ambient_pressure

    def balance(chamber_flow: ChamberFlow) -> float:
        def net(pressure: float) -> float:
            return chamber_flow(plant, lands, pressure)

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

    return balance(flow_into_a), balance(flow_into_b)
