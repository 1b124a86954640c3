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
works where ``error_dead_band`` < |e| < ``integral_zone``, beyond the zone it only unwinds, and
``anti_windup`` keeps it from winding up at a limit. New gains start without a jump: an offset in i
takes up the difference and fades with ``tracking_time``. After Åström and Hägglund, *PID
Controllers*, 1995, chapter 3.

Options for a carriage that must stop within micrometres and keep still, off by default:

- ``filter`` = fading_memory: position and velocity are the estimates of a filter that has no lag in
  position (``parts/fading_memory``), for the error too.
- ``gain_boost`` β: p = kp·e·(1 + β·exp(−(e/w)²)) with w = ``gain_boost_width``, more gain near the
  target: Seraji, "A new class of nonlinear PID controllers with robotic applications", *Journal of
  Robotic Systems* 15(3), 1998, 161-181.
- ``acceleration_feedforward``: f has a share of d²r/dt² too (``parts/reference``).
- ``parking_error``: a carriage that is there is left alone (``parts/parking``): p, d and f shrink
  to 1 %, and the integral holds.
- ``parking_correction``: a parked carriage that creeps is held at the edge of the band; p has it.
"""

import math
from typing import ClassVar, NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.laws.parts import dead_zone, fading_memory, parking
from rodless_control.laws.parts.effort import VOLTAGE_REACH, taken_up
from rodless_control.laws.parts.fading_memory import Motion
from rodless_control.laws.parts.numbers import numbers
from rodless_control.laws.parts.parking import Parking, ParkingLimits
from rodless_control.laws.parts.reference import reference_acceleration
from rodless_control.laws.parts.saturation import bounded, held_at_limit, unwound, within
from rodless_control.parameters import OUTPUT, LawParameters

TUNED = "tuned on the simulated rig"
OPTION = "an option, off by default"

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
        "bandwidth of the measurement filter",
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
        "error beyond which the integrator only unwinds",
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
    *dead_zone.declared("controller", 0.6, 0.3, TUNED).values(),
    Parameter(
        "controller.filter",
        "low_pass",
        "",
        "low_pass of first order, for the derivative alone; or fading_memory, without lag in "
        "position, for error and derivative",
        "Morrison, Introduction to Sequential Smoothing and Prediction, 1969",
        choices=("low_pass", "fading_memory"),
    ),
    Parameter(
        "controller.gain_boost",
        0.0,
        "",
        "proportional gain at a small error beyond the one at a large error, as a share of it",
        OPTION,
        0.0,
        100.0,
    ),
    Parameter(
        "controller.gain_boost_width",
        6e-4,
        "m",
        "error at which the boost of the gain has faded by e (Gaussian)",
        OPTION,
        1e-6,
        1.0,
    ),
    Parameter(
        "controller.acceleration_feedforward",
        0.0,
        "V·s²/m",
        "voltage per reference acceleration, added inside the limits",
        OPTION,
        0.0,
        100.0,
    ),
    *parking.declared("controller", 0.0, 2.0, 33.5, OPTION).values(),
    Parameter(
        "controller.parking_correction",
        0.0,
        "V/m",
        "voltage while parked per slow error beyond parking_error, so that the carriage does not "
        "creep away; 0 for none",
        OPTION,
        0.0,
        1e5,
    ),
)


class PidParameters(LawParameters):
    """The parameters of the PID and the limits of its output; see docs/parameters.md.

    Examples
    --------
    >>> PidParameters.preset("paper").with_values({"controller.kp": 500.0})["controller.kp"]
    500.0
    """

    DECLARATIONS: ClassVar[dict[str, Parameter]] = {**PARAMETERS, **OUTPUT}
    LAW_NAME: ClassVar[str] = "pid"


class Options(NamedTuple):
    """Constants of the options."""

    fading_memory: bool
    gain_boost: float
    gain_boost_width: float  # m
    acceleration_feedforward: float  # V·s²/m
    parking: ParkingLimits


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
    options: Options


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    integral: float  # V
    filtered_position: float  # m
    filtered_velocity: float  # m/s
    offset: float  # V, left by a change of gains; fades
    position: float  # m, as last read
    error: float  # m, of the last sample
    reference_velocity: float  # m/s, of the last sample
    reference_acceleration: float  # m/s²
    acceleration: float  # m/s², estimated by the fading-memory filter
    slow_error: float  # m, of the parking automaton
    parked: float  # 1, or 0
    interval: float  # s, between the last two samples, 0 where there was only one


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
    return Gains(
        conditional_integration=anti_windup == "conditional_integration",
        back_calculation=anti_windup == "back_calculation",
        options=Options(
            fading_memory=parameters.text("controller.filter") == "fading_memory",
            gain_boost=parameters.number("controller.gain_boost"),
            gain_boost_width=parameters.number("controller.gain_boost_width"),
            acceleration_feedforward=parameters.number("controller.acceleration_feedforward"),
            parking=ParkingLimits.of(
                parameters, "controller", parameters.number("controller.parking_correction")
            ),
        ),
        **numbers(parameters, "controller", Gains),
    )


@kernel
def compensated(gains: Gains, effort: float) -> float:
    """Voltage for ``effort`` (V about neutral) with the valve's flat centre crossed, unlimited."""
    crossing = dead_zone.crossing(gains.dead_zone_voltage, gains.dead_zone_width, effort)
    return gains.neutral_voltage + effort + crossing


@kernel
def limited(gains: Gains, voltage: float) -> float:
    """``voltage`` within the command limits."""
    return within(voltage, gains.minimum_voltage, gains.maximum_voltage)


@kernel
def filtered(gains: Gains, memory: Memory, position: float, interval: float) -> Motion:
    """Motion by the chosen filter, for a position held over ``interval`` (s).

    The low-pass is of first order, and this its exact solution; it leaves the position as read to
    the error.
    """
    if gains.options.fading_memory:
        known = Motion(memory.filtered_position, memory.filtered_velocity, memory.acceleration)
        return fading_memory.estimated(gains.filter_bandwidth, known, position, 0.0, interval)
    if interval <= 0.0:
        return Motion(memory.filtered_position, memory.filtered_velocity, 0.0)
    share = 1.0 - math.exp(-gains.filter_bandwidth * interval)
    change = share * (position - memory.filtered_position)
    return Motion(memory.filtered_position + change, change / interval, 0.0)


@kernel
def proportional(gains: Gains, error: float) -> float:
    """Proportional term (V), boosted near the target where that is asked for."""
    p = gains.kp * error
    boost, ratio = gains.options.gain_boost, error / gains.options.gain_boost_width
    return p * (1.0 + boost * math.exp(-ratio * ratio)) if boost > 0.0 else p


@kernel
def fed_forward(gains: Gains, velocity: float, acceleration: float) -> float:
    """Feed-forward (V) of the reference's velocity (m/s) and, if asked for, acceleration (m/s²)."""
    ahead = gains.feedforward * velocity
    share = gains.options.acceleration_feedforward
    return ahead + share * acceleration if share > 0.0 else ahead


@kernel
def integrated(
    gains: Gains, integral: float, others: float, error: float, interval: float
) -> float:
    """Integral term after ``interval`` (s), kept from winding up; ``others`` is the rest of u.

    Where the integrator holds, it is not driven back either: it could not return by itself. Beyond
    its zone it unwinds, at the pace of the zone's edge, while it pushes away from the target.
    """
    if not abs(error) > gains.error_dead_band:
        return integral
    if not abs(error) < gains.integral_zone:
        return unwound(integral, gains.ki, gains.integral_zone, error, interval)
    grown = integral + gains.ki * error * interval
    wanted = compensated(gains, others + grown)
    excess = wanted - limited(gains, wanted)
    if gains.conditional_integration:
        return held_at_limit(integral, grown, excess)
    if gains.back_calculation:
        return grown - excess * min(interval / gains.tracking_time, 1.0)
    return grown


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:  # noqa: ARG001
    """Memory of a law that has seen the carriage at rest where it is."""
    position = bounded(measurement.position)
    return Memory(0.0, position, 0.0, 0.0, position, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


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
    motion = filtered(gains, memory, position, interval)
    seen = motion.position if gains.options.fading_memory else position
    error = bounded(reference.position) - seen
    acceleration = reference_acceleration(
        gains.filter_bandwidth,
        memory.reference_acceleration,
        velocity - memory.reference_velocity,
        interval,
    )
    automaton = parking.parked(
        gains.options.parking,
        Parking(memory.slow_error, memory.parked),
        error,
        motion.velocity,
        velocity,
        interval,
    )
    p = proportional(gains, error)
    d = -gains.kd * motion.velocity
    feedforward = fed_forward(gains, velocity, acceleration)
    offset = memory.offset * math.exp(-interval / gains.tracking_time)
    integral = memory.integral
    if automaton.parked > 0.0:
        share = parking.acting(automaton)
        p, d, feedforward = share * p, share * d, share * feedforward
        p += parking.held(gains.options.parking, automaton)
    else:
        others = p + d + feedforward + offset
        integral = integrated(gains, integral, others, error, interval)
    voltage = limited(gains, compensated(gains, p + integral + offset + d + feedforward))
    return (
        Memory(
            integral,
            motion.position,
            motion.velocity,
            offset,
            position,
            error,
            velocity,
            acceleration,
            motion.acceleration,
            automaton.slow_error,
            automaton.parked,
            interval if interval > 0.0 else memory.interval,
        ),
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
        carriage off its target. Where the command is at a limit, what of the jump does not show is
        left: taken up, it would outlast the move and drive the carriage past its target.
        """
        new: Gains = self.gains
        rest = memory.integral + memory.offset
        before, after = (self._reactions(gains, memory) + rest for gains in (old, new))
        memory = memory._replace(filtered_position=self._filtered_anew(old, memory))
        return memory._replace(offset=memory.offset + taken_up(before, after, VOLTAGE_REACH))

    def _filtered_anew(self, old: Gains, memory: Memory) -> float:
        """Return the position (m) from which the filter goes on with the velocity that it has.

        That of a low-pass is what it lags by: left as it was, another bandwidth would read another
        velocity in it, and the damping would jump one sample after the change.
        """
        new: Gains = self.gains
        if new.options.fading_memory:
            # Where the low-pass has lagged to is no position to start from.
            return memory.filtered_position if old.options.fading_memory else memory.position
        same = new.filter_bandwidth == old.filter_bandwidth and not old.options.fading_memory
        if same or memory.interval <= 0.0:
            return memory.filtered_position
        turn = new.filter_bandwidth * memory.interval
        lag = memory.filtered_velocity * memory.interval * math.exp(-turn) / -math.expm1(-turn)
        return memory.position - lag

    @staticmethod
    def _reactions(gains: Gains, memory: Memory) -> float:
        """Sum (V) of all terms but the integral at the last sample."""
        parks = gains.options.parking.error > 0.0
        automaton = Parking(memory.slow_error, memory.parked if parks else 0.0)
        ahead = fed_forward(gains, memory.reference_velocity, memory.reference_acceleration)
        acting = proportional(gains, memory.error) - gains.kd * memory.filtered_velocity + ahead
        # Asked for in motion, too: a parked carriage would wait for it to be compiled.
        held = parking.held(gains.options.parking, automaton)
        return parking.acting(automaton) * acting + (held if automaton.parked > 0.0 else 0.0)
