# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A nominal model of valve and chambers, and its inverse: from a force rate to a voltage.

The force of the piston is F = A·(p_a − p_b). With volumes V_a = V_0 + A·y, V_b = V_0 + A·(L − y)
and one polytropic exponent n,

    Ḟ = S·G(sign S) − n·A²·v·(p_a/V_a + p_b/V_b)

    G₊ = n·A·R·T·(g(p_s, p_a)/V_a + g(p_b, p_0)/V_b)        the valve opens forward
    G₋ = n·A·R·T·(g(p_a, p_0)/V_a + g(p_s, p_b)/V_b)        and backward

g is the mass flow through 1 m² from p to q: k·p·√(1 − ((q/p − b)/(1 − b))²), and k·p below the
critical ratio b (ISO 6358-1:2013, with the k of an ideal nozzle); p_0 is the standard atmosphere.
Near its closed position a spool valve's area grows with the square of the voltage x from closed,
and far away it levels off:

    S(x) = sign(x)·c·x²/(1 + (x/w)²)        x(S) = sign(S)·√(|S|/(c − |S|/w²))

Inverting needs no iteration. Bobrow and McDonell, "Modeling, identification, and control of a
pneumatically actuated, force controllable robot", *IEEE Transactions on Robotics and Automation*
14(5), 1998, 732-742.
"""

import math
from typing import NamedTuple

from rodless_base.constants import STANDARD_ATMOSPHERE, STROKE
from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_control.laws.parts.saturation import bounded_pressure, within

GAS_CONSTANT = 287.05  # J/(kg·K), of dry air
TEMPERATURE = 293.15  # K, ISO 8778
CRITICAL_RATIO = 0.528

# Mass flow through 1 m² of a choked ideal nozzle per Pa before it, κ = 1.4: kg/(s·m²·Pa).
CHOKED = math.sqrt(1.4 / (GAS_CONSTANT * TEMPERATURE)) * (2.0 / 2.4) ** 3

# Volts from closed at which a spool is at its end.
LARGEST_DEFLECTION = 5.0

# Below this pressure difference, as a share of the higher one, a jet is laminar. Without it the
# flow's slope were infinite, and the inverse would chatter.
LAMINAR = 1e-3


class Pneumatics(NamedTuple):
    """Constants of the nominal model."""

    piston_area: float  # m²
    stroke: float  # m
    dead_volume: float  # m³
    polytropic_index: float
    valve_curvature: float  # m²/V²
    valve_saturation: float  # V

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Pneumatics":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(
            piston_area=math.pi / 4.0 * parameters.number(f"{law}.bore") ** 2,
            stroke=parameters.number(f"{law}.stroke"),
            dead_volume=parameters.number(f"{law}.dead_volume"),
            polytropic_index=parameters.number(f"{law}.polytropic_index"),
            valve_curvature=parameters.number(f"{law}.valve_curvature"),
            valve_saturation=parameters.number(f"{law}.valve_saturation"),
        )


def declared(law: str) -> dict[str, Parameter]:
    """Return the model's parameters as those of ``law``."""
    return declare(
        Parameter(f"{law}.bore", 0.025, "m", "bore of the cylinder", "SMC CY3R25", 5e-3, 0.1),
        Parameter(f"{law}.stroke", STROKE, "m", "stroke", "SMC CY3R25-200", 0.01, 2.0),
        Parameter(
            f"{law}.dead_volume",
            18e-6,
            "m³",
            "volume of either chamber, tube and fittings at its end of the stroke",
            "judgement: middle of 10-30 cm³",
            2e-6,
            1e-2,
        ),
        Parameter(
            f"{law}.polytropic_index",
            1.3,
            "",
            "polytropic exponent n of the chambers",
            "judgement: nearly adiabatic",
            1.0,
            1.4,
        ),
        Parameter(
            f"{law}.valve_curvature",
            0.277e-6,
            "m²/V²",
            "effective area of the valve per squared voltage from closed",
            "Zhang et al. 2022, eqs. (5) and (25) from closed to 3 V, within 3 %",
            1e-9,
            1e-4,
        ),
        Parameter(
            f"{law}.valve_saturation",
            3.52,
            "V",
            "voltage from closed at which half the area is lost to the curve's levelling off",
            "Zhang et al. 2022, eqs. (5) and (25) from closed to 3 V, within 3 %",
            0.1,
            100.0,
        ),
    )


@kernel
def specific_flow(upstream: float, downstream: float) -> float:
    """Mass flow in kg/(s·m²) from one pressure (Pa) to another; against it, negative."""
    high, low = max(upstream, downstream), min(upstream, downstream)
    ratio = low / high
    share = 1.0
    if ratio > CRITICAL_RATIO:
        bounded = min(ratio, 1.0 - LAMINAR)
        share = math.sqrt(1.0 - ((bounded - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO)) ** 2)
        share *= (1.0 - ratio) / (1.0 - bounded)
    flow = CHOKED * high * share
    return flow if upstream >= downstream else -flow


@kernel
def force(model: Pneumatics, measurement: Measurement) -> float:
    """Force on the piston in N."""
    return model.piston_area * (
        bounded_pressure(measurement.pressure_a) - bounded_pressure(measurement.pressure_b)
    )


@kernel
def rate_per_area(
    model: Pneumatics, measurement: Measurement, position: float, forward: bool
) -> float:
    """G₊ or G₋ in N/(s·m²): how the force changes with the valve's opening."""
    a = bounded_pressure(measurement.pressure_a)
    b = bounded_pressure(measurement.pressure_b)
    supply = bounded_pressure(measurement.supply_pressure)
    if forward:
        into_a, into_b = specific_flow(supply, a), specific_flow(b, STANDARD_ATMOSPHERE)
    else:
        into_a, into_b = specific_flow(a, STANDARD_ATMOSPHERE), specific_flow(supply, b)
    heat = model.polytropic_index * model.piston_area * GAS_CONSTANT * TEMPERATURE
    return heat * (into_a / volume_a(model, position) + into_b / volume_b(model, position))


@kernel
def volume_a(model: Pneumatics, position: float) -> float:
    """Volume of chamber A in m³."""
    return model.dead_volume + model.piston_area * within(position, 0.0, model.stroke)


@kernel
def volume_b(model: Pneumatics, position: float) -> float:
    """Volume of chamber B in m³."""
    return volume_a(model, model.stroke - position)


@kernel
def motion_rate(
    model: Pneumatics, measurement: Measurement, position: float, velocity: float
) -> float:
    """Force rate in N/s that moving at ``velocity`` (m/s) makes, the valve closed."""
    stiffness = bounded_pressure(measurement.pressure_a) / volume_a(model, position)
    stiffness += bounded_pressure(measurement.pressure_b) / volume_b(model, position)
    return -model.polytropic_index * model.piston_area**2 * stiffness * velocity


@kernel
def opening(model: Pneumatics, deflection: float) -> float:
    """Effective area S in m² at ``deflection`` (V) from closed, negative backward."""
    square = deflection * deflection
    area = model.valve_curvature * square / (1.0 + square / model.valve_saturation**2)
    return math.copysign(area, deflection)


@kernel
def deflection(model: Pneumatics, area: float) -> float:
    """Voltage from closed at which the opening is ``area`` (m²), at most 5 V either way."""
    size = abs(area)
    left = model.valve_curvature - size / model.valve_saturation**2
    largest = LARGEST_DEFLECTION
    found = largest if left <= 0.0 else min(math.sqrt(size / left), largest)
    return math.copysign(found, area)


@kernel
def deflection_for(
    model: Pneumatics, measurement: Measurement, position: float, velocity: float, rate: float
) -> float:
    """Voltage from closed at which the force changes at ``rate`` (N/s); as far as there is air."""
    missing = rate - motion_rate(model, measurement, position, velocity)
    per_area = rate_per_area(model, measurement, position, missing >= 0.0)
    if per_area <= 0.0:
        # Neither supply nor atmosphere can give more: the valve opens as far as it goes.
        return math.copysign(LARGEST_DEFLECTION, missing)
    return deflection(model, missing / per_area)
