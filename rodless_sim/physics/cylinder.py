# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rodless cylinder (SMC CY3R25-200): piston, chamber volumes, pressure rates."""

import math
from typing import NamedTuple

from rodless_base.constants import STROKE
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.sources import JUDGEMENT, PAPER

PARAMETERS = declare(
    Parameter("cylinder.bore", 0.025, "m", "piston diameter", "SMC CY3R25", 5e-3, 0.1),
    Parameter("cylinder.stroke", STROKE, "m", "stroke", "SMC CY3R25-200", 0.01, 2.0),
    Parameter(
        "cylinder.moving_mass",
        1.0,
        "kg",
        "mass m of piston, carriage and bracket",
        f"{JUDGEMENT}: not in the paper",
        0.05,
        100.0,
    ),
    Parameter(
        "cylinder.dead_volume_a",
        15e-6,
        "m³",
        "volume V_a0 of chamber A, tube and fittings at position 0",
        f"{JUDGEMENT}: cavity 5, tube 7.5, fittings 1-2 cm³",
        2e-6,
        1e-2,
    ),
    Parameter(
        "cylinder.dead_volume_b",
        15e-6,
        "m³",
        "volume of chamber B, tube and fittings at full stroke",
        f"{JUDGEMENT}: as chamber A",
        2e-6,
        1e-2,
    ),
    Parameter(
        "cylinder.initial_position",
        0.0,
        "m",
        "position of the carriage at the start and after a reset",
        "chamber A's end",
        0.0,
        2.0,
    ),
    Parameter(
        "cylinder.locked",
        False,
        "",
        "hold the carriage where it is, as for the fixed-chamber experiment",
        f"{PAPER}, 6.1",
    ),
)


class Cylinder(NamedTuple):
    """Constants of the cylinder."""

    locked: bool  # holds the carriage where it is
    piston_area: float  # m²
    stroke: float  # m
    moving_mass: float  # kg
    dead_volume_a: float  # m³
    dead_volume_b: float  # m³

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Cylinder":
        """Return the constants for ``parameters``."""
        return cls(
            locked=bool(parameters["cylinder.locked"]),
            piston_area=piston_area(parameters),
            stroke=parameters.number("cylinder.stroke"),
            moving_mass=parameters.number("cylinder.moving_mass"),
            dead_volume_a=parameters.number("cylinder.dead_volume_a"),
            dead_volume_b=parameters.number("cylinder.dead_volume_b"),
        )


def check(parameters: ParameterSet) -> None:
    """Refuse a start beyond the stroke."""
    position = parameters.number("cylinder.initial_position")
    stroke = parameters.number("cylinder.stroke")
    if position > stroke:
        raise ParameterError(
            f"cylinder.initial_position: {position:g} m refused, beyond "
            f"cylinder.stroke ({stroke:g} m)"
        )


def piston_area(parameters: ParameterSet) -> float:
    """Area of the piston in m²: the same on both sides, there is no rod."""
    return math.pi / 4.0 * parameters.number("cylinder.bore") ** 2


@kernel
def volume_a(cylinder: Cylinder, position: float) -> float:
    """Volume of chamber A in m³, eq. (27); position 0 is at A's end."""
    return cylinder.dead_volume_a + cylinder.piston_area * position


@kernel
def volume_b(cylinder: Cylinder, position: float) -> float:
    """Volume of chamber B in m³, eq. (27)."""
    return cylinder.dead_volume_b + cylinder.piston_area * (cylinder.stroke - position)


@kernel
def pressure_rate(
    air: Air, volume: float, volume_rate: float, pressure: float, mass_flow: float
) -> float:
    """dP/dt of a chamber in Pa/s, eq. (26): inflow and outflow at supply temperature.

    Adiabatic as printed; with another exponent n for κ the chamber passes heat to its walls, and
    with n = 1 it keeps its temperature.
    """
    return (
        air.chamber_index
        / volume
        * (air.gas_constant * air.temperature * mass_flow - pressure * volume_rate)
    )


class PressureRate(NamedTuple):
    """dP/dt of a chamber, and how it changes with the carriage and with the pressures."""

    rate: float  # Pa/s
    by_position: float  # Pa/(s·m)
    by_velocity: float  # Pa/m
    by_pressure: float  # 1/s, with the chamber's own
    by_other: float  # 1/s, with the other chamber's


@kernel
def chamber_rate(
    air: Air,
    volume: float,
    area: float,
    velocity: float,
    pressure: float,
    mass_flow: float,
    flow_by_pressure: float,
    flow_by_other: float,
) -> PressureRate:
    """:func:`pressure_rate` with its derivatives.

    ``area`` (m²) is that by which the volume grows with the position: negative for chamber B.
    """
    stiffness = air.chamber_index / volume
    heat = air.gas_constant * air.temperature
    rate = pressure_rate(air, volume, area * velocity, pressure, mass_flow)
    return PressureRate(
        rate,
        -area / volume * rate,
        -stiffness * pressure * area,
        stiffness * (heat * flow_by_pressure - area * velocity),
        stiffness * (heat * flow_by_other),
    )
