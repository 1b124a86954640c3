# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The supply's pressure at the valve, where the paper takes it to be constant.

A ripple is known in time: P_s + a sin(2π f t), t since the start or the last reset.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel_by_type, version_for
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sagging_supply import COMPRESSOR
from rodless_sim.physics.sources import JUDGEMENT

PARAMETERS = declare(
    Parameter(
        "supply.ripple_amplitude",
        0.0,
        "Pa",
        "amplitude of a sinusoidal ripple of the supply pressure at the valve; 0 for none",
        f"{JUDGEMENT}: some kPa behind a piston compressor with a small receiver",
        0.0,
        2e5,
    ),
    Parameter(
        "supply.ripple_frequency",
        10.0,
        "Hz",
        "frequency of this ripple",
        f"{JUDGEMENT}: of a piston compressor",
        1e-3,
        100.0,
    ),
)


class Ripple(NamedTuple):
    """Constants of a ripple."""

    amplitude: float  # Pa
    angular_frequency: float  # rad/s


def of(parameters: ParameterSet, kept: bool) -> Ripple | tuple[()]:
    """Return the constants for ``parameters``; none where the supply is steady, unless ``kept``."""
    amplitude = parameters.number("supply.ripple_amplitude")
    if amplitude == 0.0 and not kept:
        return ()
    return Ripple(amplitude, 2.0 * math.pi * parameters.number("supply.ripple_frequency"))


def check(parameters: ParameterSet) -> None:
    """Refuse a ripple that takes the supply below the atmosphere."""
    compressor = parameters.text("supply.kind") == COMPRESSOR
    lowest = "supply.switch_on_pressure" if compressor else "supply.pressure"
    supply, ambient = parameters.number(lowest), parameters.number("atmosphere.pressure")
    amplitude = parameters.number("supply.ripple_amplitude")
    if amplitude > 0.0 and supply - amplitude < ambient:
        raise ParameterError(
            f"supply.ripple_amplitude: {amplitude:g} Pa refused, {lowest} ({supply:g} Pa) "
            f"would fall below atmosphere.pressure ({ambient:g} Pa)"
        )


@kernel_by_type
def rippled(ripple: tuple[()], pressure: float, time: float) -> float:  # noqa: ARG001
    """Return a supply pressure (Pa) with its ripple at ``time`` (s)."""
    return pressure


@version_for(Ripple, rippled)
def _rippled(ripple: Ripple, pressure: float, time: float) -> float:
    return pressure + ripple.amplitude * math.sin(ripple.angular_frequency * time)


@kernel_by_type
def longest_step(ripple: tuple[()]) -> float:  # noqa: ARG001
    """Return the longest step in s that sees a ripple."""
    return math.inf


@version_for(Ripple, longest_step)
def _longest_step(ripple: Ripple) -> float:
    return 1.0 / ripple.angular_frequency if ripple.amplitude > 0.0 else math.inf
