# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Voltages over time that make a rig show what is to be identified."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_base.parameters import ParameterError
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# Between two of these voltages, in s.
PERIOD = 1e-3


def steps(*stretches: tuple[float, float]) -> Array:
    """Constant voltages one after another: pairs of V and s."""
    return np.concatenate([np.full(round(span / PERIOD), level) for level, span in stretches])


def ramp(start: float, end: float, span: float) -> Array:
    """Voltage changing evenly from ``start`` to ``end`` (V) over ``span`` (s)."""
    return np.linspace(start, end, round(span / PERIOD))


# Square waves of the voltage about closed: size (V), half a period (s), how many periods.
BRISTLE_WAVES = (
    (1.0, 0.03, 20),
    (1.0, 0.05, 12),
    (0.5, 0.15, 4),
    (0.5, 0.2, 4),
    (0.3, 0.6, 2),
    (0.5, 0.3, 3),
    (0.5, 0.5, 2),
    (0.8, 0.3, 2),
    (0.8, 0.6, 2),
)


# How far beyond the closed position the carriage creeps (V), unless told otherwise; and the range.
CREEP = 0.25
LEAST_CREEP, MOST_CREEP = 0.2, 0.4


def friction_voltages(creep: float = CREEP) -> Array:
    """Creep up and down through the dead zone, then four constant voltages; each way.

    ``creep`` is how far from the closed position (V): a spool with hysteresis arrives late by half
    of its width, and a carriage that has not moved by then shows no slow friction.
    """
    top = CLOSED_VOLTAGE + creep
    forward = np.concatenate(
        [
            ramp(5.23, top, 8.0),
            ramp(top, 5.24, 3.0),
            steps((5.36, 1.5), (5.45, 1.5), (5.6, 1.25), (5.8, 1.0)),
        ]
    )
    reverse = 2.0 * CLOSED_VOLTAGE - forward
    return np.concatenate([forward, steps((CLOSED_VOLTAGE, 0.3)), reverse])


def chamber_voltages() -> Array:
    """Fill and vent both chambers, open and nearly closed, the carriage free to move."""
    closed = CLOSED_VOLTAGE
    return steps((closed, 0.2), (5.7, 0.8), (4.6, 0.9), (closed, 0.4), (5.45, 0.7), (4.2, 0.5))


def heat_voltages() -> Array:
    """Fill and vent quickly, and wait with the valve closed: air cools or warms for a second."""
    closed = CLOSED_VOLTAGE
    return steps(
        *((closed, 0.2), (5.7, 0.6), (closed, 1.2), (4.4, 0.6), (closed, 1.2)),
        *((6.5, 0.3), (closed, 0.8), (3.6, 0.3), (closed, 0.8)),
    )


def leak_voltages() -> Array:
    """Move, then fill either chamber and let both settle, the valve closed or open by a hair.

    What the carriage displaces shows the scale of all flows: at rest a valve that passes more
    looks like larger leaks of larger chambers.
    """
    closed = CLOSED_VOLTAGE
    settling = steps(
        *((closed, 0.4), (5.7, 0.5), (closed, 1.2), (4.4, 0.5), (closed, 1.2)),
        *((closed + 0.1, 0.8), (closed - 0.1, 0.8), (closed + 0.04, 0.6), (closed - 0.04, 0.6)),
    )
    return np.concatenate([chamber_voltages(), settling])


def square_wave(low: float, high: float, half: float, count: int) -> Array:
    """Go to ``high`` and to ``low`` (V) in turn, ``half`` a period (s) each, ``count`` times."""
    return steps(*((high, half), (low, half)) * count)


def spool_voltages() -> Array:
    """Come back to the closed position from either side, then square waves about it.

    Where the play leaves the spool shows in how the pressures settle. The waves are as fast as the
    spool, once within its stroke by far, where they pass the dead zone late, and once hardly beyond
    it; their overshoot stays off the ends of the stroke. Both chambers breathe alike, so that the
    carriage stays.
    """
    closed = CLOSED_VOLTAGE
    settling = steps(
        *((closed, 0.2), (5.7, 0.6), (closed, 0.5), (4.5, 0.6), (closed, 0.5)),
        *((closed + 0.06, 0.3), (closed - 0.06, 0.3), (closed + 0.06, 0.3), (closed, 0.2)),
    )
    waves = [
        square_wave(closed - size, closed + size, half, count)
        for size in (1.0, 3.0)
        for half, count in ((0.010, 15), (0.006, 20), (0.003, 20))
    ]
    return np.concatenate([settling, *waves])


def bristle_voltages() -> Array:
    """Push the carriage to and fro: below breakaway, quickly and slowly, then beyond it.

    Below, it moves on its bristles; quick pushes tell their damping; sliding tells the rest of
    friction. The pressures gather what the valve passes, so square waves of the voltage are
    triangles of the force. Waves begin with half a push, up and down in turn: what one is off the
    middle, as the chambers differ, the next takes back.
    """
    closed = CLOSED_VOLTAGE
    waves = [
        half_a_push_early(square_wave(closed - size, closed + size, half, count), half)
        for size, half, count in BRISTLE_WAVES
    ]
    turned = [2.0 * closed - wave if place % 2 else wave for place, wave in enumerate(waves)]
    return np.concatenate([steps((closed, 0.2)), *turned])


def half_a_push_early(wave: Array, half: float) -> Array:
    """Return a square wave of half period ``half`` (s) that begins in the middle of one."""
    return np.roll(wave, -round(0.5 * half / PERIOD))


# By what is to be identified.
EXCITATIONS: dict[str, Callable[[], Array]] = {
    "bristles": bristle_voltages,
    "chambers": chamber_voltages,
    "friction": friction_voltages,
    "heat": heat_voltages,
    "leak": leak_voltages,
    "spool": spool_voltages,
    "valve": chamber_voltages,
}


def excitation(
    subject: str, closed_voltage: float = CLOSED_VOLTAGE, creep: float | None = None
) -> Array:
    """Return voltages (V), one per :data:`PERIOD`, for a valve closed at ``closed_voltage`` (V).

    They are those for the paper's 5.08 V, shifted by as much as the valve is. ``creep`` is that of
    :func:`friction_voltages`. Raises KeyError for no subject, and ParameterError for what
    ``valve.closed_voltage`` cannot be, and a creep of another subject or beyond its range.
    """
    closed = RigParameters({"valve.closed_voltage": closed_voltage}).number("valve.closed_voltage")
    shape = EXCITATIONS[subject]() if creep is None else _creeping(subject, creep)
    voltages: Array = shape + (closed - CLOSED_VOLTAGE)
    return voltages


def _creeping(subject: str, creep: float) -> Array:
    """Return the voltages of `friction` with this ``creep``; raises as :func:`excitation`."""
    if subject != "friction":
        raise ParameterError(f"--creep: refused, {subject} does not creep, only friction does")
    if not LEAST_CREEP <= creep <= MOST_CREEP:
        raise ParameterError(
            f"--creep: {creep:g} refused, must be from {LEAST_CREEP:g} to {MOST_CREEP:g} (V)"
        )
    return friction_voltages(creep)
