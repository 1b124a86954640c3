# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Two laws in turn: the cascade follows what moves, the PID arrives and keeps still.

No set of gains does both well: what follows a sine within tenths of a millimetre moves the valve at
rest. So the reference decides, as in disk drives, which seek with one controller and hold the track
with another:

    the reference moves, or has been at rest for less than ``rest_time``:  u = u_cascade
    otherwise:                                                             u = u_pid

Both laws are told of every sample, so that each knows motion and force when its turn comes. The one
whose turn it is not does not integrate: nothing would stop it. The cascade begins each turn with an
integral of 0, since what it had was the friction of another move; the PID goes on with the one it
had. Their equations stand at the top of ``cascade`` and ``pid``, and their parameters have the
names they have there.

Yamaguchi, Numasato, Hirai, "A mode-switching control for motion control and its application to
disk drives: design of optimal mode-switching conditions", *IEEE/ASME Transactions on Mechatronics*
3(3), 1998, 202-209.
"""

from collections.abc import Mapping
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_control.controller import CompiledLaw, Kernels, ReferencePoint
from rodless_control.laws import cascade, pid
from rodless_control.laws.parts.effort import Drive

PARAMETERS = collect(
    declare(
        Parameter(
            "mode_switching.rest_time",
            0.05,
            "s",
            "how long the reference is at rest before the PID takes over from the cascade",
            "judgement",
            0.0,
            10.0,
        )
    ),
    pid.PARAMETERS,
    cascade.PARAMETERS,
)


class Gains(NamedTuple):
    """Constants of the law."""

    rest_time: float  # s
    positioning: pid.Gains
    following: cascade.Gains


class Memory(NamedTuple):
    """What the law carries from one sample to the next."""

    positioning: pid.Memory
    following: cascade.Memory
    rest: float  # s, for how long the reference has been at rest, at most ``rest_time``


class Command(NamedTuple):
    """One evaluation of the law: the voltage, and what either law wants."""

    voltage: float  # V
    error: float  # m, as the law in force sees it
    following: float  # 1 for the cascade, 0 for the PID
    positioning_voltage: float  # V
    following_voltage: float  # V


def gains_of(parameters: ParameterSet) -> Gains:
    """Return the constants of the law for one set of parameters."""
    return Gains(
        parameters.number("mode_switching.rest_time"),
        pid.gains_of(parameters),
        cascade.gains_of(parameters),
    )


@kernel
def begin(gains: Gains, measurement: Measurement) -> Memory:
    """Memory of a law that has seen the carriage at rest where it is."""
    return Memory(
        pid.begin(gains.positioning, measurement),
        cascade.begin(gains.following, measurement),
        gains.rest_time,
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
    positioned, there = pid.update(
        gains.positioning, memory.positioning, measurement, reference, interval
    )
    followed, along = cascade.update(
        gains.following, memory.following, measurement, reference, interval
    )
    moves = reference.velocity != 0.0
    rest = 0.0 if moves else min(memory.rest + interval, gains.rest_time)
    follows = moves or rest < gains.rest_time
    # A bad reading makes one of them NaN; the command is then NaN whoever's turn it is, so that
    # neither law keeps the reading.
    voltage = (
        along.voltage + 0.0 * there.voltage if follows else there.voltage + 0.0 * along.voltage
    )
    if follows:
        positioned = pid.Memory(memory.positioning.integral, *positioned[1:])
    else:
        followed = without_integral(followed)
    return (
        Memory(positioned, followed, rest),
        Command(
            voltage,
            along.error if follows else there.error,
            1.0 if follows else 0.0,
            there.voltage,
            along.voltage,
        ),
    )


@kernel
def without_integral(memory: cascade.Memory) -> cascade.Memory:
    """The memory of a cascade that has nothing integrated."""
    drive = Drive(0.0, memory.drive.offset, memory.drive.effort, memory.drive.saturated)
    return cascade.Memory(memory.known, drive, memory.force, memory.demand)


class ModeSwitching(CompiledLaw):
    """The law with its memory; one :meth:`update` per sample.

    Examples
    --------
    >>> law = ModeSwitching()
    >>> sample = Measurement(0, 0.05, 3e5, 3e5, 6e5)
    >>> law.update(sample, ReferencePoint(0.051), 0.0).following
    0.0
    >>> law.update(sample, ReferencePoint(0.051, 0.1), 1e-3).following
    1.0
    """

    PARAMETERS = PARAMETERS
    TERMS = Command._fields[1:]
    KERNELS = Kernels(gains_of, begin, update)

    def __init__(self, parameters: Mapping[str, object] | None = None) -> None:
        """Take values by name (default: all defaults) and compile; raises ParameterError."""
        super().__init__(parameters)
        self._positioning = pid.Pid(self._own(pid.Pid))
        self._following = cascade.Cascade(self._own(cascade.Cascade))

    def _own(self, law: type[CompiledLaw]) -> dict[str, object]:
        return {name: self.parameters[name] for name in law.Parameters.DECLARATIONS}

    def resumed(self, begun: Memory, before: Memory) -> Memory:
        """Keep what either law keeps over a gap."""
        return Memory(
            self._positioning.resumed(begun.positioning, before.positioning),
            self._following.resumed(begun.following, before.following),
            begun.rest,
        )

    def retuned(self, old: Gains, memory: Memory) -> Memory:
        """Let the law whose turn it is take up the jump that its new gains would make.

        The other moves no command: what it took up would be a jump as its turn begins.
        """
        self._positioning.gains = self.gains.positioning
        self._following.gains = self.gains.following
        positioned, followed = memory.positioning, memory.following
        there = self._positioning.retuned(old.positioning, positioned)
        along = self._following.retuned(old.following, followed)
        rested = memory.rest >= old.rest_time
        if rested and positioned.reference_velocity == 0.0:
            drive = along.drive._replace(offset=followed.drive.offset)
            along = along._replace(drive=drive)
        else:
            there = there._replace(offset=positioned.offset)
        return Memory(there, along, self.gains.rest_time if rested else memory.rest)
