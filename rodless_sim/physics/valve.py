# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The proportional valve (Festo MPYE-5-M5-010-B): what is measured of it, eqs. (5), (24), (25)."""

import math
import warnings
from decimal import Decimal
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT, PAPER

# Eq. (24) with the missing zero restored: x_v = 0.00021485 U - 0.00108499 (metres).
SPOOL_GAIN = 0.00021485
SPOOL_OFFSET = -0.00108499

# The flow-coefficient polynomial (25) was fitted up to this distance from the closed position.
COEFFICIENT_RANGE = 5.0

# What the area curve's largest amplitude may be, in m². No valve this size has a hundredth of that
# in mm², nor a hundred times as much in m²: in between lie the two decades that tell mm² from m².
LARGEST_AMPLITUDE = 1e-4
SMALLEST_IN_SQUARE_MILLIMETRES = 1e-2


def scaled_amplitudes(coefficients: tuple[float, ...], digits: int) -> tuple[float, ...]:
    """Return the nine coefficients with the amplitudes, every third, times ten to ``digits``.

    As decimal numbers: 2.108e-6 m² are 2.108 mm², to the last bit.
    """
    return tuple(
        value if place % 3 else float(Decimal(repr(value)).scaleb(digits))
        for place, value in enumerate(coefficients)
    )


def _in_square_metres(coefficients: tuple[float, ...]) -> tuple[float, ...]:
    """Return coefficients whose amplitudes may be in mm², as they once were, in m²."""
    largest = max(abs(value) for value in coefficients[::3])
    if largest <= LARGEST_AMPLITUDE:
        return coefficients
    if largest < SMALLEST_IN_SQUARE_MILLIMETRES:
        raise ParameterError(
            f"valve.area_coefficients: amplitude {largest:g} refused, must be at most "
            f"{LARGEST_AMPLITUDE:g} m²; values in mm² times 1e-6 are m²"
        )
    warnings.warn(
        f"valve.area_coefficients: amplitude {largest:g} can only be in mm²: taken as "
        f"{largest * 1e-6:g} m²; write the amplitudes times 1e-6, in m²",
        FutureWarning,
        stacklevel=2,
    )
    return scaled_amplitudes(coefficients, -6)


PARAMETERS = declare(
    Parameter(
        "valve.closed_voltage",
        CLOSED_VOLTAGE,
        "V",
        "command at which the valve is closed; also its fail-safe position",
        f"{PAPER}, 3.5",
        4.0,
        6.0,
    ),
    Parameter(
        "valve.curve_centre",
        5.2416,
        "V",
        "voltage of the smallest area on the measured curve, eq. (5)",
        f"{PAPER}, eq. (5)",
        4.0,
        6.5,
    ),
    Parameter(
        "valve.area_coefficients",
        (2.108e-6, 0.2636, 0.1742, 2.012e-6, 0.4851, 2.157, -0.0933e-6, 1.331, 0.9104),
        "m², rad/V, rad",
        "amplitude (1e-4 m² at most), frequency and phase of the three sines of eq. (5)",
        f"{PAPER}, eq. (5)",
        -100.0,
        100.0,
        from_former=_in_square_metres,
    ),
    Parameter(
        "valve.flow_coefficients",
        (1.132, -0.006917, -0.0339, 0.02509, -0.006486, 0.0004983),
        "1/V^k",
        "flow coefficient polynomial, constant term first",
        f"{PAPER}, eq. (25)",
        -10.0,
        10.0,
    ),
    Parameter(
        "valve.discharge",
        "polynomial",
        "",
        "flow coefficient C_v: polynomial: eq. (25), valve.flow_coefficients; constant: "
        "valve.discharge_coefficient at any opening",
        f"{PAPER}, eq. (25)",
        choices=("polynomial", "constant"),
    ),
    Parameter(
        "valve.discharge_coefficient",
        0.9,
        "",
        "flow coefficient C_v at any opening (constant)",
        f"{JUDGEMENT}: rated flow 100 L/min ± 10 %, within 3-5 % of the maker's curve",
        0.0,
        2.0,
    ),
    Parameter("valve.spool_diameter", 6e-3, "m", "spool diameter d_s", f"{PAPER}, 3.2", 1e-3, 0.05),
    Parameter(
        "valve.sleeve_diameter",
        6.023e-3,
        "m",
        "sleeve diameter d_h; gives the gap of the printed assembly by eq. (3)",
        f"{PAPER}, 3.2",
        1e-3,
        0.05,
    ),
    Parameter(
        "valve.gap_length", 2e-3, "m", "initial gap length L_0", f"{PAPER}, 3.3", 1.2e-3, 0.05
    ),
    Parameter(
        "valve.gap_height",
        6e-6,
        "m",
        "effective gap height h_0 of the reconciled assembly",
        f"{JUDGEMENT}: maker's leakage bound and eq. (5) near closed",
        0.0,
        5e-5,
    ),
)


class Valve(NamedTuple):
    """Constants of the valve."""

    closed_voltage: float  # V
    curve_centre: float  # V
    # Amplitude, frequency and phase of three sines: mm², rad/V, rad.
    area_coefficients: tuple[float, float, float, float, float, float, float, float, float]
    flow_coefficients: tuple[float, float, float, float, float, float]  # 1/V^k, from k = 0
    spool_diameter: float  # m
    sleeve_diameter: float  # m
    gap_length: float  # m
    gap_height: float  # m

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Valve":
        """Return the constants for ``parameters``."""
        area: Any = scaled_amplitudes(parameters.numbers("valve.area_coefficients"), 6)
        coefficient: Any = flow_polynomial(parameters)
        return cls(
            closed_voltage=parameters.number("valve.closed_voltage"),
            curve_centre=parameters.number("valve.curve_centre"),
            area_coefficients=area,
            flow_coefficients=coefficient,
            spool_diameter=parameters.number("valve.spool_diameter"),
            sleeve_diameter=parameters.number("valve.sleeve_diameter"),
            gap_length=parameters.number("valve.gap_length"),
            gap_height=parameters.number("valve.gap_height"),
        )


def flow_polynomial(parameters: ParameterSet) -> tuple[float, ...]:
    """Return the powers of C_v in use, from the constant term on: a constant has no others."""
    if parameters.text("valve.discharge") == "constant":
        return parameters.number("valve.discharge_coefficient"), 0.0, 0.0, 0.0, 0.0, 0.0
    return parameters.numbers("valve.flow_coefficients")


def check(parameters: ParameterSet) -> None:
    """Refuse a sleeve narrower than its spool, and an orifice that would flow backwards."""
    spool = parameters.number("valve.spool_diameter")
    sleeve = parameters.number("valve.sleeve_diameter")
    if sleeve < spool:
        raise ParameterError(
            f"valve.sleeve_diameter: {sleeve:g} m refused, smaller than "
            f"valve.spool_diameter ({spool:g} m)"
        )
    powers = parameters.numbers("valve.flow_coefficients")
    volts, lowest = lowest_coefficient(powers, COEFFICIENT_RANGE)
    if lowest < 0.0:
        raise ParameterError(
            f"valve.flow_coefficients: refused, the flow coefficient is {lowest:g} at "
            f"{volts:.2g} V from closed: air would flow against the pressure"
        )


@lru_cache(maxsize=64)
def lowest_coefficient(powers: tuple[float, ...], reach: float) -> tuple[float, float]:
    """Return where from 0 to ``reach`` the polynomial of ``powers`` is lowest, and its value."""
    curve = np.polynomial.Polynomial(powers)
    # In units of the reach, and without powers that add nothing there: divided by one of 1e-320,
    # the others would be infinite.
    slope = [k * power * reach ** (k - 1) for k, power in enumerate(powers)][1:]
    least = 1e-12 * max(map(abs, slope))
    roots = np.polynomial.Polynomial(np.polynomial.polynomial.polytrim(slope, least)).roots()
    turns = [reach * float(root.real) for root in roots if abs(root.imag) < 1e-9]
    places = [0.0, reach, *(t for t in turns if 0.0 < t < reach)]
    return min(((place, float(curve(place))) for place in places), key=lambda found: found[1])


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
def spool_displacement(voltage: float) -> float:
    """Spool displacement x_v in m, eq. (24); zero at 5.05 V."""
    return SPOOL_GAIN * voltage + SPOOL_OFFSET
