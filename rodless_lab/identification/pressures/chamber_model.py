# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The two chambers alone, driven by the measured position and the voltage, eqs. (1)-(27)."""

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_filter

from rodless_base.kernels import kernel
from rodless_lab.identification.friction.uniform_motion import position_noise
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim.physics.cylinder import pressure_rate, volume_a, volume_b
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

Array = npt.NDArray[np.float64]

# Longest step of the chambers' equations in s. They are far slower than the carriage's.
LONGEST_STEP = 5e-4

# Stretch in s over which position is smoothed to get speed, and slower than which all is noise.
SMOOTHING = 0.02


@kernel
def chamber_pressures(
    plant: Plant,
    voltage: Array,
    position: Array,
    velocity: Array,
    start: tuple[float, float],
    period: float,
    steps: int,
) -> Array:
    """Integrate P_a and P_b (Pa) from ``start`` along a given motion; returns shape (n, 2).

    ``voltage[k]`` (V), ``position[k]`` (m) and ``velocity[k]`` (m/s), shape (n,), hold from sample
    k to k+1, the position moving at the mean of its velocities; ``steps`` midpoint steps each.
    """
    air, cylinder = plant.air, plant.cylinder
    pressures = np.empty((voltage.size, 2))
    a, b = start
    step = period / steps
    lands = openings(plant, voltage[0])
    for k in range(voltage.size):
        pressures[k, 0] = a
        pressures[k, 1] = b
        if k == 0 or voltage[k] != voltage[k - 1]:
            lands = openings(plant, voltage[k])
        following = min(k + 1, voltage.size - 1)
        speed = 0.5 * (velocity[k] + velocity[following])
        for i in range(steps):
            where = position[k] + speed * step * (i + 0.5)
            first, second = volume_a(cylinder, where), volume_b(cylinder, where)
            change = cylinder.piston_area * speed
            to_a, to_b = inflows(plant, lands, Motion(where, speed, a, b))
            half_a = a + 0.5 * step * pressure_rate(air, first, change, a, to_a.mass_flow)
            half_b = b + 0.5 * step * pressure_rate(air, second, -change, b, to_b.mass_flow)
            to_a, to_b = inflows(plant, lands, Motion(where, speed, half_a, half_b))
            a += step * pressure_rate(air, first, change, half_a, to_a.mass_flow)
            b += step * pressure_rate(air, second, -change, half_b, to_b.mass_flow)
    return pressures


def smoothed_motion(run: MeasuredRun) -> tuple[Array, Array]:
    """Position (m) and velocity (m/s) of the carriage from its noisy position, shapes (n,).

    A local parabola; where the whole run moves no further than its noise, it stands still.
    """
    if float(np.ptp(run.position)) < 12.0 * position_noise(run.position):
        return np.full(run.position.shape, run.position.mean()), np.zeros(run.position.shape)
    width = 2 * max(round(0.5 * SMOOTHING / run.period), 2) + 1
    if width > len(run.position):
        width = len(run.position) - 1 + len(run.position) % 2
    position = savgol_filter(run.position, width, 2)
    velocity = savgol_filter(run.position, width, 2, deriv=1, delta=run.period)
    return np.asarray(position), np.asarray(velocity)
