"""The valve's ports: which edge joins which pressures, and what each chamber receives."""

from rodless_base.kernels import kernel
from rodless_sim.physics import valve_assembly
from rodless_sim.physics.flow import orifice_flow
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant


@kernel
def openings(plant: Plant, voltage: float) -> Lands:
    """Openings of the four land edges at ``voltage`` (V) by the selected assembly."""
    assembly = plant.assembly
    return valve_assembly.lands(assembly.code, assembly.own, plant.air, plant.valve, voltage)


@kernel
def edge_flow(plant: Plant, edge: Edge, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s from side 1 to side 2 of an edge: orifice and gap side by side."""
    air, assembly = plant.air, plant.assembly
    flow = orifice_flow(air, edge.orifice_area, pressure_1, pressure_2)
    return flow + valve_assembly.gap_flow(
        assembly.code, assembly.own, air, edge, pressure_1, pressure_2
    )


@kernel
def flow_into_a(plant: Plant, lands: Lands, pressure: float) -> float:
    """Net mass flow into chamber A in kg/s, eqs. (1) and (17): in through 1a, out through 5."""
    inlet = lands.opening if lands.forward else lands.closing
    outlet = lands.closing if lands.forward else lands.opening
    return edge_flow(plant, inlet, plant.supply_pressure, pressure) - edge_flow(
        plant, outlet, pressure, plant.ambient_pressure
    )


@kernel
def flow_into_b(plant: Plant, lands: Lands, pressure: float) -> float:
    """Net mass flow into chamber B in kg/s, eqs. (2) and (18): in through 1b, out through 3."""
    inlet = lands.closing if lands.forward else lands.opening
    outlet = lands.opening if lands.forward else lands.closing
    return edge_flow(plant, inlet, plant.supply_pressure, pressure) - edge_flow(
        plant, outlet, pressure, plant.ambient_pressure
    )


@kernel
def supply_flow(plant: Plant, lands: Lands, pressure_a: float, pressure_b: float) -> float:
    """Mass flow in kg/s that leaves the supply through edges 1a and 1b."""
    edge_a = lands.opening if lands.forward else lands.closing
    edge_b = lands.closing if lands.forward else lands.opening
    supply = plant.supply_pressure
    return edge_flow(plant, edge_a, supply, pressure_a) + edge_flow(
        plant, edge_b, supply, pressure_b
    )
