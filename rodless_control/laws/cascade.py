# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A force loop inside a position loop, by the pressures and a nominal model of valve and air.

The force F = A·(p_a − p_b) is read with the transmitters' lag led out: a fading-memory filter of
``force_bandwidth`` gives F̂ and its rate, F = F̂ + lag·dF̂/dt. The filter of the position is told
F/m; what it does not explain is the disturbance d̂ (m/s²), mostly friction. The outer loop demands

    F_d = m·(r̈ + D·ė + P·e) + f(e, ṙ, r̈) − R·m·d̂ + I

with the friction compensation f in newtons (``parts/friction``) and the share R of the disturbance
that is rejected. The inner loop lets the force follow,

    Ḟ = B·(F_d − F) + dF_d/dt

and asks the inverted nominal model (``parts/pneumatics``) for the voltage. dF_d/dt comes from
another filter of ``force_bandwidth``. Parked, 1 % of Ḟ is asked for. Integral and bumpless gains
are the shared parts, in newtons; the integral holds where the voltage is at a limit.

Bobrow and McDonell, "Modeling, identification, and control of a pneumatically actuated, force
controllable robot", *IEEE Transactions on Robotics and Automation* 14(5), 1998, 732-742; Richer and
Hurmuzlu, "A high performance pneumatic force actuator system: part II", *Journal of Dynamic
Systems, Measurement, and Control* 122(3), 2000, 426-434.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.laws.parts import (
    effort,
    fading_memory,
    following,
    friction,
    parking,
    pneumatics,
)
from rodless_control.laws.parts.effort import Bumpless, Drive, Driver
from rodless_control.laws.parts.fading_memory import Motion
from rodless_control.laws.parts.following import (
    Follower,
    Known,
    position_error,
    velocity_error,
)
from rodless_control.laws.parts.friction import Friction
from rodless_control.laws.parts.numbers import numbers
from rodless_control.laws.parts.pneumatics import Pneumatics
from rodless_control.laws.parts.saturation import Limits, within

NAME = "cascade"
TUNED = "tuned over random rigs: docs/laws.md"

# More than any cylinder of the nominal model gives (N).
LARGEST_FORCE = 1e3

PARAMETERS = collect(
    declare(
        Parameter("cascade.mass", 1.4, "kg", "moving mass m", TUNED, 0.01, 1e3),
        Parameter(
            "cascade.position_gain", 4320.0, "1/s²", "gain P of the outer loop", TUNED, 0.0, 1e6
        ),
        Parameter(
            "cascade.velocity_gain", 113.0, "1/s", "gain D of the outer loop", TUNED, 0.0, 1e4
        ),
        Parameter(
            "cascade.rejection",
            0.54,
            "",
            "share R of the estimated disturbance that is rejected",
            TUNED,
            0.0,
            1.0,
        ),
        Parameter("cascade.force_gain", 111.0, "1/s", "gain B of the inner loop", TUNED, 0.0, 1e4),
        Parameter(
            "cascade.force_bandwidth",
            289.0,
            "rad/s",
            "bandwidth of the filters of the force and of the demanded force",
            TUNED,
            1.0,
            1e5,
        ),
        Parameter(
            "cascade.pressure_lag",
            5e-3,
            "s",
            "time constant of the pressure transmitters, 0 for none",
            "Zhang et al. 2022, Table 1",
            0.0,
            1.0,
        ),
    ),
    friction.declared(NAME, "N", Friction(10.9, 9.17e-5, 22.2, 1e-3, 22.0, 0.0), TUNED),
    effort.declared(NAME, "N", 77000.0, 0.004, TUNED),
    following.declared(NAME, 362.0, 2.5e-5, 2.5, 37.4, TUNED),
    pneumatics.declared(NAME),
)


class Gains(NamedTuple):
    """Constants of the law."""

    mass: float  # kg
    position_gain: float  # 1/s²
    velocity_gain: float  # 1/s
    rejection: float
    force_gain: float  # 1/s
    force_bandwidth: float  # rad/s
    pressure_lag: float  # s
    friction: Friction
    follower: Follower
    driver: Driver
    model: Pneumatics
    limits: Limits


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    known: Known
    drive: Drive
    force: Motion  # N, N/s, N/s²
    demand: Motion  # N, N/s, N/s²


class Command(NamedTuple):
    """One evaluation of the law: the voltage and what it is made of."""

    voltage: float  # V
    error: float  # m
    velocity: float  # m/s, estimated
    force: float  # N
    demanded_force: float  # N
    disturbance: float  # m/s²
    integral: float  # N
    parked: float  # 1 or 0


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    return Gains(
        friction=Friction.of(parameters, NAME),
        follower=Follower.of(parameters, NAME),
        driver=Driver.of(parameters, NAME),
        model=Pneumatics.of(parameters, NAME),
        limits=Limits.of(parameters),
        **numbers(parameters, NAME, Gains),
    )


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:
    """Memory of a law that has seen the carriage at rest where it is."""
    force = pneumatics.force(gains.model, measurement)
    at_rest = fading_memory.at_rest(force)
    # Friction holds what the pressures push.
    known = following.begun(measurement)
    held = Motion(known.motion.position, 0.0, -force / gains.mass)
    known = Known(held, known.parking, measurement, known.reference, 0.0)
    return Memory(known, effort.idle(), at_rest, fading_memory.at_rest(0.0))


@kernel
def demanded(gains: Gains, known: Known) -> float:
    """Force F_d in N that the outer loop wants, without its integral."""
    error = position_error(known)
    return gains.mass * (
        known.reference_acceleration
        + gains.velocity_gain * velocity_error(known)
        + gains.position_gain * error
        - gains.rejection * known.motion.acceleration
    ) + friction.compensation(
        gains.friction, error, known.reference.velocity, known.reference_acceleration
    )


@kernel
def update(
    gains: Gains,
    memory: Memory,
    measurement: Measurement,
    reference: ReferencePoint,
    interval: float,
) -> tuple[Memory, Command]:
    """Evaluate the law ``interval`` s after the sample before."""
    read = pneumatics.force(gains.model, measurement)
    filtered = fading_memory.estimated(gains.force_bandwidth, memory.force, read, 0.0, interval)
    force = filtered.position + gains.pressure_lag * filtered.velocity
    known = following.followed(
        gains.follower, memory.known, measurement, reference, force / gains.mass, interval
    )
    drive = effort.driven(gains.driver, memory.drive, known, demanded(gains, known), interval)
    wanted = within(drive.effort, -LARGEST_FORCE, LARGEST_FORCE)
    demand = fading_memory.estimated(gains.force_bandwidth, memory.demand, wanted, 0.0, interval)
    rate = parking.acting(known.parking) * (gains.force_gain * (wanted - force) + demand.velocity)
    aimed = gains.limits.neutral + pneumatics.deflection_for(
        gains.model, measurement, known.motion.position, known.motion.velocity, rate
    )
    voltage = within(aimed, gains.limits.minimum, gains.limits.maximum)
    return (
        Memory(known, effort.at_limit(drive, aimed, voltage), filtered, demand),
        Command(
            voltage,
            position_error(known),
            known.motion.velocity,
            force,
            wanted,
            known.motion.acceleration,
            drive.integral,
            known.parking.parked,
        ),
    )


class Cascade(Bumpless, CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> law = Cascade()
    >>> sample = Measurement(0, 0.05, 3e5, 3e5, 6e5)
    >>> law.update(sample, ReferencePoint(0.051), 0.0).voltage > 5.08
    True
    """

    PARAMETERS = PARAMETERS
    TERMS = Command._fields[1:]
    KERNELS = Kernels(gains_of, begin, update)
    REACH = LARGEST_FORCE

    def retuned(self, old: Gains, memory: Memory) -> Memory:
        """Of another bore the same pressures are another force."""
        told: Memory = super().retuned(old, memory)
        share = self._wider(old)
        return told._replace(force=Motion(*(share * part for part in told.force)))

    def rebased(self, old: Gains, memory: Memory) -> Known:
        """Of another mass the same force explains another acceleration, and so does another force.

        Another bore makes one of the same pressures, another lag of the same rate.
        """
        force = memory.force.position + old.pressure_lag * memory.force.velocity
        anew = memory.force.position + self.gains.pressure_lag * memory.force.velocity
        change = self._wider(old) * anew / self.gains.mass - force / old.mass
        return following.explained_anew(memory.known, change)

    def _wider(self, old: Gains) -> float:
        """Return how many times as wide as before the piston is."""
        wider: float = self.gains.model.piston_area / old.model.piston_area
        return wider
