# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Sliding mode control with a boundary layer.

For a valve that sets a velocity the surface s = 0 is an error that fades at the rate
λ = ``surface_bandwidth``,

    s = e + ė/λ

and the law drives the carriage onto it with up to K volts, linearly within the boundary layer of
thickness φ, where a switching law would chatter:

    w = f(e, ṙ, r̈) + F_a·r̈ + K·sat(s/φ)
    effort = w + I
    voltage = neutral + effort + crossing(effort)      within the limits

e and ė come from the fading-memory filter, f is the friction compensation in volts
(``parts/friction``), the equivalent control that needs no model: what the valve must pass to move
at ṙ. Parking, integral, bumpless gains and the dead zone are the shared parts.

Slotine and Li, *Applied Nonlinear Control*, 1991, sections 7.1-7.2; Bone and Ning, "Experimental
comparison of position tracking control algorithms for pneumatic cylinder actuators", *IEEE/ASME
Transactions on Mechatronics* 12(5), 2007, 557-561.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.laws.parts import dead_zone, effort, following, friction, parking
from rodless_control.laws.parts.effort import Bumpless, Drive, Driver, Valve
from rodless_control.laws.parts.following import (
    Follower,
    Known,
    position_error,
    velocity_error,
)
from rodless_control.laws.parts.friction import Friction
from rodless_control.laws.parts.numbers import numbers
from rodless_control.laws.parts.saturation import within

NAME = "sliding_mode"
TUNED = "tuned over random rigs: docs/laws.md"

PARAMETERS = collect(
    declare(
        Parameter(
            "sliding_mode.surface_bandwidth",
            38.0,
            "rad/s",
            "rate λ at which the error fades on the surface",
            TUNED,
            1.0,
            1e4,
        ),
        Parameter(
            "sliding_mode.reaching_voltage",
            4.2,
            "V",
            "voltage K that drives the carriage onto the surface",
            TUNED,
            0.0,
            10.0,
        ),
        Parameter(
            "sliding_mode.boundary_layer",
            0.0022,
            "m",
            "thickness φ of the layer about the surface in which the law is linear",
            TUNED,
            1e-6,
            1.0,
        ),
        Parameter(
            "sliding_mode.acceleration_feedforward",
            0.08,
            "V·s²/m",
            "voltage F_a per reference acceleration",
            TUNED,
            0.0,
            100.0,
        ),
    ),
    friction.declared(NAME, "V", Friction(0.0, 1e-4, 0.1, 1e-3, 2.5, 0.0), TUNED),
    effort.declared(NAME, "V", 20.0, 3e-4, TUNED),
    dead_zone.declared(NAME, 0.7, 0.12, TUNED),
    following.declared(NAME, 376.0, 2.5e-5, 2.0, 33.5, TUNED),
)


class Gains(NamedTuple):
    """Constants of the law."""

    surface_bandwidth: float  # rad/s
    reaching_voltage: float  # V
    boundary_layer: float  # m
    acceleration_feedforward: float  # V·s²/m
    friction: Friction
    follower: Follower
    driver: Driver
    valve: Valve


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    known: Known
    drive: Drive


class Command(NamedTuple):
    """One evaluation of the law: the voltage and what it is made of."""

    voltage: float  # V
    error: float  # m
    velocity: float  # m/s, estimated
    surface: float  # m
    effort: float  # V
    integral: float  # V
    parked: float  # 1 or 0


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    return Gains(
        friction=Friction.of(parameters, NAME),
        follower=Follower.of(parameters, NAME),
        driver=Driver.of(parameters, NAME),
        valve=Valve.of(parameters, NAME),
        **numbers(parameters, NAME, Gains),
    )


@kernel
def surface(gains: Gains, known: Known) -> float:
    """Distance s from the surface in m."""
    return position_error(known) + velocity_error(known) / gains.surface_bandwidth


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:  # noqa: ARG001
    """Memory of a law that has seen the carriage at rest where it is."""
    return Memory(following.begun(measurement), effort.idle())


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
    distance = surface(gains, known)
    error = position_error(known)
    wanted = parking.acting(known.parking) * (
        friction.compensation(
            gains.friction, error, known.reference.velocity, known.reference_acceleration
        )
        + gains.acceleration_feedforward * known.reference_acceleration
        + gains.reaching_voltage * within(distance / gains.boundary_layer, -1.0, 1.0)
    )
    drive = effort.driven(gains.driver, memory.drive, known, wanted, interval)
    drive, voltage = effort.commanded(gains.valve, drive)
    return (
        Memory(known, drive),
        Command(
            voltage,
            error,
            known.motion.velocity,
            distance,
            drive.effort,
            drive.integral,
            known.parking.parked,
        ),
    )


class SlidingMode(Bumpless, CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> law = SlidingMode({"sliding_mode.boundary_layer": 0.01})
    >>> round(law.update(Measurement(0, 0.05), ReferencePoint(0.055), 0.0).surface, 6)
    0.005
    """

    PARAMETERS = PARAMETERS
    TERMS = Command._fields[1:]
    USES_PRESSURES = False
    KERNELS = Kernels(gains_of, begin, update)
