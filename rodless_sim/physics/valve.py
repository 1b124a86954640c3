"""The proportional valve (Festo MPYE-5-M5-010-B): from voltage to the openings of its lands."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import gap_conductance

# Eq. (24) with the missing zero restored: x_v = 0.00021485 U - 0.00108499 (metres).
SPOOL_GAIN = 0.00021485
SPOOL_OFFSET = -0.00108499

# The flow-coefficient polynomial (25) was fitted up to this distance from the closed position.
COEFFICIENT_RANGE = 5.0


# Command range of the MPYE-5-...-010-B (Festo data sheet); the valve saturates beyond it.
MINIMUM_VOLTAGE = 0.0
MAXIMUM_VOLTAGE = 10.0


class Valve(NamedTuple):
    """Constants of the valve, SI; ``printed`` selects the paper's own assembly of its equations."""

    printed: bool
    closed_voltage: float
    curve_centre: float
    area_coefficients: tuple[float, float, float, float, float, float, float, float, float]
    flow_coefficients: tuple[float, float, float, float, float, float]
    spool_diameter: float
    sleeve_diameter: float
    gap_length: float
    gap_height: float
    gap_fade_voltage: float


class Edge(NamedTuple):
    """One land edge: C_v·S of its orifice in m², conductance of its gap in kg/(s·Pa²)."""

    orifice_area: float
    gap: float


class Lands(NamedTuple):
    """The edges at one spool position: one pair opens, the other closes."""

    printed: bool
    forward: bool
    opening: Edge
    closing: Edge


@kernel
def effective_area(valve: Valve, voltage: float) -> float:
    """Effective area S in m² of the measured curve, eq. (5): three sines, fitted in mm²."""
    c = valve.area_coefficients
    return 1e-6 * (
        c[0] * math.sin(c[1] * voltage + c[2])
        + c[3] * math.sin(c[4] * voltage + c[5])
        + c[6] * math.sin(c[7] * voltage + c[8])
    )


@kernel
def centred_area(valve: Valve, deflection: float) -> float:
    """Effective area in m² at ``deflection`` volts from closed, eq. (5) re-centred."""
    closed = effective_area(valve, valve.curve_centre)
    return max(effective_area(valve, valve.curve_centre + deflection) - closed, 0.0)


@kernel
def flow_coefficient(valve: Valve, deflection: float) -> float:
    """Flow coefficient C_v, eq. (25) with its argument in volts from the closed position."""
    c = min(abs(deflection), COEFFICIENT_RANGE)
    k = valve.flow_coefficients
    return k[0] + c * (k[1] + c * (k[2] + c * (k[3] + c * (k[4] + c * k[5]))))


@kernel
def flow_coefficient_printed(valve: Valve, spool_displacement: float) -> float:
    """Flow coefficient C_v, eq. (25) letter by letter: its argument in metres, branches as printed.

    Over the spool's ±1 mm this stays within 10 ppm of its constant term.
    """
    x = spool_displacement
    k = valve.flow_coefficients
    even = k[0] + k[2] * x**2 + k[4] * x**4
    odd = k[1] * x + k[3] * x**3 + k[5] * x**5
    return even + odd if x <= 0.0 else even - odd


@kernel
def spool_displacement(voltage: float) -> float:
    """Spool displacement x_v in m, eq. (24); zero at 5.05 V."""
    return SPOOL_GAIN * voltage + SPOOL_OFFSET


@kernel
def lands(air: Air, valve: Valve, voltage: float) -> Lands:
    """Openings of the four land edges at ``voltage`` (V) by the selected assembly."""
    if valve.printed:
        return lands_printed(air, valve, voltage)
    return lands_reconciled(air, valve, voltage)


@kernel
def lands_reconciled(air: Air, valve: Valve, voltage: float) -> Lands:
    """Every port has two edges, continuous through the closed position.

    The opening edge passes the orifice flow and, fading out as the land clears, its gap; the
    closing edge passes the gap, which lengthens with the spool's travel from closed. The fade is
    flat at the closed position: the orifice opens with the square of the deflection, and a gap
    that faded linearly there would close the edge first and push a held piston backwards.
    """
    deflection = voltage - valve.closed_voltage
    perimeter = math.pi * valve.spool_diameter
    overlap = valve.gap_length + abs(SPOOL_GAIN * deflection)
    area = flow_coefficient(valve, deflection) * centred_area(valve, deflection)
    fade = math.exp(-((deflection / valve.gap_fade_voltage) ** 2))
    opening_gap = fade * gap_conductance(air, perimeter, valve.gap_height, valve.gap_length)
    closing_gap = gap_conductance(air, perimeter, valve.gap_height, overlap)
    return Lands(False, deflection >= 0.0, Edge(area, opening_gap), Edge(0.0, closing_gap))


@kernel
def lands_printed(air: Air, valve: Valve, voltage: float) -> Lands:
    """Eqs. (1)-(25) as printed: orifice on one edge, gap on the other, joined at closed."""
    forward = voltage >= valve.closed_voltage
    displacement = spool_displacement(voltage)
    overlap = valve.gap_length + (displacement if forward else -displacement)
    height = 0.5 * (valve.sleeve_diameter - valve.spool_diameter)  # eq. (3)
    area = flow_coefficient_printed(valve, displacement) * effective_area(valve, voltage)
    gap = gap_conductance(air, math.pi * valve.spool_diameter, height, overlap)
    return Lands(True, forward, Edge(area, 0.0), Edge(0.0, gap))
