# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The two chambers alone, driven by the measured position and the voltage, eqs. (1)-(27)."""

import math

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_sim.physics import heated  # noqa: F401  versions of the equations used here
from rodless_sim.physics.equations import inflows, motion_rate, pressure_rates
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.spool import Drive, Spool, calmed, sent, spool_voltage, swung
from rodless_sim.physics.state import AnyMotion, carried, moved

Array = npt.NDArray[np.float64]

# Longest step of the chambers' equations in s: they are far slower than the carriage's. Where the
# valve goes from one end to the other, pressures of the default cylinder are 0.1 Pa off in its
# middle and 12 at its end, those of the smallest (CY3R6) up to 5 in a whole run.
LONGEST_STEP = 2.5e-4

# By how much (rad) the oscillation of a spool on its way may turn in one step: it may cross the
# dead zone meanwhile, or the end of its stroke, where the openings' curves have a kink.
LONGEST_ANGLE = 0.05

# No step for that is shorter (s): air that a faster spool lets in meanwhile is nothing.
SHORTEST_STEP = 1e-5


@kernel
def rates_along(plant: Plant, lands: Lands, state: AnyMotion) -> AnyMotion:
    """Return the rates of both chambers while the carriage moves as ``state`` says."""
    a, b = pressure_rates(plant, state, inflows(plant, lands, state), state.velocity)
    return motion_rate(state.velocity, 0.0, a, b)


@kernel
def midpoint(plant: Plant, lands: Lands, state: AnyMotion, step: float) -> AnyMotion:
    """Return both chambers a ``step`` (s) later; the carriage is taken to stay where it is."""
    half = moved(state, rates_along(plant, lands, state), 0.5 * step)
    half = carried(half, state.position, state.velocity)
    return moved(state, rates_along(plant, lands, half), step)


@kernel
def longest_step(drive: Drive, spool: Spool) -> float:
    """Return how long a step (s) may be while the spool moves as it does."""
    rests = spool.place == spool.target and spool.speed == 0.0
    if rests or drive.natural_frequency == 0.0:
        return LONGEST_STEP
    turning = LONGEST_ANGLE / drive.natural_frequency
    return min(LONGEST_STEP, max(SHORTEST_STEP, turning))


@kernel
def chamber_pressures(
    plant: Plant,
    drive: Drive,
    dead_time: float,
    first: float,
    voltage: Array,
    position: Array,
    start: AnyMotion,
    period: float,
) -> Array:
    """Integrate P_a and P_b (Pa) from ``start`` along a given motion; returns shape (n, 2).

    ``voltage[k]`` (V, shape (n,)) is commanded from sample k to k+1, while the carriage moves
    evenly from ``position[k]`` (m) to ``position[k + 1]``: so the air is compressed by as much as
    the position shows, however noisy its speed would be. A command arrives ``dead_time`` (s) late.
    The spool, which rests where ``first`` (V) holds it, follows as ``drive`` says, whose own dead
    time does not count.
    """
    pressures = np.empty((voltage.size, 2))
    whole = int(dead_time // period)
    late = dead_time - whole * period
    spool, state = Spool(first, first, 0.0), start
    placed = spool_voltage(spool)
    lands = openings(plant, placed)
    for k in range(voltage.size):
        pressures[k, 0] = state.pressure_a
        pressures[k, 1] = state.pressure_b
        speed = (position[min(k + 1, voltage.size - 1)] - position[k]) / period
        passed = 0.0
        for piece in range(2):
            span = late if piece == 0 else period - late
            spool = sent(drive, spool, voltage[max(k - whole - 1 + piece, 0)])
            count = math.ceil(span / longest_step(drive, spool) - 1e-9)
            step = span / max(count, 1)
            for _ in range(count):
                spool = swung(drive, spool, 0.5 * step)
                if spool_voltage(spool) != placed:
                    placed = spool_voltage(spool)
                    lands = openings(plant, placed)
                where = position[k] + speed * (passed + 0.5 * step)
                state = midpoint(plant, lands, carried(state, where, speed), step)
                spool = calmed(drive, swung(drive, spool, 0.5 * step))
                passed += step
    return pressures
