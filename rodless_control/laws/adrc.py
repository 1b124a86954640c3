# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Linear active disturbance rejection control.

The carriage is taken for ÿ = f + b·w with a disturbance f that holds everything unknown: friction,
load, the air's spring. The extended state observer is the fading-memory filter of ``parts`` told of
b·w, w being the effort that the valve was given since the sample before. Its third state is f̂, and

    w = (ω²·e + 2·ω·ė + r̈ − f̂)/b
    voltage = neutral + w + crossing(w)      within the limits

puts both poles of the error at −ω. The observer is told what the limits leave of w, so that nothing
winds up; there is no integral, f̂ does its work. Parking, bumpless gains and the dead zone are the
shared parts.

Han, "From PID to active disturbance rejection control", *IEEE Transactions on Industrial
Electronics* 56(3), 2009, 900-906; Gao, "Scaling and bandwidth-parameterization based controller
tuning", *American Control Conference* 2003, 4989-4996.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.laws.parts import dead_zone, effort, following, parking
from rodless_control.laws.parts.effort import Bumpless, Drive, Driver, Valve
from rodless_control.laws.parts.following import (
    Follower,
    Known,
    position_error,
    velocity_error,
)
from rodless_control.laws.parts.saturation import within

NAME = "adrc"
TUNED = "tuned over random rigs: docs/laws.md"

PARAMETERS = collect(
    declare(
        Parameter(
            "adrc.bandwidth", 27.3, "rad/s", "rate ω at which the error fades", TUNED, 1.0, 1e4
        ),
        Parameter(
            "adrc.input_gain",
            5.98,
            "m/(s²·V)",
            "acceleration b that a volt is taken to make",
            TUNED,
            1e-3,
            1e5,
        ),
    ),
    effort.declared_offset(NAME),
    dead_zone.declared(NAME, 1.89, 0.0975, TUNED),
    following.declared(NAME, 422.0, 2.5e-5, 2.0, 36.9, TUNED),
)


class Gains(NamedTuple):
    """Constants of the law."""

    bandwidth: float  # rad/s
    input_gain: float  # m/(s²·V)
    follower: Follower
    driver: Driver
    valve: Valve


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    known: Known
    drive: Drive
    applied: float  # V, the effort that the limits have left


class Command(NamedTuple):
    """One evaluation of the law: the voltage and what it is made of."""

    voltage: float  # V
    error: float  # m
    velocity: float  # m/s, estimated
    disturbance: float  # m/s²
    effort: float  # V
    parked: float  # 1 or 0


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    return Gains(
        parameters.number("adrc.bandwidth"),
        parameters.number("adrc.input_gain"),
        Follower.of(parameters, NAME),
        Driver.without_integral(parameters, NAME),
        Valve.of(parameters, NAME),
    )


@kernel
def left_of(valve: Valve, wanted: float) -> float:
    """What the limits leave of an effort (V) with the dead zone crossed in full."""
    zone, limits = valve.dead_zone, valve.limits
    high = max(limits.maximum - limits.neutral - zone.voltage, 0.0)
    low = min(limits.minimum - limits.neutral + zone.voltage, 0.0)
    return within(wanted, low, high)


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:  # noqa: ARG001
    """Memory of a law that has seen the carriage at rest where it is."""
    return Memory(following.begun(measurement), effort.idle(), 0.0)


@kernel
def update(
    gains: Gains,
    memory: Memory,
    measurement: Measurement,
    reference: ReferencePoint,
    interval: float,
) -> tuple[Memory, Command]:
    """Evaluate the law ``interval`` s after the sample before."""
    known = following.followed(
        gains.follower,
        memory.known,
        measurement,
        reference,
        gains.input_gain * memory.applied,
        interval,
    )
    rate, disturbance = gains.bandwidth, known.motion.acceleration
    acceleration = (
        rate * rate * position_error(known)
        + 2.0 * rate * velocity_error(known)
        + known.reference_acceleration
        - disturbance
    )
    wanted = parking.acting(known.parking) * acceleration / gains.input_gain
    drive = effort.driven(gains.driver, memory.drive, known, wanted, interval)
    drive, voltage = effort.commanded(gains.valve, drive)
    return (
        Memory(known, drive, left_of(gains.valve, drive.effort)),
        Command(
            voltage,
            position_error(known),
            known.motion.velocity,
            disturbance,
            drive.effort,
            known.parking.parked,
        ),
    )


class Adrc(Bumpless, CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> law = Adrc({"adrc.bandwidth": 10.0, "adrc.input_gain": 4.0})
    >>> round(law.update(Measurement(0, 0.05), ReferencePoint(0.054), 0.0).effort, 6)
    0.1
    """

    PARAMETERS = PARAMETERS
    TERMS = Command._fields[1:]
    USES_PRESSURES = False
    KERNELS = Kernels(gains_of, begin, update)

    def rebased(self, old: Gains, memory: Memory) -> Known:
        """With another input gain the same effort explains another acceleration."""
        change = (self.gains.input_gain - old.input_gain) * memory.applied
        return following.explained_anew(memory.known, change)
