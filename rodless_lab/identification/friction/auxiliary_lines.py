# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The paper's own way to friction parameters: two auxiliary lines, Fig. 12 and section 5.1."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from rodless_base.number_rows import number_rows

Array = npt.NDArray[np.float64]

# Speeds closer than this (m/s) give no line a slope.
LEAST_APART = 1e-12


@dataclass(frozen=True)
class AuxiliaryLines:
    """Line f_1 through the start of the curve, line f_2 along the motion.

    ``static`` and ``stribeck_velocity`` are NaN where nothing was measured left of the minimum;
    ``note`` then says so.
    """

    static: float  # N
    coulomb: float  # N
    stribeck_velocity: float  # m/s
    viscous: float  # N·s/m
    note: str = ""


def auxiliary_lines(speeds: Array, forces: Array, breakaway: float | None = None) -> AuxiliaryLines:
    """Construct f_1 and f_2 on points of one direction, Fig. 12 and section 5.1 of the paper.

    f_2 runs along the upper half of the speeds: its slope is B, it meets the force axis in F_c.
    f_1 falls from the force axis at F_s to the slowest point of the motion, and meets the level F_c
    at v_s.

    Parameters
    ----------
    speeds, forces
        Magnitudes in m/s and N, shape (n,).
    breakaway
        F_s in N; otherwise the points left of the minimum give it.

    Raises
    ------
    ValueError
        For fewer than two points, points whose faster half have one speed, and what are no numbers,
        or not as many forces as speeds.

    Examples
    --------
    >>> speeds = np.array([5e-3, 10e-3, 20e-3])
    >>> lines = auxiliary_lines(speeds, 12.0 + 4500.0 * speeds)
    >>> round(lines.coulomb, 6), round(lines.viscous, 6)
    (12.0, 4500.0)
    """
    speed, force = number_rows({"speeds": speeds, "forces": forces})
    if len(speed) < 2:
        raise ValueError("auxiliary lines need two uniform runs in a direction")
    order = np.argsort(speed)
    speed, force = speed[order], force[order]
    upper = slice(min(len(speed) // 2, len(speed) - 2), None)
    if np.ptp(speed[upper]) < LEAST_APART:
        raise ValueError(
            f"speeds: the faster ones are all {speed[-1]:g} m/s, a line needs two that differ"
        )
    viscous, coulomb, *_ = stats.linregress(speed[upper], force[upper])
    lowest = int(np.argmin(force))
    if breakaway is not None:
        (start,) = number_rows({"breakaway": [breakaway]})[0]
        speed, force = np.insert(speed, 0, 0.0), np.insert(force, 0, start)
        lowest = max(lowest + 1, 1) if force[lowest + 1] < start else 0
    note = "no uniform motion left of the minimum: f_1 cannot be drawn"
    if np.ptp(speed[: lowest + 1]) >= LEAST_APART:
        slope, static, *_ = stats.linregress(speed[: lowest + 1], force[: lowest + 1])
        if slope < 0.0:
            velocity = (float(coulomb) - static) / slope
            return AuxiliaryLines(float(static), float(coulomb), float(velocity), float(viscous))
        note = "the force does not fall left of the minimum: f_1 cannot be drawn"
    return AuxiliaryLines(math.nan, float(coulomb), math.nan, float(viscous), note)
