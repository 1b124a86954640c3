# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A number found from data, with the interval it is known to."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import linalg, stats

Array = npt.NDArray[np.float64]

CONFIDENCE = 0.95

# A value known no better than to this share of itself is not worth loading into a plant.
LARGEST_RELATIVE_HALF_WIDTH = 0.5

ENDLESS = "the points are as well met by any other value"


@dataclass(frozen=True)
class Estimate:
    """A value and its 95 % confidence interval, both in ``unit``.

    ``informed`` is false where the data does not determine the value; ``note`` then says why, and
    ``value`` is NaN unless the data at least suggests one.

    Examples
    --------
    >>> found = Estimate(12.1, 11.8, 12.4, "N")
    >>> str(found), found.covers(12.0)
    ('12.1 N (11.8 to 12.4)', True)
    """

    value: float
    low: float
    high: float
    unit: str
    informed: bool = True
    note: str = ""

    @property
    def half_width(self) -> float:
        """Half the length of the interval, in ``unit``."""
        return 0.5 * (self.high - self.low)

    def covers(self, truth: float) -> bool:
        """Whether ``truth`` lies within the interval."""
        return self.low <= truth <= self.high

    def widened(self, systematic: float, note: str = "") -> "Estimate":
        """Return the estimate with the bound of a systematic error (in ``unit``) added.

        A bound has no distribution to combine with the noise, so the two add up; ``note`` is added
        to what is noted already.
        """
        return replace(
            self,
            low=self.low - systematic,
            high=self.high + systematic,
            note="; ".join(filter(None, (self.note, note))),
        )

    def __str__(self) -> str:
        if not self.informed:
            return f"not informed: {self.note}"
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.value:.6g}{unit} ({self.low:.6g} to {self.high:.6g})"


def unknown(unit: str, note: str) -> Estimate:
    """Return an estimate of which the data says nothing, for the reason ``note``."""
    return Estimate(math.nan, -math.inf, math.inf, unit, False, note)


def symmetric(value: float, error: float, freedom: float, unit: str) -> Estimate:
    """Return an estimate from its standard error and the degrees of freedom behind that.

    One whose interval has no end is not informed.
    """
    half = error * float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, max(freedom, 1.0)))
    if not math.isfinite(half):
        return Estimate(value, -math.inf, math.inf, unit, False, ENDLESS)
    return Estimate(value, value - half, value + half, unit)


def covariance(jacobian: Array, variance: float) -> Array:
    """Return the covariance (p, p) of least-squares parameters from the Jacobian (n, p).

    ``variance`` is that of the residuals. A direction the data does not inform gets an infinite
    variance instead of a pseudo-inverse's zero.
    """
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    _, singular, rows = linalg.svd(jacobian / scale, full_matrices=False)
    threshold = np.finfo(float).eps * max(jacobian.shape) * singular[0]
    blind = singular <= threshold
    weights = np.where(blind, 0.0, 1.0 / np.where(blind, 1.0, singular))
    known = (rows.T * weights**2) @ rows * variance / np.outer(scale, scale)
    if blind.any():
        affected = np.any(np.abs(rows[blind]) > 1e-6, axis=0)
        known[affected, affected] = math.inf
    return np.asarray(known)


def judged(estimate: Estimate, note: str) -> Estimate:
    """Return ``estimate``, marked as not informed for ``note`` where its interval is too wide."""
    half = estimate.half_width
    if math.isfinite(half) and half <= LARGEST_RELATIVE_HALF_WIDTH * abs(estimate.value):
        return estimate
    return replace(estimate, informed=False, note=note)


def within(estimate: Estimate, low: float, high: float) -> Estimate:
    """Return ``estimate`` cut at the range from ``low`` to ``high``, and marked so.

    Where none of its interval lies within, the data informs of nothing that can be; where its
    interval holds all of the range, of nothing at all.
    """
    if not estimate.informed:
        return estimate
    if estimate.low <= low and estimate.high >= high:
        note = f"the run leaves all of its range open, {low:g} to {high:g} {estimate.unit}"
        return replace(estimate, informed=False, note=note.rstrip())
    if estimate.high < low or estimate.low > high:
        note = (
            f"fits best with {estimate}, and can be from {low:g} to {high:g} {estimate.unit} only"
        )
        return replace(estimate, informed=False, note=note.replace("  ", " "))
    notes = [
        f"cut at the {side} bound of its range, {end:g} {estimate.unit}".rstrip()
        for side, end, beyond in (
            ("lower", low, estimate.low < low),
            ("upper", high, estimate.high > high),
        )
        if beyond
    ]
    notes = [note for note in notes if note not in estimate.note]
    return replace(
        estimate,
        value=min(max(estimate.value, low), high),
        low=max(estimate.low, low),
        high=min(estimate.high, high),
        note="; ".join(filter(None, (estimate.note, *notes))),
    )
