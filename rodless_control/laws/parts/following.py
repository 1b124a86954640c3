# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a law knows of the carriage and of what is wanted of it.

The fading-memory filter gives ŷ, v̂ and â, and ``reference`` r̈; the errors are e = r − ŷ, ė = ṙ − v̂
and ë = r̈ − â. The parking automaton goes by e, v̂ and ṙ.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, collect
from rodless_control.controller import ReferencePoint
from rodless_control.laws.parts import fading_memory, parking
from rodless_control.laws.parts.fading_memory import Motion, at_rest, estimated
from rodless_control.laws.parts.parking import Parking, ParkingLimits, afoot, parked
from rodless_control.laws.parts.reference import reference_acceleration
from rodless_control.laws.parts.saturation import bounded


class Follower(NamedTuple):
    """Constants of the filter and of parking."""

    filter_bandwidth: float  # rad/s
    parking: ParkingLimits

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Follower":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(parameters.number(f"{law}.filter_bandwidth"), ParkingLimits.of(parameters, law))


class Known(NamedTuple):
    """What is known at a sample."""

    motion: Motion
    parking: Parking
    measurement: Measurement
    reference: ReferencePoint
    reference_acceleration: float  # m/s²


def declared(
    law: str, bandwidth: float, error: float, hysteresis: float, slow: float, source: str
) -> dict[str, Parameter]:
    """Return the parameters of filter and parking as those of ``law``."""
    return collect(
        fading_memory.declared(law, bandwidth, source),
        parking.declared(law, error, hysteresis, slow, source),
    )


@kernel
def begun(measurement: Measurement) -> Known:
    """What is known of a carriage found at rest, and wanted where it is."""
    position = bounded(measurement.position)
    return Known(at_rest(position), afoot(), measurement, ReferencePoint(position, 0.0), 0.0)


@kernel
def followed(
    follower: Follower,
    known: Known,
    measurement: Measurement,
    reference: ReferencePoint,
    acceleration: float,
    interval: float,
) -> Known:
    """What is known ``interval`` s later; ``acceleration`` (m/s²) is what the filter is told."""
    motion = estimated(
        follower.filter_bandwidth,
        known.motion,
        bounded(measurement.position),
        acceleration,
        interval,
    )
    wanted = ReferencePoint(bounded(reference.position), bounded(reference.velocity))
    rise = reference_acceleration(
        follower.filter_bandwidth,
        known.reference_acceleration,
        wanted.velocity - known.reference.velocity,
        interval,
    )
    error = wanted.position - motion.position
    automaton = parked(
        follower.parking, known.parking, error, motion.velocity, wanted.velocity, interval
    )
    return Known(motion, automaton, measurement, wanted, rise)


def explained_anew(known: Known, change: float) -> Known:
    """What is known where ``change`` (m/s²) more of the same acceleration is explained.

    Left to the filter it would show a moment later: after new gains have made no jump, as one.
    """
    motion = known.motion._replace(acceleration=known.motion.acceleration - change)
    return known._replace(motion=motion)


@kernel
def position_error(known: Known) -> float:
    """Error e = r − ŷ in m."""
    return known.reference.position - known.motion.position


@kernel
def velocity_error(known: Known) -> float:
    """Error ė = ṙ − v̂ in m/s."""
    return known.reference.velocity - known.motion.velocity


@kernel
def acceleration_error(known: Known) -> float:
    """Error ë = r̈ − â in m/s²."""
    return known.reference_acceleration - known.motion.acceleration
