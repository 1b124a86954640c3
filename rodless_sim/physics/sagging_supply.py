# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A supply that sags: under the flow that is drawn, and between two pressures of a compressor.

A regulator and its line give way to the flow q, and take their time:

    τ dP_s/dt = P_set − k q − P_s

Behind a compressor without a regulator P_set is the pressure P_r of its receiver, which it keeps
between two pressures, its air at the supply's temperature:

    dP_r/dt = R T_s/V_r (q_c − q)            q_c: its delivery while it runs, else 0

Flows that users state are of air as the atmosphere has it, dry; the constants here have their mass.
"""

from typing import NamedTuple

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

COMPRESSOR = "compressor"

PARAMETERS = declare(
    Parameter(
        "supply.droop",
        0.0,
        "Pa·s/m³",
        "by how much the supply pressure at the valve sinks for the flow drawn, in m³/s of free "
        "air; 0 for a supply that does not sink",
        f"{JUDGEMENT}: 1.2e7, which is 20 kPa for 100 L/min",
        0.0,
        1e9,
    ),
    Parameter(
        "supply.time_constant",
        0.05,
        "s",
        "time constant with which the supply pressure at the valve follows (supply.droop)",
        JUDGEMENT,
        1e-3,
        10.0,
    ),
    Parameter(
        "supply.kind",
        "regulated",
        "",
        "where the air comes from: regulated: supply.pressure; compressor: its receiver, which "
        "begins at supply.pressure",
        "docs/options/compressor.md",
        choices=("regulated", COMPRESSOR),
        fixed=True,
    ),
    Parameter(
        "supply.receiver_volume",
        0.024,
        "m³",
        f"volume of the receiver ({COMPRESSOR})",
        f"{JUDGEMENT}: a workshop compressor of 24 L",
        1e-4,
        10.0,
    ),
    Parameter(
        "supply.switch_on_pressure",
        0.6e6,
        "Pa",
        f"pressure of the receiver at which the compressor switches on, absolute ({COMPRESSOR})",
        JUDGEMENT,
        5e4,
        1.2e6,
    ),
    Parameter(
        "supply.switch_off_pressure",
        0.7e6,
        "Pa",
        f"pressure of the receiver at which it switches off, absolute ({COMPRESSOR})",
        JUDGEMENT,
        5e4,
        1.3e6,
    ),
    Parameter(
        "supply.delivery",
        0.001667,
        "m³/s",
        f"what the compressor delivers while it runs, free air ({COMPRESSOR})",
        f"{JUDGEMENT}: 100 L/min",
        1e-6,
        1.0,
    ),
)


class Supply(NamedTuple):
    """Constants of a supply that sags."""

    acting: bool  # whether it does at all
    sags: bool  # whether it sinks with the flow drawn
    compressor: bool  # whether a receiver feeds it
    droop: float  # Pa·s/kg
    time_constant: float  # s
    receiver_stiffness: float  # Pa/kg
    switch_on: float  # Pa
    switch_off: float  # Pa
    delivery: float  # kg/s
    initial_pressure: float  # Pa, of the receiver, which no fault of its line lowers
    set_pressure: float  # Pa, the plant's without ripple
    loss: float  # share of the gauge pressure that a fault takes

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Supply":
        """Return the constants for ``parameters``."""
        number = parameters.number
        compressor = parameters.text("supply.kind") == COMPRESSOR
        sags = number("supply.droop") > 0.0
        gas = number("air.gas_constant")
        density = number("atmosphere.pressure") / (gas * number("atmosphere.temperature"))
        warm = gas * number("supply.temperature")
        return cls(
            acting=sags or compressor,
            sags=sags,
            compressor=compressor,
            droop=number("supply.droop") / density,
            time_constant=number("supply.time_constant"),
            receiver_stiffness=warm / number("supply.receiver_volume"),
            switch_on=number("supply.switch_on_pressure"),
            switch_off=number("supply.switch_off_pressure"),
            delivery=number("supply.delivery") * density,
            initial_pressure=number("supply.pressure"),
            set_pressure=number("supply.pressure"),
            loss=0.0,
        )


def check(parameters: ParameterSet) -> None:
    """Refuse a compressor whose pressures no receiver can keep."""
    if parameters.text("supply.kind") != COMPRESSOR:
        return
    number = parameters.number
    on, off = number("supply.switch_on_pressure"), number("supply.switch_off_pressure")
    if not on < off:
        raise ParameterError(
            f"supply.switch_on_pressure: {on:g} Pa refused, not below supply.switch_off_pressure "
            f"({off:g} Pa)"
        )
    if on < number("atmosphere.pressure"):
        raise ParameterError(
            f"supply.switch_on_pressure: {on:g} Pa refused, it is absolute and must not be below "
            f"atmosphere.pressure ({number('atmosphere.pressure'):g} Pa)"
        )
    start = number("supply.pressure")
    if not on <= start <= off:
        raise ParameterError(
            f"supply.pressure: {start:g} Pa refused, the receiver begins there: it must be "
            f"from supply.switch_on_pressure ({on:g} Pa) to supply.switch_off_pressure "
            f"({off:g} Pa)"
        )
