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
from scipy.signal import savgol_filter

from rodless_base.kernels import kernel
from rodless_lab.identification.friction.uniform_motion import position_noise
from rodless_sim.physics import heated  # noqa: F401  versions of the equations used here
from rodless_sim.physics.equations import inflows, motion_rate, pressure_rates
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import AnyMotion, carried, moved

Array = npt.NDArray[np.float64]

# Longest step of the chambers' equations in s. They are far slower than the carriage's.
LONGEST_STEP = 5e-4

# Stretch in s over which position is smoothed to get speed, and slower than which all is noise.
SMOOTHING = 0.02


# A valve this close (V) to its command has arrived.
ARRIVED = 1e-6


@kernel
def rates_along(plant: Plant, lands: Lands, state: AnyMotion) -> AnyMotion:
    """Return the rates of both chambers while the carriage moves as ``state`` says."""
    a, b = pressure_rates(plant, state, inflows(plant, lands, state), state.velocity)
    return motion_rate(state.velocity, 0.0, a, b)


@kernel
def chamber_pressures(
    plant: Plant,
    voltage: Array,
    position: Array,
    velocity: Array,
    start: AnyMotion,
    period: float,
    steps: int,
    lag: float,
) -> Array:
    """Integrate P_a and P_b (Pa) from ``start`` along a given motion; returns shape (n, 2).

    ``voltage[k]`` (V), ``position[k]`` (m) and ``velocity[k]`` (m/s), shape (n,), hold from sample
    k to k+1, the position moving at the mean of its velocities; ``steps`` midpoint steps each. The
    valve follows the voltage with a first-order ``lag`` (s).
    """
    pressures = np.empty((voltage.size, 2))
    step = period / steps
    keep = math.exp(-0.5 * step / lag) if lag > 0.0 else 0.0
    spool = voltage[0]
    lands = openings(plant, spool)
    state = start
    for k in range(voltage.size):
        pressures[k, 0] = state.pressure_a
        pressures[k, 1] = state.pressure_b
        following = min(k + 1, voltage.size - 1)
        speed = 0.5 * (velocity[k] + velocity[following])
        for i in range(steps):
            if spool != voltage[k]:
                middle = voltage[k] + keep * (spool - voltage[k])
                spool = voltage[k] + keep * (middle - voltage[k])
                if abs(spool - voltage[k]) < ARRIVED:
                    spool = voltage[k]
                lands = openings(plant, middle)
            where = position[k] + speed * step * (i + 0.5)
            state = carried(state, where, speed)
            half = moved(state, rates_along(plant, lands, state), 0.5 * step)
            state = moved(state, rates_along(plant, lands, carried(half, where, speed)), step)
    return pressures


def smoothed_motion(position: Array, period: float) -> tuple[Array, Array]:
    """Position (m) and velocity (m/s) of the carriage from its noisy ``position``, shapes (n,).

    A local parabola; where the whole run moves no further than its noise, it stands still.
    """
    if float(np.ptp(position)) < 12.0 * position_noise(position):
        return np.full(position.shape, position.mean()), np.zeros(position.shape)
    width = 2 * max(round(0.5 * SMOOTHING / period), 2) + 1
    if width > len(position):
        width = len(position) - 1 + len(position) % 2
    smooth = savgol_filter(position, width, 2)
    velocity = savgol_filter(position, width, 2, deriv=1, delta=period)
    return np.asarray(smooth), np.asarray(velocity)
