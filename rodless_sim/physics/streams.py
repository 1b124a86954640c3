# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What flows into chambers that have temperatures of their own, and the enthalpy it carries.

The flow equations are written for air of the supply's temperature. Upstream air of T passes an
orifice by √(T_s/T) of that, eq. (6), and a gap by T_s/T, eq. (14): its density.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow, orifice
from rodless_sim.physics.heat import NetInflow, enthalpy_capacity
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import restrictions
from rodless_sim.physics.state import FullMotion, HeatedMotion

NO_FLOW = Flow(0.0, 0.0, 0.0)


class Stream(NamedTuple):
    """A flow from side 1 to side 2 and the enthalpy it carries, by the states of both sides."""

    mass_flow: float  # kg/s
    by_pressure_1: float  # kg/(s·Pa)
    by_pressure_2: float  # kg/(s·Pa)
    by_temperature_1: float  # kg/(s·K)
    by_temperature_2: float  # kg/(s·K)
    enthalpy_flow: float  # W
    enthalpy_by_pressure_1: float  # W/Pa
    enthalpy_by_pressure_2: float  # W/Pa
    enthalpy_by_temperature_1: float  # W/K
    enthalpy_by_temperature_2: float  # W/K


@kernel
def stream(
    air: Air, through: Flow, along: Flow, temperature_1: float, temperature_2: float, forward: bool
) -> Stream:
    """Return what the flows ``through`` an orifice and ``along`` a gap are of the air upstream.

    Both are those of air of the supply's temperature; ``forward`` says that side 1 is upstream.
    """
    upstream = temperature_1 if forward else temperature_2
    ratio = air.temperature / upstream
    root = math.sqrt(ratio)
    one, other = root * through.mass_flow, ratio * along.mass_flow
    by_pressure_1 = root * through.by_pressure_1 + ratio * along.by_pressure_1
    by_pressure_2 = root * through.by_pressure_2 + ratio * along.by_pressure_2
    by_temperature = -(0.5 * one + other) / upstream
    warmth = enthalpy_capacity(air) * upstream
    warmth_by_temperature = enthalpy_capacity(air) * (one + other) + warmth * by_temperature
    first, second = (1.0, 0.0) if forward else (0.0, 1.0)
    return Stream(
        one + other,
        by_pressure_1,
        by_pressure_2,
        first * by_temperature,
        second * by_temperature,
        warmth * (one + other),
        warmth * by_pressure_1,
        warmth * by_pressure_2,
        first * warmth_by_temperature,
        second * warmth_by_temperature,
    )


@kernel
def from_supply(
    plant: Plant, supply: float, inlet: Edge, pressure: float, temperature: float
) -> Stream:
    """Flow from a ``supply`` (Pa), side 1, into a chamber of ``pressure``, ``temperature`` (K)."""
    air = plant.air
    through, along = restrictions(plant, inlet, supply, pressure)
    return stream(air, through, along, air.temperature, temperature, supply >= pressure)


@kernel
def to_atmosphere(plant: Plant, outlet: Edge, pressure: float, temperature: float) -> Stream:
    """Flow from such a chamber, side 1, to the atmosphere."""
    ambient, warmth = plant.ambient_pressure, plant.heat.ambient_temperature
    through, along = restrictions(plant, outlet, pressure, ambient)
    return stream(plant.air, through, along, temperature, warmth, pressure >= ambient)


@kernel
def net_stream(
    plant: Plant, supply: float, inlet: Edge, outlet: Edge, pressure: float, temperature: float
) -> NetInflow:
    """Return what flows into a chamber: in from the ``supply`` (Pa), out to the atmosphere."""
    inward = from_supply(plant, supply, inlet, pressure, temperature)
    outward = to_atmosphere(plant, outlet, pressure, temperature)
    return NetInflow(
        inward.mass_flow - outward.mass_flow,
        inward.by_pressure_2 - outward.by_pressure_1,
        inward.by_temperature_2 - outward.by_temperature_1,
        0.0,
        0.0,
        inward.enthalpy_flow - outward.enthalpy_flow,
        inward.enthalpy_by_pressure_2 - outward.enthalpy_by_pressure_1,
        inward.enthalpy_by_temperature_2 - outward.enthalpy_by_temperature_1,
        0.0,
        0.0,
    )


@kernel
def stream_into_a(
    plant: Plant, supply: float, lands: Lands, pressure: float, temperature: float
) -> NetInflow:
    """Return what flows into chamber A: in through 1a, out through 5."""
    inlet = lands.opening if lands.forward else lands.closing
    outlet = lands.closing if lands.forward else lands.opening
    return net_stream(plant, supply, inlet, outlet, pressure, temperature)


@kernel
def stream_into_b(
    plant: Plant, supply: float, lands: Lands, pressure: float, temperature: float
) -> NetInflow:
    """Return what flows into chamber B: in through 1b, out through 3."""
    inlet = lands.closing if lands.forward else lands.opening
    outlet = lands.opening if lands.forward else lands.closing
    return net_stream(plant, supply, inlet, outlet, pressure, temperature)


@kernel
def leak_out(plant: Plant, area: float, pressure: float, temperature: float) -> Stream:
    """Flow from a chamber, side 1, to the atmosphere through a leak of ``area`` (m²)."""
    ambient, warmth = plant.ambient_pressure, plant.heat.ambient_temperature
    through = orifice(plant.air, area, pressure, ambient)
    return stream(plant.air, through, NO_FLOW, temperature, warmth, pressure >= ambient)


@kernel
def leak_across(plant: Plant, state: HeatedMotion | FullMotion) -> Stream:
    """Flow from chamber A, side 1, to chamber B past the piston."""
    one, other = state.pressure_a, state.pressure_b
    through = orifice(plant.air, plant.leak.across, one, other)
    warm = state.temperature_a, state.temperature_b
    return stream(plant.air, through, NO_FLOW, warm[0], warm[1], one >= other)


@kernel
def less_at_1(flow: NetInflow, out: Stream, across: Stream) -> NetInflow:
    """``flow`` into a chamber less two streams of which it is side 1, the second to the other."""
    return NetInflow(
        flow.mass_flow - out.mass_flow - across.mass_flow,
        flow.by_pressure - out.by_pressure_1 - across.by_pressure_1,
        flow.by_temperature - out.by_temperature_1 - across.by_temperature_1,
        -across.by_pressure_2,
        -across.by_temperature_2,
        flow.enthalpy_flow - out.enthalpy_flow - across.enthalpy_flow,
        flow.enthalpy_by_pressure - out.enthalpy_by_pressure_1 - across.enthalpy_by_pressure_1,
        flow.enthalpy_by_temperature
        - out.enthalpy_by_temperature_1
        - across.enthalpy_by_temperature_1,
        -across.enthalpy_by_pressure_2,
        -across.enthalpy_by_temperature_2,
    )


@kernel
def turned(across: Stream) -> Stream:
    """The same stream with its sides exchanged: what flows from 2 to 1."""
    return Stream(
        -across.mass_flow,
        -across.by_pressure_2,
        -across.by_pressure_1,
        -across.by_temperature_2,
        -across.by_temperature_1,
        -across.enthalpy_flow,
        -across.enthalpy_by_pressure_2,
        -across.enthalpy_by_pressure_1,
        -across.enthalpy_by_temperature_2,
        -across.enthalpy_by_temperature_1,
    )


@kernel
def heated_supply_flow(
    plant: Plant, supply: float, lands: Lands, state: HeatedMotion | FullMotion
) -> float:
    """Mass flow in kg/s that leaves the ``supply`` (Pa) through edges 1a and 1b."""
    edge_a = lands.opening if lands.forward else lands.closing
    edge_b = lands.closing if lands.forward else lands.opening
    a = from_supply(plant, supply, edge_a, state.pressure_a, state.temperature_a)
    b = from_supply(plant, supply, edge_b, state.pressure_b, state.temperature_b)
    return a.mass_flow + b.mass_flow
