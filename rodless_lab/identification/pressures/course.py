# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the carriage was, from its noisy position: smoothed as far as the noise asks for."""

import math

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_coeffs, savgol_filter

from rodless_lab.identification.friction.uniform_motion import position_noise

Array = npt.NDArray[np.float64]

# Longest stretch in s over which position is smoothed, and how many shorter ones are tried.
LONGEST = 0.02
WIDTHS = 6

# Two estimates of a position are taken to differ by chance up to so many of their standard errors:
# the more, the more of a jerk is lost, 26 µm of one of 100 m/s² with 20 µm of noise; the fewer, the
# more of the noise is left, 7.5 µm where parabolas over the longest stretch leave 6.5 µm.
CHANCE = 1.5


def smoothed(position: Array, period: float) -> Array:
    """Return the carriage's ``position`` without as much of its noise as can be.

    ``position`` (m) has the shape (n,), or (runs, n) for several, each smoothed by itself.

    A local parabola about each sample, over the longest stretch on which it does not differ from
    those over all shorter ones by more than the noise explains (intersection of confidence
    intervals, Goldenshluger and Nemirovski 1997): long where the carriage moves smoothly, short
    where it jerks, none where there is no noise. Where the whole run moves no further than its
    noise, the carriage stands still.
    """
    noise = np.apply_along_axis(position_noise, -1, position)[..., np.newaxis]
    found: Array = position.copy()
    low, high = position - CHANCE * noise, position + CHANCE * noise
    for width in _widths(position.shape[-1], period):
        smooth = np.asarray(savgol_filter(position, width, 2))
        error = noise * math.sqrt(savgol_coeffs(width, 2)[width // 2])
        low = np.maximum(low, smooth - CHANCE * error)
        high = np.minimum(high, smooth + CHANCE * error)
        # An empty intersection stays empty.
        found = np.where(low <= high, smooth, found)
    stands = np.ptp(position, axis=-1, keepdims=True) < 12.0 * noise
    return np.where(stands, position.mean(axis=-1, keepdims=True), found)


def _widths(samples: int, period: float) -> list[int]:
    """Odd numbers of samples, from 5 up, no more than the run has."""
    most = max(round(LONGEST / period) // 2, 2)
    halves = np.unique(np.linspace(2, most, WIDTHS).round().astype(int))
    return [2 * half + 1 for half in halves.tolist() if 2 * half + 1 <= samples]
