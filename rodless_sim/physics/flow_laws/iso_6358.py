# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ISO 6358-1: flow by sonic conductance C, critical back-pressure ratio b and subsonic index m.

    ṁ = C P₁ ρ₀ √(T₀/T₁) φ(r)        φ = 1                               r ≤ b
                                     φ = [1 − ((r − b)/(1 − b))²]^m      r > b

C, b and m are what a valve's data sheet states, at its widest opening. At other openings C is in
proportion to C_v·S; b and m stay.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.kernels import outlined_kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.air import Air
from rodless_sim.physics.flow import LAMINAR_RATIO
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.valve import Valve
from rodless_sim.physics.valve_assembly import ASSEMBLIES, Assembly

# The reference atmosphere of ISO 8778 that C refers to: 100 kPa, 20 °C, 65 % humidity.
REFERENCE_DENSITY = 1.185  # kg/m³
REFERENCE_TEMPERATURE = 293.15  # K

# So many intervals of the command's range are searched for the widest opening.
INTERVALS = 100

NAME = "iso_6358"
MEANING = "that of ISO 6358-1"
PARAMETERS = declare(
    Parameter(
        "valve.sonic_conductance",
        3.9e-9,
        "m³/(s·Pa)",
        "sonic conductance C of one path at the widest opening (iso_6358)",
        "Festo MPYE-5-M5: 100 L/min ± 10 % from 6 to 5 bar gauge",
        1e-11,
        1e-7,
    ),
    Parameter(
        "valve.critical_ratio",
        0.35,
        "",
        "critical back-pressure ratio b (iso_6358)",
        "ISO 6358-1; judgement: spool valves of this size have 0.2 to 0.45",
        0.0,
        0.9,
    ),
    Parameter(
        "valve.subsonic_index", 0.5, "", "subsonic index m (iso_6358)", "ISO 6358-1", 0.3, 1.0
    ),
)


class Iso6358(NamedTuple):
    """Constants of the law."""

    choked_function: float  # -, ψ of a choked orifice
    critical_ratio: float  # -
    subsonic_index: float  # -


def of(parameters: ParameterSet) -> Iso6358:
    """Return the constants for ``parameters``; without a scale where another law is in use."""
    choked = 0.0
    if parameters.text("valve.flow_law") == NAME:
        per_pascal = parameters.number("valve.sonic_conductance") * REFERENCE_DENSITY
        speed = math.sqrt(parameters.number("air.gas_constant") * REFERENCE_TEMPERATURE)
        choked = per_pascal * speed / widest_opening_of(parameters)
    return Iso6358(
        choked,
        parameters.number("valve.critical_ratio"),
        parameters.number("valve.subsonic_index"),
    )


def check(parameters: ParameterSet) -> None:
    """Refuse a valve that opens nowhere: C would have no opening to belong to."""
    if parameters.text("valve.flow_law") != NAME:
        return
    widest = widest_opening_of(parameters)
    if not 0.0 < widest < math.inf:
        raise ParameterError(
            f"valve.flow_law: {NAME} refused, the widest orifice of the valve is {widest:g} m² and "
            "valve.sonic_conductance has none to belong to; check valve.area_coefficients"
        )


def widest_opening_of(parameters: ParameterSet) -> float:
    """:func:`widest_opening` of the valve of ``parameters``."""
    air, valve = Air.of(parameters), Valve.of(parameters)
    return widest_opening(air, valve, Assembly.of(parameters, air, valve))


@lru_cache(maxsize=64)
def widest_opening(air: Air, valve: Valve, assembly: Assembly) -> float:
    """Return the largest C_v·S of an orifice over the range of the command, m²."""
    # Uncompiled: a few hundred numbers are sooner computed than compiled for.
    chosen = ASSEMBLIES[assembly.code]
    lands: Callable[..., Lands] = getattr(chosen.lands, "py_func", chosen.lands)
    own = assembly.own[assembly.code]
    span = MAXIMUM_VOLTAGE - MINIMUM_VOLTAGE
    voltages = (MINIMUM_VOLTAGE + span * k / INTERVALS for k in range(INTERVALS + 1))
    found = [lands(own, air, valve, voltage) for voltage in voltages]
    return max(max(each.opening.orifice_area, each.closing.orifice_area) for each in found)


@outlined_kernel
def function(constants: Iso6358, air: Air, ratio: float) -> tuple[float, float]:  # noqa: ARG001
    """Dimensionless flow ψ at ``ratio``, and dψ/dr.

    With x = (r − b)/(1 − b): ψ′ = −2 m x ψ/((1 − b)(1 − x²)). Straight to zero from 0.999 on, as
    the nozzle's.
    """
    choked, critical = constants.choked_function, constants.critical_ratio
    if ratio <= critical:
        return choked, 0.0
    share = (min(ratio, LAMINAR_RATIO) - critical) / (1.0 - critical)
    left = 1.0 - share * share
    flow = choked * left**constants.subsonic_index
    if ratio > LAMINAR_RATIO:
        slope = -flow / (1.0 - LAMINAR_RATIO)
        return slope * (ratio - 1.0), slope
    return flow, -2.0 * constants.subsonic_index * share * flow / ((1.0 - critical) * left)
