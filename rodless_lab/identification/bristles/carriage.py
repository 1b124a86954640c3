# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The carriage alone, driven by the measured pressures against friction with bristles.

Beside the viscous friction the carriage has hardly any inertia: its speed settles within 0.2 ms.
So the steps are implicit midpoints, which need not follow that.
"""

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_sim.physics.bristles import LEAST, Bristles, contact
from rodless_sim.physics.friction import Friction, side_of
from rodless_sim.physics.friction_forms.direction import dry

Array = npt.NDArray[np.float64]

# Steps in a sample. With two the position stays within 0.1 µm of the plant's own.
STEPS = 2

# Speeds of a step are found to so much, m/s, in so many trials at most.
FINEST_SPEED = 1e-9
TRIALS = 20

# No speed is beyond this (m/s): trials of parameters far from the rig's stay finite.
FASTEST = 10.0


@kernel
def bent(bristles: Bristles, friction: Friction, speed: float, before: float, step: float) -> float:
    """Return the deflection (m) of bristles half a ``step`` (s) on, at ``speed`` (m/s)."""
    level = dry(side_of(friction, 1 if speed >= 0.0 else -1), abs(speed)).force
    slip = bristles.stiffness * abs(speed) / max(level, LEAST)
    return (before + 0.5 * step * speed) / (1.0 + 0.5 * step * slip)


@kernel
def lacking(
    bristles: Bristles,
    friction: Friction,
    mass: float,
    push: float,
    before: tuple[float, float],
    step: float,
    speed: float,
) -> float:
    """Return the force (N) that a step at the mean ``speed`` (m/s) would need beside ``push``.

    ``before`` are speed and deflection where the step begins.
    """
    deflection = bent(bristles, friction, speed, before[1], step)
    drag = contact(bristles, friction, speed, deflection).force
    return mass * 2.0 * (speed - before[0]) / step + drag - push


@kernel
def mean_speed(
    bristles: Bristles,
    friction: Friction,
    mass: float,
    push: float,
    before: tuple[float, float],
    step: float,
) -> float:
    """Return the mean speed (m/s) of a step: where nothing is lacking, found by secants.

    Within a bracket, as friction has a kink at standstill.
    """
    low, high = -FASTEST, FASTEST
    one = before[0]
    lack = lacking(bristles, friction, mass, push, before, step, one)
    other = one - lack * step / (2.0 * mass + step * bristles.damping)
    for _ in range(TRIALS):
        if lack > 0.0:
            high = min(high, one)
        else:
            low = max(low, one)
        if not low <= other <= high:
            other = 0.5 * (low + high)
        if abs(other - one) < FINEST_SPEED:
            break
        further = lacking(bristles, friction, mass, push, before, step, other)
        change = further - lack
        following = other - further * (other - one) / change if change != 0.0 else other
        one, lack, other = other, further, following
    return min(max(other, low), high)


@kernel
def carriage_path(
    bristles: Bristles,
    friction: Friction,
    mass: float,
    force: Array,
    start: float,
    period: float,
) -> Array:
    """Return how far (m, shape (n,)) the carriage has gone at each sample, from rest.

    ``force`` (N, shape (n,)) is what moves it besides friction, even between samples a ``period``
    (s) apart; ``start`` (m) the deflection of the bristles at first.
    """
    path = np.zeros(force.size)
    speed, deflection, step = 0.0, start, period / STEPS
    for k in range(force.size - 1):
        path[k + 1] = path[k]
        for piece in range(STEPS):
            push = force[k] + (force[k + 1] - force[k]) * (piece + 0.5) / STEPS
            mean = mean_speed(bristles, friction, mass, push, (speed, deflection), step)
            middle = bent(bristles, friction, mean, deflection, step)
            speed, deflection = 2.0 * mean - speed, 2.0 * middle - deflection
            path[k + 1] += mean * step
    return path
