# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction that lags behind the motion: what bristles give over parts of a measured run.

Eq. (29) is what bristles settle at. Until they have slid by some multiples of their deflection,
which at a slow speed takes longer than a part lasts, they carry less, or more. So the deflection is
integrated along the measured motion, and a part's mean force compared with the part's mean.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_coeffs, savgol_filter

from rodless_base.kernels import kernel
from rodless_lab.identification.friction.curve import Stribeck
from rodless_lab.identification.friction.form import FrictionForm
from rodless_lab.identification.friction.uniform_motion import UniformPart, position_noise
from rodless_sim import RigParameters
from rodless_sim.physics.bristles import LEAST, Bristles, contact
from rodless_sim.physics.friction import Friction
from rodless_sim.physics.friction_forms.direction import Direction, dry

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]

# Stretch in s over which position is smoothed: over 0.06 s its noise, 20 µm, would still bend
# bristles of 1e5 N/m by some 0.3 N.
SMOOTHED = 0.12

# The motion is followed in steps of this length (s), in each of which the speed is one.
STEP = 0.01


@dataclass(frozen=True)
class BristleMotion:
    """A run's motion, as bristles follow it.

    ``speeds`` (m/s, shape (n,)) are those in steps of ``step`` s; part k lasts from step
    ``firsts[k]`` up to ``lasts[k]``. ``error`` (m) is the standard error of a position.
    """

    bristles: Bristles
    speeds: Array
    step: float
    firsts: Places
    lasts: Places
    error: float

    @classmethod
    def of(
        cls,
        parameters: RigParameters,
        position: Array,
        period: float,
        parts: Sequence[UniformPart],
    ) -> "BristleMotion":
        """Return the motion of ``position`` (m, shape (n,), a sample each ``period`` s)."""
        stride = max(round(STEP / period), 1)
        width = min(max(round(0.5 * SMOOTHED / period), 2), (len(position) - 1) // 2) * 2 + 1
        smooth = np.asarray(savgol_filter(position, width, 2))
        speeds = np.diff(smooth[::stride]) / (stride * period)
        # A run of n samples has n - 1 steps: a part may last as long as it.
        lasts = [min(part.last // stride, len(speeds)) for part in parts]
        return cls(
            Bristles.of(parameters),
            speeds,
            stride * period,
            np.array([part.first // stride for part in parts], dtype=np.int64),
            np.array(lasts, dtype=np.int64),
            position_noise(position) * math.sqrt(float(savgol_coeffs(width, 2)[width // 2])),
        )

    def along(self, sign: float, chosen: npt.NDArray[np.bool_]) -> "BristleMotion":
        """Return the motion with ``sign`` as its forward, and the ``chosen`` parts alone."""
        firsts, lasts = self.firsts[chosen], self.lasts[chosen]
        return replace(self, speeds=sign * self.speeds, firsts=firsts, lasts=lasts)

    def forces(self, form: FrictionForm, curve: Stribeck) -> Array:
        """Mean friction (N) over each part, shape (k,), where it settles at that of ``curve``."""
        side = Direction(*(float(value) for value in curve))
        friction = Friction(form.code, form.own, side, side, 0.0)
        return followed(self.bristles, friction, self.speeds, self.step, self.firsts, self.lasts)

    def force_errors(self, speeds: Array, forces: Array) -> Array:
        """What the error of the position does to such a mean (N, standard error, shape (k,)).

        Bristles that hold turn it into a force by their stiffness; those that slip, at ``speeds``
        (m/s) with ``forces`` (N), forget it on their way through SMOOTHED.
        """
        stiffness = self.bristles.stiffness
        forgotten = stiffness * np.abs(speeds) * SMOOTHED / np.maximum(np.abs(forces), LEAST)
        return np.asarray(stiffness * self.error / (1.0 + forgotten))


@kernel
def followed(
    bristles: Bristles,
    friction: Friction,
    speeds: Array,
    step: float,
    firsts: Places,
    lasts: Places,
) -> Array:
    """Integrate the deflection along ``speeds``; return the mean force (N) of each part."""
    total = np.zeros(speeds.size + 1)
    deflection = 0.0
    for k in range(speeds.size):
        speed = abs(speeds[k])
        level = max(dry(friction.forward, speed).force, LEAST)
        settled = math.copysign(level / bristles.stiffness, speeds[k])
        slipped = max(bristles.stiffness * speed / level * step, 1e-12)
        gone = -math.expm1(-slipped)
        mean = settled + (deflection - settled) * gone / slipped
        total[k + 1] = total[k] + contact(bristles, friction, speeds[k], mean).force
        deflection += (settled - deflection) * gone
    means = np.empty(firsts.size)
    for k in range(firsts.size):
        means[k] = (total[lasts[k]] - total[firsts[k]]) / (lasts[k] - firsts[k])
    return means
