# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Inputs that are no larger than any rig needs, commands within their limits, and no windup.

    limited(v) = min(max(v, minimum), maximum)

An integral I that feeds a command v holds while v is beyond a limit and I pushes it further out
(conditional integration): Åström and Hägglund, *PID Controllers*, 1995, section 3.5. An integral
that works in a zone of errors only must unwind outside of it: one that was wound up while the air
was off would otherwise hold the carriage outside the zone for good.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet

# No cylinder is longer (m), and none is faster (m/s).
LARGEST = 1e3

# No rig has more pressure (Pa).
LARGEST_PRESSURE = 1e8


class Limits(NamedTuple):
    """The command at rest and the limits of the command."""

    neutral: float  # V
    minimum: float  # V
    maximum: float  # V

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Limits":
        """Return the constants for ``parameters``."""
        return cls(
            parameters.number("controller.neutral_voltage"),
            parameters.number("controller.minimum_voltage"),
            parameters.number("controller.maximum_voltage"),
        )


@kernel
def within(value: float, low: float, high: float) -> float:
    """``value``, or the limit it is beyond."""
    return min(max(value, low), high)


@kernel
def bounded(length: float) -> float:
    """``length`` (m) or velocity (m/s), no larger than any rig needs."""
    return within(length, -LARGEST, LARGEST)


@kernel
def bounded_pressure(pressure: float) -> float:
    """``pressure`` (Pa), above vacuum and no larger than any rig needs."""
    return within(pressure, 1.0, LARGEST_PRESSURE)


@kernel
def held_at_limit(integral: float, grown: float, excess: float) -> float:
    """``grown``, or ``integral`` where growing drives the command further past a limit.

    ``excess`` is how far the command is beyond the limit, with its sign.
    """
    return integral if excess * (grown - integral) > 0.0 else grown


@kernel
def unwound(integral: float, gain: float, zone: float, error: float, interval: float) -> float:
    """``integral`` after ``interval`` s beyond its ``zone`` (m): nearer to 0, and never past it.

    Where it pushes away from the target it goes at the pace of the zone's edge, ``gain``·``zone``:
    not at all where either is 0.
    """
    change = gain * math.copysign(zone, error) * interval
    if integral * change >= 0.0:
        return integral
    moved = integral + change
    return moved if moved * integral > 0.0 else 0.0
