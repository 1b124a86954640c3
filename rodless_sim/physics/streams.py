"""What flows into chambers that have temperatures of their own, and the enthalpy it brings.

The flow equations are written for air of the supply's temperature. Upstream air of T passes an
orifice by √(T_s/T) of that, eq. (6), and a gap by T_s/T, eq. (14): its density.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics.heat import NetInflow, enthalpy_capacity
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import restrictions
from rodless_sim.physics.state import HeatedMotion


class Stream(NamedTuple):
    """A mass flow from side 1 to side 2, by both pressures and by the temperature upstream."""

    mass_flow: float  # kg/s
    by_pressure_1: float  # kg/(s·Pa)
    by_pressure_2: float  # kg/(s·Pa)
    by_temperature: float  # kg/(s·K)


@kernel
def stream(
    plant: Plant, edge: Edge, pressure_1: float, pressure_2: float, temperature: float
) -> Stream:
    """Flow past an edge whose upstream air has ``temperature`` (K)."""
    ratio = plant.air.temperature / temperature
    root = math.sqrt(ratio)
    through, along = restrictions(plant, edge, pressure_1, pressure_2)
    orifice, gap = root * through.mass_flow, ratio * along.mass_flow
    return Stream(
        orifice + gap,
        root * through.by_pressure_1 + ratio * along.by_pressure_1,
        root * through.by_pressure_2 + ratio * along.by_pressure_2,
        -(0.5 * orifice + gap) / temperature,
    )


@kernel
def from_supply(plant: Plant, inlet: Edge, pressure: float, temperature: float) -> Stream:
    """Flow from the supply into a chamber of ``pressure`` (Pa) and ``temperature`` (K)."""
    supply = plant.supply_pressure
    if supply < pressure:
        return stream(plant, inlet, supply, pressure, temperature)
    found = stream(plant, inlet, supply, pressure, plant.air.temperature)
    return Stream(found.mass_flow, found.by_pressure_1, found.by_pressure_2, 0.0)


@kernel
def to_atmosphere(plant: Plant, outlet: Edge, pressure: float, temperature: float) -> Stream:
    """Flow to the atmosphere from a chamber of ``pressure`` (Pa) and ``temperature`` (K)."""
    ambient = plant.ambient_pressure
    if pressure >= ambient:
        return stream(plant, outlet, pressure, ambient, temperature)
    found = stream(plant, outlet, pressure, ambient, plant.heat.ambient_temperature)
    return Stream(found.mass_flow, found.by_pressure_1, found.by_pressure_2, 0.0)


@kernel
def net_stream(
    plant: Plant, inlet: Edge, outlet: Edge, pressure: float, temperature: float
) -> NetInflow:
    """Return what flows into a chamber: in from the supply, out to the atmosphere."""
    inward = from_supply(plant, inlet, pressure, temperature)
    outward = to_atmosphere(plant, outlet, pressure, temperature)
    # The flow whose upstream side is the chamber brings air of the chamber's temperature.
    back = inward.mass_flow if plant.supply_pressure < pressure else 0.0
    out = outward.mass_flow if pressure >= plant.ambient_pressure else 0.0
    source = temperature if plant.supply_pressure < pressure else plant.air.temperature
    drain = temperature if pressure >= plant.ambient_pressure else plant.heat.ambient_temperature
    capacity = enthalpy_capacity(plant.air)
    return NetInflow(
        inward.mass_flow - outward.mass_flow,
        inward.by_pressure_2 - outward.by_pressure_1,
        inward.by_temperature - outward.by_temperature,
        capacity * (source * inward.mass_flow - drain * outward.mass_flow),
        capacity * (source * inward.by_pressure_2 - drain * outward.by_pressure_1),
        capacity * (back - out + source * inward.by_temperature - drain * outward.by_temperature),
    )


@kernel
def stream_into_a(plant: Plant, lands: Lands, pressure: float, temperature: float) -> NetInflow:
    """Return what flows into chamber A: in through 1a, out through 5."""
    inlet = lands.opening if lands.forward else lands.closing
    outlet = lands.closing if lands.forward else lands.opening
    return net_stream(plant, inlet, outlet, pressure, temperature)


@kernel
def stream_into_b(plant: Plant, lands: Lands, pressure: float, temperature: float) -> NetInflow:
    """Return what flows into chamber B: in through 1b, out through 3."""
    inlet = lands.closing if lands.forward else lands.opening
    outlet = lands.opening if lands.forward else lands.closing
    return net_stream(plant, inlet, outlet, pressure, temperature)


@kernel
def heated_supply_flow(plant: Plant, lands: Lands, state: HeatedMotion) -> float:
    """Mass flow in kg/s that leaves the supply through edges 1a and 1b."""
    edge_a = lands.opening if lands.forward else lands.closing
    edge_b = lands.closing if lands.forward else lands.opening
    a = from_supply(plant, edge_a, state.pressure_a, state.temperature_a)
    b = from_supply(plant, edge_b, state.pressure_b, state.temperature_b)
    return a.mass_flow + b.mass_flow
