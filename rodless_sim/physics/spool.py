# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The valve's drive: how its spool follows the command, which the paper takes to be at once.

A command arrives late, a play swallows its smallest changes, and the spool swings to where the play
sends it:

    y ← min(max(y, u − w), u + w)                     w = half the width of the hysteresis
    ẍ + 2 ζ ω ẋ + ω² x = ω² y

All are voltages: x is the command that would hold the spool where it is. Nothing acts back on the
spool, and between two commands y is constant: x is known in closed form. So the spool is no state
that is integrated, but a known course that the openings take.
"""

import math
from typing import Any, NamedTuple

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE, NANOSECONDS_PER_SECOND
from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

DATA_SHEET = "Festo MPYE data sheet"
SECOND_ORDER = "second_order"

PARAMETERS = declare(
    Parameter(
        "valve.dynamics",
        "none",
        "",
        "how the spool follows the command: none: at once; second_order: as a damped oscillator",
        "docs/options/spool.md",
        choices=("none", SECOND_ORDER),
        fixed=True,
    ),
    Parameter(
        "valve.natural_frequency",
        115.0,
        "Hz",
        f"natural frequency of the spool ({SECOND_ORDER})",
        f"{DATA_SHEET}: critical frequency of the MPYE-5-M5",
        1.0,
        2000.0,
    ),
    Parameter(
        "valve.damping",
        0.7,
        "",
        f"damping ratio ζ of the spool ({SECOND_ORDER})",
        f"{JUDGEMENT}: −3 dB at 1.01 times the natural frequency",
        0.05,
        5.0,
    ),
    Parameter(
        "valve.hysteresis",
        0.0,
        "",
        "hysteresis of the spool, share of its full stroke of 10 V; 0 for none",
        f"{DATA_SHEET}: at most 0.004",
        0.0,
        0.1,
        fixed=True,
    ),
    Parameter(
        "valve.dead_time",
        0.0,
        "s",
        "how late a command reaches the valve, to the nanosecond; 0 for none",
        f"{JUDGEMENT}: 1 ms",
        0.0,
        0.1,
        fixed=True,
    ),
)

# Nearer than this, and slower than this a radian, the spool is at rest: no opening shows it.
REST = 1e-9  # V


class Drive(NamedTuple):
    """Constants of the valve's drive."""

    dead_time: int  # ns
    play: float  # V, to either side
    natural_frequency: float  # rad/s, 0 for a spool that follows at once
    damping: float  # -


class Spool(NamedTuple):
    """Where the spool is, and where its drive sends it."""

    target: float  # V
    place: float  # V
    speed: float  # V/s


class Memory(NamedTuple):
    """What the valve and what is about it remember, where the equations change with plant time."""

    spool: Any  # Spool, () where it is where the command says
    time: float  # s, since the start or the last reset
    supply: float  # Pa, at the valve
    tubes: Any  # air_in_tubes.Tubes, () without any


# Nothing where the spool is where the command says.
AnySpool = Spool | Memory | tuple[()]


def of(parameters: ParameterSet) -> Drive | tuple[()]:
    """Return the constants for ``parameters``; none where the spool follows the command at once."""
    second_order = parameters.text("valve.dynamics") == SECOND_ORDER
    hysteresis, dead_time = (parameters.number(f"valve.{n}") for n in ("hysteresis", "dead_time"))
    if not second_order and hysteresis == 0.0 and dead_time == 0.0:
        return ()
    frequency = 2.0 * math.pi * parameters.number("valve.natural_frequency")
    return Drive(
        dead_time=round(dead_time * NANOSECONDS_PER_SECOND),
        play=0.5 * hysteresis * (MAXIMUM_VOLTAGE - MINIMUM_VOLTAGE),
        natural_frequency=frequency if second_order else 0.0,
        damping=parameters.number("valve.damping"),
    )


def starting_spool(drive: Drive | tuple[()], voltage: float) -> Spool | tuple[()]:
    """Return the spool at rest where ``voltage`` (V) holds it; nothing where it follows at once."""
    return Spool(voltage, voltage, 0.0) if drive else ()


@kernel
def sent(drive: Drive, spool: Spool, command: float) -> Spool:
    """Return the spool on its way to a ``command`` (V) that has just arrived."""
    target = min(max(spool.target, command - drive.play), command + drive.play)
    return Spool(target, spool.place, spool.speed)


@kernel
def swung(drive: Drive, spool: Spool, duration: float) -> Spool:
    """Return the spool ``duration`` s later, by the closed form for any damping ratio."""
    frequency = drive.natural_frequency
    if frequency == 0.0:
        return Spool(spool.target, spool.target, 0.0)
    angle = frequency * duration
    decay = math.exp(-drive.damping * angle)
    # cosh √z and sinh √z / √z, cos and sin for a negative z.
    square = (drive.damping * drive.damping - 1.0) * angle * angle
    if abs(square) < 1e-3:
        even = 1.0 + square / 2.0 * (1.0 + square / 12.0 * (1.0 + square / 30.0))
        odd = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0))
    else:
        root = math.sqrt(abs(square))
        even = math.cosh(root) if square > 0.0 else math.cos(root)
        odd = (math.sinh(root) if square > 0.0 else math.sin(root)) / root
    off = spool.place - spool.target
    damped = drive.damping * angle * odd
    return Spool(
        spool.target,
        spool.target + decay * ((even + damped) * off + odd * duration * spool.speed),
        decay * ((even - damped) * spool.speed - frequency * angle * odd * off),
    )


@kernel
def calmed(drive: Drive, spool: Spool) -> Spool:
    """Return the spool at rest, exactly, where it nearly is."""
    slow = abs(spool.speed) <= REST * drive.natural_frequency
    if slow and abs(spool.place - spool.target) <= REST:
        return Spool(spool.target, spool.target, 0.0)
    return spool


@kernel
def spool_voltage(spool: Spool) -> float:
    """Command in V that would hold the spool where it is; its stroke ends at 0 and 10 V."""
    return min(max(spool.place, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE)


def spool_in(memory: AnySpool) -> Spool | tuple[()]:
    """Return the spool that is remembered; nothing of one that follows at once."""
    return memory.spool if isinstance(memory, Memory) else memory


def with_spool(memory: AnySpool, spool: Spool | tuple[()]) -> AnySpool:
    """Return ``memory`` with another ``spool``."""
    return memory._replace(spool=spool) if isinstance(memory, Memory) else spool


def holding_voltage(drive: Drive, memory: AnySpool) -> float:
    """Return a command in V that stops the spool where it is, on its way to where it was sent.

    With a play others hold it, too; this one also sends there who comes from the same side.
    """
    spool = spool_in(memory)
    assert isinstance(spool, Spool)
    on = spool.target - spool.place
    return spool.place - math.copysign(drive.play, on) if on else spool.place


def place_of(memory: AnySpool) -> float | None:
    """Return the :func:`spool_voltage` of what is remembered; None for one that follows at once."""
    spool = spool_in(memory)
    return float(spool_voltage(spool)) if spool else None
