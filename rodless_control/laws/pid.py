"""PID position control of a valve with a dead centre: the law, and an object around it."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, specialise
from rodless_control.parameters import PidParameters

# Lengths and velocities beyond this (m, m/s) count as this large: with every term finite, no
# infinity can turn into NaN where two meet.
LARGEST = 1e3


class Gains(NamedTuple):
    """Constants of the control law; units as the parameters of the same names."""

    kp: float
    ki: float
    kd: float
    filter_bandwidth: float
    feedforward: float
    integral_zone: float
    error_dead_band: float
    conditional_integration: bool
    back_calculation: bool
    tracking_time: float
    dead_zone_voltage: float
    dead_zone_width: float
    neutral_voltage: float
    minimum_voltage: float
    maximum_voltage: float


class Memory(NamedTuple):
    """What the law carries from one sample to the next: V, m, m/s, and V that fade."""

    integral: float
    filtered_position: float
    filtered_velocity: float
    offset: float


class Command(NamedTuple):
    """One evaluation of the law: the voltage, the error (m), and the terms it is made of (V)."""

    voltage: float
    error: float
    p: float
    i: float
    d: float
    feedforward: float


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
def filtered(gains: Gains, memory: Memory, position: float, interval: float) -> Memory:
    """First-order low-pass of the measurement, exact for a position held over ``interval`` (s)."""
    if interval <= 0.0:
        return memory
    share = 1.0 - math.exp(-gains.filter_bandwidth * interval)
    change = share * (position - memory.filtered_position)
    return Memory(
        memory.integral, memory.filtered_position + change, change / interval, memory.offset
    )


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
def update(
    gains: Gains,
    memory: Memory,
    reference: float,
    reference_velocity: float,
    position: float,
    interval: float,
) -> tuple[Memory, Command]:
    """Evaluate the law at one sample: m, m/s, m, and the time since the last sample in s.

    An ``interval`` of 0 (the first sample) neither integrates nor differentiates.
    """
    position = bounded(position)
    memory = filtered(gains, memory, position, interval)
    error = bounded(reference) - position
    p = gains.kp * error
    d = -gains.kd * memory.filtered_velocity
    feedforward = gains.feedforward * bounded(reference_velocity)
    offset = memory.offset * math.exp(-interval / gains.tracking_time)
    integral = integrated(gains, memory.integral, p + d + feedforward + offset, error, interval)
    voltage = limited(gains, compensated(gains, p + integral + offset + d + feedforward))
    return (
        Memory(integral, memory.filtered_position, memory.filtered_velocity, offset),
        Command(voltage, error, p, integral + offset, d, feedforward),
    )


@kernel
def at_rest(position: float) -> Memory:
    """Memory of a controller that has seen the carriage resting at ``position`` (m)."""
    return Memory(0.0, bounded(position), 0.0, 0.0)


def gains_of(parameters: PidParameters) -> Gains:
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


class Pid:
    """The control law with its memory; one call of :meth:`update` per position sample."""

    def __init__(self, parameters: PidParameters | None = None) -> None:
        """Start from ``parameters`` (default: all defaults)."""
        self._gains = gains_of(parameters or PidParameters())
        self._update = specialise(update, self._gains, at_rest(0.0), 0.0, 0.0, 0.0, 0.0)
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next sample is taken as the first."""
        self._memory: Memory | None = None
        self._reference_velocity = 0.0
        self._error = 0.0
        self._held = False

    def hold(self) -> None:
        """Keep the integral over a gap in the samples; the filter starts anew after it."""
        self._held = True

    def update(
        self, reference: float, reference_velocity: float, position: float, interval: float
    ) -> Command:
        """Return the command for one sample (m, m/s, m, s since the last sample)."""
        if self._memory is None:
            self._memory, interval = at_rest(position), 0.0
        if self._held:
            kept = self._memory.integral
            self._memory, interval = at_rest(position)._replace(integral=kept), 0.0
            self._held = False
        self._memory, command = self._update(
            self._gains, self._memory, reference, reference_velocity, position, interval
        )
        self._reference_velocity = bounded(reference_velocity)
        self._error = command.error
        return command

    def configure(self, parameters: PidParameters) -> None:
        """Change the gains without a jump: an offset takes up the difference and fades.

        It fades over ``controller.tracking_time``. Left in the integral, it would stay there
        wherever the integrator holds, and keep the carriage off its target.
        """
        old, new = self._gains, gains_of(parameters)
        self._gains = new
        if self._memory is not None:
            jump = (
                (new.kp - old.kp) * self._error
                - (new.kd - old.kd) * self._memory.filtered_velocity
                + (new.feedforward - old.feedforward) * self._reference_velocity
            )
            self._memory = self._memory._replace(offset=self._memory.offset - jump)
