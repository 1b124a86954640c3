# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Mass flow through the two kinds of opening a spool valve has: an orifice and a gap."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air

# Above this pressure ratio the nozzle formula's slope grows without bound; the flow runs
# linearly to zero at equal pressures instead, as ISO 6358 simulations do.
LAMINAR_RATIO = 0.999


class Flow(NamedTuple):
    """A mass flow from side 1 to side 2, and how it changes with the pressure on either side."""

    mass_flow: float  # kg/s
    by_pressure_1: float  # kg/(s·Pa)
    by_pressure_2: float  # kg/(s·Pa)


@kernel
def both(one: Flow, other: Flow) -> Flow:
    """Two flows side by side."""
    return Flow(
        one.mass_flow + other.mass_flow,
        one.by_pressure_1 + other.by_pressure_1,
        one.by_pressure_2 + other.by_pressure_2,
    )


@kernel
def nozzle(air: Air, ratio: float) -> tuple[float, float]:
    """Dimensionless flow ψ of an ideal nozzle at ``ratio`` = downstream/upstream, and dψ/dr.

    Eq. (6): ψ² = 2κ/(κ−1)·(q² − r q) with q = r^(1/κ), therefore
    ψ′ = (2q²/r − (κ+1) q)/((κ−1) ψ).
    """
    index = air.isentropic_index
    if ratio < air.critical_ratio:
        return air.choked_function, 0.0
    bounded = min(ratio, LAMINAR_RATIO)
    density_ratio = bounded ** (1.0 / index)
    flow = math.sqrt(
        2.0 * index / (index - 1.0) * (density_ratio * density_ratio - bounded * density_ratio)
    )
    if ratio > LAMINAR_RATIO:
        slope = -flow / (1.0 - LAMINAR_RATIO)
        return slope * (ratio - 1.0), slope
    change = 2.0 * density_ratio * density_ratio / ratio - (index + 1.0) * density_ratio
    return flow, change / ((index - 1.0) * flow)


@kernel
def nozzle_function(air: Air, ratio: float) -> float:
    """Dimensionless flow of an ideal nozzle at ``ratio`` = downstream/upstream, eq. (6)."""
    return nozzle(air, ratio)[0]


@kernel
def orifice(air: Air, area: float, pressure_1: float, pressure_2: float) -> Flow:
    """Flow from side 1 to side 2 by the nozzle of eqs. (6), (7), (19), (20).

    ``area`` is C_v·S in m².
    """
    if area == 0.0:
        return Flow(0.0, 0.0, 0.0)
    function, slope = nozzle(air, pressure_ratio(pressure_1, pressure_2))
    return throttled(air, area, pressure_1, pressure_2, function, slope)


@kernel
def pressure_ratio(pressure_1: float, pressure_2: float) -> float:
    """Ratio of the downstream to the upstream pressure, at most 1."""
    return min(pressure_1, pressure_2) / max(pressure_1, pressure_2)


@kernel
def throttled(
    air: Air, area: float, pressure_1: float, pressure_2: float, function: float, slope: float
) -> Flow:
    """Flow from side 1 to side 2, eq. (7), where the dimensionless flow ψ is ``function``.

    ``slope`` is dψ/dr at the pressure ratio r. With the higher pressure on side 2 the ports swap
    and the flow is negative; the paper's form has a negative radicand there.
    """
    upstream = max(pressure_1, pressure_2)
    ratio = pressure_ratio(pressure_1, pressure_2)
    conductance = area / math.sqrt(air.gas_constant * air.temperature)
    flow = conductance * upstream * function
    by_upstream = conductance * (function - ratio * slope)
    by_downstream = conductance * slope
    if pressure_1 >= pressure_2:
        return Flow(flow, by_upstream, by_downstream)
    return Flow(-flow, -by_downstream, -by_upstream)


@kernel
def orifice_flow(air: Air, area: float, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s of an :func:`orifice`."""
    return orifice(air, area, pressure_1, pressure_2).mass_flow


@kernel
def gap_conductance(air: Air, perimeter: float, height: float, length: float) -> float:
    """Slit conductance in kg/(s·Pa²): π d_s h0³ / (24 μ L R T), from eqs. (8)-(14)."""
    return (
        perimeter * height**3 / (24.0 * air.viscosity * length * air.gas_constant * air.temperature)
    )


@kernel
def gap(conductance: float, pressure_1: float, pressure_2: float) -> Flow:
    """Flow through a slit, gas density following the pressure along it."""
    return Flow(
        conductance * (pressure_1 * pressure_1 - pressure_2 * pressure_2),
        2.0 * conductance * pressure_1,
        -2.0 * conductance * pressure_2,
    )


@kernel
def gap_flow(conductance: float, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s of a :func:`gap`."""
    return gap(conductance, pressure_1, pressure_2).mass_flow
