"""The valve's ports: which edge joins which pressures, and what each chamber receives."""

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import gap_flow, gap_flow_printed, orifice_flow
from rodless_sim.physics.valve import Edge, Lands


@kernel
def edge_flow(air: Air, printed: bool, edge: Edge, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s through one land edge: its orifice and its gap side by side."""
    flow = orifice_flow(air, edge.orifice_area, pressure_1, pressure_2)
    if printed:
        return flow + gap_flow_printed(edge.gap, pressure_1, pressure_2)
    return flow + gap_flow(edge.gap, pressure_1, pressure_2)


@kernel
def flow_into_a(air: Air, lands: Lands, supply: float, chamber: float, ambient: float) -> float:
    """Net mass flow into chamber A in kg/s, eqs. (1) and (17): in through 1a, out through 5."""
    inlet = lands.opening if lands.forward else lands.closing
    outlet = lands.closing if lands.forward else lands.opening
    return edge_flow(air, lands.printed, inlet, supply, chamber) - edge_flow(
        air, lands.printed, outlet, chamber, ambient
    )


@kernel
def flow_into_b(air: Air, lands: Lands, supply: float, chamber: float, ambient: float) -> float:
    """Net mass flow into chamber B in kg/s, eqs. (2) and (18): in through 1b, out through 3."""
    inlet = lands.closing if lands.forward else lands.opening
    outlet = lands.opening if lands.forward else lands.closing
    return edge_flow(air, lands.printed, inlet, supply, chamber) - edge_flow(
        air, lands.printed, outlet, chamber, ambient
    )


@kernel
def supply_flow(
    air: Air, lands: Lands, supply: float, pressure_a: float, pressure_b: float
) -> float:
    """Mass flow in kg/s that leaves the supply through edges 1a and 1b."""
    edge_a = lands.opening if lands.forward else lands.closing
    edge_b = lands.closing if lands.forward else lands.opening
    return edge_flow(air, lands.printed, edge_a, supply, pressure_a) + edge_flow(
        air, lands.printed, edge_b, supply, pressure_b
    )
