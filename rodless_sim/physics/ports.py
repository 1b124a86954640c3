# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The valve's ports: which edge joins which pressures, and what each chamber receives."""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics import flow_law, valve_assembly
from rodless_sim.physics.flow import Flow, both
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant


@kernel
def openings(plant: Plant, voltage: float) -> Lands:
    """Openings of the four land edges at ``voltage`` (V) by the selected assembly."""
    assembly = plant.assembly
    return valve_assembly.lands(assembly.code, assembly.own, plant.air, plant.valve, voltage)


@kernel
def restrictions(
    plant: Plant, edge: Edge, pressure_1: float, pressure_2: float
) -> tuple[Flow, Flow]:
    """Flows from side 1 to side 2 through the orifice of an edge and through its gap."""
    air, assembly = plant.air, plant.assembly
    return (
        flow_law.orifice(plant.flow_law, air, edge.orifice_area, pressure_1, pressure_2),
        valve_assembly.gap(assembly.code, assembly.own, air, edge, pressure_1, pressure_2),
    )


@kernel
def flow_past(plant: Plant, edge: Edge, pressure_1: float, pressure_2: float) -> Flow:
    """Flow from side 1 to side 2 of an edge: orifice and gap side by side."""
    through, along = restrictions(plant, edge, pressure_1, pressure_2)
    return both(through, along)


@kernel
def edge_flow(plant: Plant, edge: Edge, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s of :func:`flow_past` an edge."""
    return flow_past(plant, edge, pressure_1, pressure_2).mass_flow


class Inflow(NamedTuple):
    """The net mass flow into a chamber, and how it changes with the pressures."""

    mass_flow: float  # kg/s
    by_pressure: float  # kg/(s·Pa), with the chamber's own
    by_other: float  # kg/(s·Pa), with the other chamber's


@kernel
def net_inflow(plant: Plant, inlet: Edge, outlet: Edge, pressure: float) -> Inflow:
    """Net flow into a chamber at ``pressure`` (Pa): in from the supply, out to the atmosphere."""
    inward = flow_past(plant, inlet, plant.supply_pressure, pressure)
    outward = flow_past(plant, outlet, pressure, plant.ambient_pressure)
    return Inflow(
        inward.mass_flow - outward.mass_flow, inward.by_pressure_2 - outward.by_pressure_1, 0.0
    )


@kernel
def inflow_a(plant: Plant, lands: Lands, pressure: float) -> Inflow:
    """Net flow into chamber A, eqs. (1) and (17): in through 1a, out through 5."""
    inlet = lands.opening if lands.forward else lands.closing
    outlet = lands.closing if lands.forward else lands.opening
    return net_inflow(plant, inlet, outlet, pressure)


@kernel
def inflow_b(plant: Plant, lands: Lands, pressure: float) -> Inflow:
    """Net flow into chamber B, eqs. (2) and (18): in through 1b, out through 3."""
    inlet = lands.closing if lands.forward else lands.opening
    outlet = lands.opening if lands.forward else lands.closing
    return net_inflow(plant, inlet, outlet, pressure)


@kernel
def supply_flow(plant: Plant, lands: Lands, pressure_a: float, pressure_b: float) -> float:
    """Mass flow in kg/s that leaves the supply through edges 1a and 1b."""
    edge_a = lands.opening if lands.forward else lands.closing
    edge_b = lands.closing if lands.forward else lands.opening
    supply = plant.supply_pressure
    return edge_flow(plant, edge_a, supply, pressure_a) + edge_flow(
        plant, edge_b, supply, pressure_b
    )
