"""Mass flow through the two kinds of opening a spool valve has: an orifice and a gap."""

import math

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air

# Above this pressure ratio the nozzle formula's slope grows without bound; the flow runs
# linearly to zero at equal pressures instead, as ISO 6358 simulations do.
LAMINAR_RATIO = 0.999


@kernel
def nozzle_function(air: Air, ratio: float) -> float:
    """Dimensionless flow of an ideal nozzle at ``ratio`` = downstream/upstream, eq. (6)."""
    index = air.isentropic_index
    if ratio < air.critical_ratio:
        return air.choked_function
    bounded = min(ratio, LAMINAR_RATIO)
    density_ratio = bounded ** (1.0 / index)
    flow = math.sqrt(
        2.0 * index / (index - 1.0) * (density_ratio * density_ratio - bounded * density_ratio)
    )
    if ratio > LAMINAR_RATIO:
        flow *= (1.0 - ratio) / (1.0 - LAMINAR_RATIO)
    return flow


@kernel
def orifice_flow(air: Air, area: float, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s from side 1 to side 2, eqs. (6), (7), (19), (20).

    ``area`` is C_v·S in m². With the higher pressure on side 2 the ports swap and the flow
    is negative; the paper's form has a negative radicand there.
    """
    if area == 0.0:
        return 0.0
    upstream = max(pressure_1, pressure_2)
    downstream = min(pressure_1, pressure_2)
    flow = (
        area
        * upstream
        / math.sqrt(air.gas_constant * air.temperature)
        * nozzle_function(air, downstream / upstream)
    )
    return flow if pressure_1 >= pressure_2 else -flow


@kernel
def gap_conductance(air: Air, perimeter: float, height: float, length: float) -> float:
    """Slit conductance in kg/(s·Pa²): π d_s h0³ / (24 μ L R T), from eqs. (8)-(14)."""
    return (
        perimeter * height**3 / (24.0 * air.viscosity * length * air.gas_constant * air.temperature)
    )


@kernel
def gap_flow(conductance: float, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s through a slit, gas density following the pressure along it."""
    return conductance * (pressure_1 * pressure_1 - pressure_2 * pressure_2)
