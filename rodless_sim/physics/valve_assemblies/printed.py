"""Eqs. (1)-(25) as printed: orifice on one edge, gap on the other, joined at closed."""

import math

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow, gap_conductance
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.valve import Valve, effective_area, spool_displacement

NAME = "printed"
MEANING = "printed as in the paper"
PARAMETERS = declare()


def of(parameters: ParameterSet) -> tuple[()]:  # noqa: ARG001
    """Return no constants: those of the valve are all there is to it."""
    return ()


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
def gap_printed(conductance: float, pressure_1: float, pressure_2: float) -> Flow:
    """Flow of eqs. (15), (16), (21), (22) as printed: density of side 2."""
    double = 2.0 * conductance
    return Flow(
        double * pressure_2 * (pressure_1 - pressure_2),
        double * pressure_2,
        double * (pressure_1 - 2.0 * pressure_2),
    )


@kernel
def gap_flow_printed(conductance: float, pressure_1: float, pressure_2: float) -> float:
    """Mass flow in kg/s of :func:`gap_printed`."""
    return gap_printed(conductance, pressure_1, pressure_2).mass_flow


@kernel
def lands(constants: tuple[()], air: Air, valve: Valve, voltage: float) -> Lands:  # noqa: ARG001
    """Openings at ``voltage`` (V)."""
    forward = voltage >= valve.closed_voltage
    displacement = spool_displacement(voltage)
    overlap = valve.gap_length + (displacement if forward else -displacement)
    height = 0.5 * (valve.sleeve_diameter - valve.spool_diameter)  # eq. (3)
    area = flow_coefficient_printed(valve, displacement) * effective_area(valve, voltage)
    gap = gap_conductance(air, math.pi * valve.spool_diameter, height, overlap)
    return Lands(forward, Edge(area, 0.0), Edge(0.0, gap))


@kernel
def gap(
    constants: tuple[()],  # noqa: ARG001
    air: Air,  # noqa: ARG001
    edge: Edge,
    pressure_1: float,
    pressure_2: float,
) -> Flow:
    """Flow through the gap of an edge, its density that of side 2."""
    return gap_printed(edge.gap, pressure_1, pressure_2)
