# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Eqs. (1)-(25) as printed: orifice on one edge, gap on the other, joined at closed."""

import math
from functools import lru_cache

import numpy as np

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterError, ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import Flow, gap_conductance
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.valve import (
    Valve,
    effective_area,
    lowest_coefficient,
    spool_displacement,
)

NAME = "printed"
MEANING = "printed as in the paper"
PARAMETERS = declare()


def of(parameters: ParameterSet) -> tuple[()]:  # noqa: ARG001
    """Return no constants: those of the valve are all there is to it."""
    return ()


def check(parameters: ParameterSet) -> None:
    """Refuse measured curves by which air would flow against the pressure.

    Only where this assembly is in use: the reconciled one counts the area from its smallest.
    """
    if parameters.text("valve.assembly") != NAME:
        return
    volts, lowest = lowest_area(parameters.numbers("valve.area_coefficients"))
    if lowest < 0.0:
        raise ParameterError(
            f"valve.area_coefficients: refused with valve.assembly {NAME}, the area is "
            f"{1e6 * lowest:.3g} mm² at {volts:.3g} V: air would flow against the pressure"
        )
    # Both branches of flow_coefficient_printed are this polynomial in the spool's distance.
    powers = parameters.numbers("valve.flow_coefficients")
    signs = (1.0, -1.0) * 3
    reach = max(abs(spool_displacement(MINIMUM_VOLTAGE)), abs(spool_displacement(MAXIMUM_VOLTAGE)))
    distance, lowest = lowest_coefficient(
        tuple(sign * power for sign, power in zip(signs, powers, strict=True)), reach
    )
    if lowest < 0.0:
        raise ParameterError(
            f"valve.flow_coefficients: refused with valve.assembly {NAME}, the flow coefficient "
            f"is {lowest:.3g} with the spool {distance:.3g} m off: air would flow against the "
            "pressure"
        )


@lru_cache(maxsize=64)
def lowest_area(coefficients: tuple[float, ...]) -> tuple[float, float]:
    """Return where (V) within the valve's range the area of eq. (5) is lowest, and it (m²)."""
    amplitude, rate, phase = np.reshape(coefficients, (3, 3)).T
    fastest = float(np.abs(rate).max())
    # Some 60 places in each wave, then as many between the neighbours of the lowest.
    count = 200 + int(10.0 * fastest * (MAXIMUM_VOLTAGE - MINIMUM_VOLTAGE))
    places = np.linspace(MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE, count)
    for _ in range(3):
        areas = np.sin(np.multiply.outer(places, rate) + phase) @ amplitude
        lowest = int(np.argmin(areas))
        found = float(places[lowest]), float(areas[lowest])
        places = np.linspace(
            places[max(lowest - 1, 0)], places[min(lowest + 1, len(places) - 1)], 65
        )
    return found


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
    """Flow of eqs. (15), (16), (21), (22) as printed, with the density of side 2 either way."""
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
    """Flow through the gap of an edge, its density that of side 2 whichever way it flows."""
    return gap_printed(edge.gap, pressure_1, pressure_2)
