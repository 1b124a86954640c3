# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Crossing the valve's flat centre.

Near its closed position the valve passes next to nothing. A voltage in the direction of the effort
w is added, smoothly, so that noise about w = 0 does not make the spool chatter:

    u = w + voltage·tanh(w / width)

After Tao and Kokotović, *Adaptive Control of Systems with Actuator and Sensor Nonlinearities*,
1996, chapter 2: a dead zone's smooth inverse.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare


class DeadZone(NamedTuple):
    """Constants of the crossing."""

    voltage: float  # V
    width: float  # V

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "DeadZone":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(
            parameters.number(f"{law}.dead_zone_voltage"),
            parameters.number(f"{law}.dead_zone_width"),
        )


def declared(law: str, voltage: float, width: float, source: str) -> dict[str, Parameter]:
    """Return the part's parameters as those of ``law``."""
    return declare(
        Parameter(
            f"{law}.dead_zone_voltage",
            voltage,
            "V",
            "voltage added in the direction of the command to cross the valve's flat centre",
            source,
            0.0,
            2.0,
        ),
        Parameter(
            f"{law}.dead_zone_width",
            width,
            "V",
            "command at which three quarters of the dead-zone voltage is added",
            source,
            1e-4,
            5.0,
        ),
    )


@kernel
def crossing(voltage: float, width: float, effort: float) -> float:
    """Voltage (V) to add to ``effort`` (V)."""
    return voltage * math.tanh(effort / width)
