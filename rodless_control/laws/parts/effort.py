# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""From what a law wants to its effort and, for a law in volts, to the command.

    effort = wanted + I + offset
    voltage = neutral + effort + crossing(effort)      within the limits

New gains start without a jump of the effort: what stands behind it, the crossing of the dead zone
and a law's model of the valve, acts at once. The offset takes up the difference that they make at
the last sample and fades with ``tracking_time``, as the PID's does. What two efforts differ by
beyond ``REACH``, where a command is at its limit, does not count: there is no jump between two
commands at one limit.
"""

import math
from typing import Any, NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control.laws.parts import integral
from rodless_control.laws.parts.dead_zone import DeadZone, crossing
from rodless_control.laws.parts.following import Known, position_error
from rodless_control.laws.parts.integral import Integrator, integrated
from rodless_control.laws.parts.saturation import Limits, within

# With an effort (V) of this and more the command is at its limit, whatever the neutral voltage.
VOLTAGE_REACH = 10.0


class Driver(NamedTuple):
    """Constants of the effort."""

    integrator: Integrator
    tracking_time: float  # s

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Driver":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(Integrator.of(parameters, law), parameters.number(f"{law}.tracking_time"))

    @classmethod
    def without_integral(cls, parameters: ParameterSet, law: str) -> "Driver":
        """Return the constants of a ``law`` that has no integral."""
        return cls(Integrator(0.0, 0.0), parameters.number(f"{law}.tracking_time"))


class Valve(NamedTuple):
    """Constants of what turns an effort in V into a command."""

    dead_zone: DeadZone
    limits: Limits

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Valve":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(DeadZone.of(parameters, law), Limits.of(parameters))


class Drive(NamedTuple):
    """What a law remembers of its efforts, in their unit."""

    integral: float
    offset: float  # left by a change of gains; fades
    effort: float
    saturated: float  # sign of the limit the command is at, 0 between them


def declared(law: str, unit: str, gain: float, zone: float, source: str) -> dict[str, Parameter]:
    """Return the parameters of the integral and of new gains as those of ``law``."""
    return collect(integral.declared(law, unit, gain, zone, source), declared_offset(law))


def declared_offset(law: str) -> dict[str, Parameter]:
    """Return the parameter of new gains as that of ``law``."""
    return declare(
        Parameter(
            f"{law}.tracking_time",
            0.1,
            "s",
            "time constant with which the difference that new gains make fades",
            "Åström and Hägglund, PID Controllers, 1995, section 3.5",
            1e-3,
            100.0,
        )
    )


@kernel
def idle() -> Drive:
    """Memory before the first sample."""
    return Drive(0.0, 0.0, 0.0, 0.0)


@kernel
def driven(driver: Driver, drive: Drive, known: Known, wanted: float, interval: float) -> Drive:
    """Effort for what the law wants, ``interval`` s after the one before."""
    kept = drive.integral
    if known.parking.parked == 0.0:
        kept = integrated(driver.integrator, kept, position_error(known), drive.saturated, interval)
    offset = drive.offset * math.exp(-interval / driver.tracking_time)
    return Drive(kept, offset, wanted + kept + offset, drive.saturated)


@kernel
def at_limit(drive: Drive, wanted: float, voltage: float) -> Drive:
    """Take note of the ``voltage`` that was left of the one ``wanted`` (V)."""
    saturated = 0.0
    if wanted > voltage:
        saturated = 1.0
    elif wanted < voltage:
        saturated = -1.0
    return Drive(drive.integral, drive.offset, drive.effort, saturated)


@kernel
def commanded(valve: Valve, drive: Drive) -> tuple[Drive, float]:
    """Command in V for an effort in V, and the memory that knows whether it is at a limit."""
    zone, limits = valve.dead_zone, valve.limits
    wanted = limits.neutral + drive.effort + crossing(zone.voltage, zone.width, drive.effort)
    voltage = within(wanted, limits.minimum, limits.maximum)
    return at_limit(drive, wanted, voltage), voltage


def taken_up(before: float, after: float, reach: float) -> float:
    """Return what keeps the command of an effort as it was ``before`` new gains.

    From ``reach`` on the command is at its limit, whatever the effort: only what is short of it
    shows.

    Examples
    --------
    >>> taken_up(3.0, 46.0, 10.0), taken_up(46.0, 3.0, 10.0), taken_up(46.0, 30.0, 10.0)
    (-43.0, 7.0, 0.0)
    """
    if before >= reach:
        return max(reach - after, 0.0)
    if before <= -reach:
        return min(-reach - after, 0.0)
    return before - after


class Bumpless:
    """For a law whose memory has ``known`` and ``drive``: what survives gaps and new gains."""

    REACH = VOLTAGE_REACH

    gains: Any
    _update: Any

    def resumed(self, begun: Any, before: Any) -> Any:
        """Keep the integral over a gap; filter and parking start anew after it."""
        return begun._replace(drive=begun.drive._replace(integral=before.drive.integral))

    def retuned(self, old: Any, memory: Any) -> Any:
        """Let the offset take up the jump that new gains would make at the last sample."""
        told = memory._replace(known=self.rebased(old, memory))
        before, after = self._effort(old, memory), self._effort(self.gains, told)
        offset = told.drive.offset + taken_up(before, after, self.REACH)
        return told._replace(drive=told.drive._replace(offset=offset))

    def rebased(self, old: Any, memory: Any) -> Known:  # noqa: ARG002
        """Return what is known where new gains explain another share of the acceleration."""
        known: Known = memory.known
        return known

    def _effort(self, gains: Any, memory: Any) -> float:
        sample = memory.known.measurement, memory.known.reference, 0.0
        effort: float = self._update(gains, memory, *sample)[0].drive.effort
        return effort
