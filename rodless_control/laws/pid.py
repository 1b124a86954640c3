# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""PID position control of a valve with a flat centre.

With the error e = r − y and the measurement y_f behind a low-pass filter of ``filter_bandwidth``,

    p = kp·e      i = ∫ ki·e dt      d = −kd·dy_f/dt      f = feedforward·dr/dt
    u = p + i + d + f
    voltage = neutral + u + dead_zone_voltage·tanh(u / dead_zone_width)      within the limits

The derivative acts on the filtered measurement, so that a step of r gives no impulse. The integral
works where ``error_dead_band`` < |e| < ``integral_zone``, and ``anti_windup`` keeps it from winding
up at a limit. New gains start without a jump: an offset in i takes up the difference and fades with
``tracking_time``. After Åström and Hägglund, *PID Controllers*, 1995, chapter 3.
"""

import math
from typing import ClassVar, NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.parameters import OUTPUT, LawParameters

TUNED = "tuned on the simulated rig"

PARAMETERS = declare(
    Parameter("controller.kp", 800.0, "V/m", "proportional gain", TUNED, 0.0, 1e5),
    Parameter("controller.ki", 55.0, "V/(m·s)", "integral gain", TUNED, 0.0, 1e5),
    Parameter(
        "controller.kd",
        60.0,
        "V·s/m",
        "derivative gain, on the filtered measurement",
        TUNED,
        0.0,
        1e4,
    ),
    Parameter(
        "controller.filter_bandwidth",
        50.0,
        "rad/s",
        "bandwidth of the measurement filter of the derivative",
        TUNED,
        1.0,
        1e5,
    ),
    Parameter(
        "controller.feedforward",
        75.0,
        "V·s/m",
        "voltage per reference velocity, added inside the limits",
        TUNED,
        0.0,
        1e3,
    ),
    Parameter(
        "controller.integral_zone",
        2.5e-3,
        "m",
        "error beyond which the integrator holds",
        TUNED,
        0.0,
        10.0,
    ),
    Parameter(
        "controller.error_dead_band",
        6e-5,
        "m",
        "error within which the integrator holds, so that a carriage at rest is not disturbed",
        TUNED,
        0.0,
        0.1,
    ),
    Parameter(
        "controller.anti_windup",
        "conditional_integration",
        "",
        "what the integrator does at a limit: hold, be driven back, or nothing",
        "Åström and Hägglund, PID Controllers, 1995, section 3.5",
        choices=("conditional_integration", "back_calculation", "none"),
    ),
    Parameter(
        "controller.tracking_time",
        0.1,
        "s",
        "time constant of back-calculation, and of what makes a change of gains bumpless",
        "Åström and Hägglund, PID Controllers, 1995, section 3.5",
        1e-3,
        100.0,
    ),
    Parameter(
        "controller.dead_zone_voltage",
        0.6,
        "V",
        "voltage added in the direction of the command to cross the valve's flat centre",
        TUNED,
        0.0,
        2.0,
    ),
    Parameter(
        "controller.dead_zone_width",
        0.3,
        "V",
        "command at which three quarters of the dead-zone voltage is added",
        TUNED,
        1e-4,
        5.0,
    ),
)

# Lengths and velocities beyond this (m, m/s) count as this large: with every term finite, no
# infinity can turn into NaN where two meet.
LARGEST = 1e3


class PidParameters(LawParameters):
    """The parameters of the PID and the limits of its output; see docs/parameters.md.

    Examples
    --------
    >>> PidParameters.preset("paper").with_values({"controller.kp": 500.0})["controller.kp"]
    500.0
    """

    DECLARATIONS: ClassVar[dict[str, Parameter]] = {**PARAMETERS, **OUTPUT}
    LAW_NAME: ClassVar[str] = "pid"


class Gains(NamedTuple):
    """Constants of the law: the parameters of the same names, in their units."""

    kp: float  # V/m
    ki: float  # V/(m·s)
    kd: float  # V·s/m
    filter_bandwidth: float  # rad/s
    feedforward: float  # V·s/m
    integral_zone: float  # m
    error_dead_band: float  # m
    conditional_integration: bool
    back_calculation: bool
    tracking_time: float  # s
    dead_zone_voltage: float  # V
    dead_zone_width: float  # V
    neutral_voltage: float  # V
    minimum_voltage: float  # V
    maximum_voltage: float  # V


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    integral: float  # V
    filtered_position: float  # m
    filtered_velocity: float  # m/s
    offset: float  # V, left by a change of gains; fades
    error: float  # m, of the last sample
    reference_velocity: float  # m/s, of the last sample


class Command(NamedTuple):
    """One evaluation of the law: the voltage and the terms it is made of.

    Examples
    --------
    >>> command = Pid().update(Measurement(0, 0.05), ReferencePoint(0.051), 0.0)
    >>> round(command.error, 6), round(command.p, 6)
    (0.001, 0.8)
    """

    voltage: float  # V
    error: float  # m
    p: float  # V
    i: float  # V
    d: float  # V
    feedforward: float  # V


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    anti_windup = parameters.text("controller.anti_windup")
    numbers = {
        name: parameters.number(f"controller.{name}")
        for name, kind in Gains.__annotations__.items()
        if kind is float
    }
    return Gains(
        conditional_integration=anti_windup == "conditional_integration",
        back_calculation=anti_windup == "back_calculation",
        **numbers,
    )


@kernel
def compensated(gains: Gains, effort: float) -> float:
    """Voltage for ``effort`` (V about neutral) with the valve's flat centre crossed, unlimited."""
    crossing = gains.dead_zone_voltage * math.tanh(effort / gains.dead_zone_width)
    return gains.neutral_voltage + effort + crossing


@kernel
def limited(gains: Gains, voltage: float) -> float:
    """``voltage`` within the command limits."""
    return min(max(voltage, gains.minimum_voltage), gains.maximum_voltage)


@kernel
def bounded(length: float) -> float:
    """``length`` (m) or velocity (m/s), no larger than any rig needs."""
    return min(max(length, -LARGEST), LARGEST)


@kernel
def filtered(gains: Gains, memory: Memory, position: float, interval: float) -> tuple[float, float]:
    """Filtered position (m) and velocity (m/s) for a position held over ``interval`` (s).

    The filter is a first-order low-pass, and this its exact solution.
    """
    if interval <= 0.0:
        return memory.filtered_position, memory.filtered_velocity
    share = 1.0 - math.exp(-gains.filter_bandwidth * interval)
    change = share * (position - memory.filtered_position)
    return memory.filtered_position + change, change / interval


@kernel
def integrated(
    gains: Gains, integral: float, others: float, error: float, interval: float
) -> float:
    """Integral term after ``interval`` (s), kept from winding up; ``others`` is the rest of u.

    Where the integrator holds, it is not driven back either: it could not return by itself.
    """
    if not gains.error_dead_band < abs(error) < gains.integral_zone:
        return integral
    grown = integral + gains.ki * error * interval
    wanted = compensated(gains, others + grown)
    excess = wanted - limited(gains, wanted)
    if gains.conditional_integration and excess * (grown - integral) > 0.0:
        return integral
    if gains.back_calculation:
        return grown - excess * min(interval / gains.tracking_time, 1.0)
    return grown


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:  # noqa: ARG001
    """Memory of a law that has seen the carriage at rest where it is."""
    return Memory(0.0, bounded(measurement.position), 0.0, 0.0, 0.0, 0.0)


@kernel
def update(
    gains: Gains,
    memory: Memory,
    measurement: Measurement,
    reference: ReferencePoint,
    interval: float,
) -> tuple[Memory, Command]:
    """Evaluate the law ``interval`` s after the sample before.

    An ``interval`` of 0 (the first sample) neither integrates nor differentiates.
    """
    position, velocity = bounded(measurement.position), bounded(reference.velocity)
    filtered_position, filtered_velocity = filtered(gains, memory, position, interval)
    error = bounded(reference.position) - position
    p = gains.kp * error
    d = -gains.kd * filtered_velocity
    feedforward = gains.feedforward * velocity
    offset = memory.offset * math.exp(-interval / gains.tracking_time)
    integral = integrated(gains, memory.integral, p + d + feedforward + offset, error, interval)
    voltage = limited(gains, compensated(gains, p + integral + offset + d + feedforward))
    return (
        Memory(integral, filtered_position, filtered_velocity, offset, error, velocity),
        Command(voltage, error, p, integral + offset, d, feedforward),
    )


class Pid(CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> pid = Pid(PidParameters({"controller.kp": 100.0}))
    >>> round(pid.update(Measurement(0, 0.05), ReferencePoint(0.06), 0.0).p, 6)
    1.0
    """

    PARAMETERS = PARAMETERS
    Parameters = PidParameters
    TERMS = Command._fields[1:]
    USES_PRESSURES = False
    KERNELS = Kernels(gains_of, begin, update)

    def resumed(self, begun: Memory, before: Memory) -> Memory:
        """Keep the integral over a gap; the filter starts anew after it."""
        return begun._replace(integral=before.integral)

    def retuned(self, old: Gains, memory: Memory) -> Memory:
        """Let the offset take up the jump that new gains would make.

        Left in the integral, it would stay there wherever the integrator holds, and keep the
        carriage off its target.
        """
        new: Gains = self.gains
        jump = (
            (new.kp - old.kp) * memory.error
            - (new.kd - old.kd) * memory.filtered_velocity
            + (new.feedforward - old.feedforward) * memory.reference_velocity
        )
        return memory._replace(offset=memory.offset - jump)
