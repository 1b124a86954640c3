# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The Stribeck curve of eq. (29) as a function to fit: its values and its turning points."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import lambertw

from rodless_base.number_rows import measured_numbers

Array = npt.NDArray[np.float64]


class Stribeck(NamedTuple):
    """Magnitudes for one direction."""

    static: float  # N, F_s
    coulomb: float  # N, F_c
    stribeck_velocity: float  # m/s, v_s
    viscous: float  # N·s/m, B


class TurningPoints(NamedTuple):
    """Where a rising force lets go and a falling one catches again.

    Between the two speeds the curve falls and no uniform motion is stable.
    """

    hump_speed: float  # m/s
    hump: float  # N
    valley_speed: float  # m/s
    valley: float  # N


def friction_force(curve: Stribeck, speed: Array) -> Array:
    """Friction in N at ``speed`` >= 0 (m/s), shape (n,), eq. (29).

    Raises ValueError for what are no numbers.

    Examples
    --------
    >>> curve = Stribeck(29.0, 12.0, 1.3e-3, 4500.0)
    >>> friction_force(curve, np.array([0.0, 0.02])).round(6).tolist()
    [29.0, 102.0]
    """
    return _force(curve, measured_numbers(speed, "speed"))


def _force(curve: Stribeck, speed: Array) -> Array:
    drop = (curve.static - curve.coulomb) * np.exp(-((speed / curve.stribeck_velocity) ** 2))
    return np.asarray(curve.coulomb + drop + curve.viscous * speed)


def turning_points(curve: Stribeck) -> TurningPoints:
    """Return the local maximum and minimum of eq. (29).

    Its slope is B at rest, so even breakaway is preceded by a creep, and the force that lets go
    exceeds F_s a little. Where viscous friction hides the fall altogether, both points are its
    inflection: :func:`has_unstable_branch` tells.

    Examples
    --------
    >>> ends = turning_points(Stribeck(29.0, 12.0, 1.3e-3, 4500.0))
    >>> round(ends.hump, 2), round(ends.valley, 2)
    (29.51, 22.56)
    """
    share = min(_steepness(curve), math.sqrt(0.5 / math.e))
    # x exp(-x²) = share  <=>  -2x² exp(-2x²) = -2 share²
    argument = max(-2.0 * share**2, -1.0 / math.e)
    hump, valley = (
        curve.stribeck_velocity * math.sqrt(max(-0.5 * lambertw(argument, branch).real, 0.0))
        for branch in (0, -1)
    )
    low, high = _force(curve, np.array([hump, valley]))
    return TurningPoints(hump, float(low), valley, float(high))


def has_unstable_branch(curve: Stribeck) -> bool:
    """Whether friction falls with speed anywhere, so that slow motion can stick and slip."""
    return _steepness(curve) < math.sqrt(0.5 / math.e)


def _steepness(curve: Stribeck) -> float:
    """B v_s / 2 (F_s - F_c): 0 for a steep fall, above 0.43 there is none."""
    drop = max(curve.static - curve.coulomb, 1e-9)
    return max(curve.viscous * curve.stribeck_velocity / (2.0 * drop), 1e-9)
