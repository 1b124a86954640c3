# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Position, velocity and acceleration feedback with feed-forward and pressure damping.

With the errors e, ė, ë of the fading-memory filter (``parts/following``) and the pressure
difference Δ = p_a − p_b,

    w = K_p·e + K_v·ė + K_a·ë + F_v·ṙ + F_a·r̈ − K_Δ·(Δ − Δ_s)
    effort = w + I
    voltage = neutral + effort + crossing(effort)      within the limits

This is the law of industrial pneumatic axes: the three states of valve (an integrator of force),
mass and position fed back, the reference's derivatives fed forward. Δ_s is Δ behind a low-pass of
``pressure_bandwidth``, so that a load does not shift the position: only a change of force is
damped. Parking, integral, bumpless gains and the dead zone are the shared parts.

Wang, Pu, Moore, "A practical control strategy for servo-pneumatic actuator systems", *Control
Engineering Practice* 7(12), 1999, 1483-1488; Ning and Bone, "High steady-state accuracy pneumatic
servo positioning system with PVA/PV control and friction compensation", *ICRA* 2002, 2824-2829.
"""

import math
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
    acceleration_error,
    position_error,
    velocity_error,
)
from rodless_control.laws.parts.numbers import numbers
from rodless_control.laws.parts.saturation import bounded_pressure

NAME = "state_feedback"
TUNED = "tuned over random rigs: docs/laws.md"

PARAMETERS = collect(
    declare(
        Parameter("state_feedback.position_gain", 2190.0, "V/m", "gain K_p", TUNED, 0.0, 1e5),
        Parameter("state_feedback.velocity_gain", 64.4, "V·s/m", "gain K_v", TUNED, 0.0, 1e4),
        Parameter(
            "state_feedback.acceleration_gain", 0.0141, "V·s²/m", "gain K_a", TUNED, 0.0, 100.0
        ),
        Parameter(
            "state_feedback.velocity_feedforward",
            2.55,
            "V·s/m",
            "voltage F_v per reference velocity, beyond what the velocity gain makes",
            TUNED,
            0.0,
            1e3,
        ),
        Parameter(
            "state_feedback.acceleration_feedforward",
            0.0777,
            "V·s²/m",
            "voltage F_a per reference acceleration",
            TUNED,
            0.0,
            100.0,
        ),
        Parameter(
            "state_feedback.pressure_damping",
            1.55e-6,
            "V/Pa",
            "gain K_Δ on what the pressure difference changes",
            TUNED,
            0.0,
            1e-3,
        ),
        Parameter(
            "state_feedback.pressure_bandwidth",
            20.6,
            "rad/s",
            "bandwidth below which a pressure difference counts as a load",
            TUNED,
            0.1,
            1e4,
        ),
    ),
    effort.declared(NAME, "V", 27.7, 2.9e-4, TUNED),
    dead_zone.declared(NAME, 0.706, 0.12, TUNED),
    following.declared(NAME, 376.0, 2.5e-5, 2.0, 31.7, TUNED),
)


class Gains(NamedTuple):
    """Constants of the law."""

    position_gain: float  # V/m
    velocity_gain: float  # V·s/m
    acceleration_gain: float  # V·s²/m
    velocity_feedforward: float  # V·s/m
    acceleration_feedforward: float  # V·s²/m
    pressure_damping: float  # V/Pa
    pressure_bandwidth: float  # rad/s
    follower: Follower
    driver: Driver
    valve: Valve


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    known: Known
    drive: Drive
    slow_difference: float  # Pa


class Command(NamedTuple):
    """One evaluation of the law: the voltage and what it is made of."""

    voltage: float  # V
    error: float  # m
    velocity: float  # m/s, estimated
    effort: float  # V
    integral: float  # V
    damping: float  # V
    parked: float  # 1 or 0


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    return Gains(
        follower=Follower.of(parameters, NAME),
        driver=Driver.of(parameters, NAME),
        valve=Valve.of(parameters, NAME),
        **numbers(parameters, NAME, Gains),
    )


@kernel
def difference(measurement: Measurement) -> float:
    """Pressure difference Δ in Pa."""
    return bounded_pressure(measurement.pressure_a) - bounded_pressure(measurement.pressure_b)


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:  # noqa: ARG001
    """Memory of a law that has seen the carriage at rest where it is."""
    return Memory(following.begun(measurement), effort.idle(), difference(measurement))


@kernel
def update(
    gains: Gains,
    memory: Memory,
    measurement: Measurement,
    reference: ReferencePoint,
    interval: float,
) -> tuple[Memory, Command]:
    """Evaluate the law ``interval`` s after the sample before."""
    known = following.followed(gains.follower, memory.known, measurement, reference, 0.0, interval)
    pressures = difference(measurement)
    share = -math.expm1(-gains.pressure_bandwidth * interval)
    slow = memory.slow_difference + share * (pressures - memory.slow_difference)
    damping = -gains.pressure_damping * (pressures - slow)
    wanted = parking.acting(known.parking) * (
        gains.position_gain * position_error(known)
        + gains.velocity_gain * velocity_error(known)
        + gains.acceleration_gain * acceleration_error(known)
        + gains.velocity_feedforward * known.reference.velocity
        + gains.acceleration_feedforward * known.reference_acceleration
        + damping
    )
    drive = effort.driven(gains.driver, memory.drive, known, wanted, interval)
    drive, voltage = effort.commanded(gains.valve, drive)
    return (
        Memory(known, drive, slow),
        Command(
            voltage,
            position_error(known),
            known.motion.velocity,
            drive.effort,
            drive.integral,
            damping,
            known.parking.parked,
        ),
    )


class StateFeedback(Bumpless, CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> law = StateFeedback({"state_feedback.position_gain": 100.0})
    >>> sample = Measurement(0, 0.05, 3e5, 3e5, 6e5)
    >>> round(law.update(sample, ReferencePoint(0.06), 0.0).effort, 6)
    1.0
    """

    PARAMETERS = PARAMETERS
    TERMS = Command._fields[1:]
    KERNELS = Kernels(gains_of, begin, update)
