# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Effective area of the valve from measured flow, eq. (4), and its three-sine curve, eq. (5)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import linalg, optimize, stats

from rodless_base.number_rows import measured_numbers, number_rows
from rodless_lab.identification.estimate import (
    CONFIDENCE,
    Estimate,
    covariance,
    judged,
    symmetric,
)
from rodless_lab.identification.valve_bench.points import check_opened, check_points
from rodless_lab.identification.verdict import Verdict, whiteness
from rodless_sim.physics.valve import scaled_amplitudes

Array = npt.NDArray[np.float64]

# Eq. (4) with P_u in kPa: L/min of free air per mm² and kPa, and its reference temperature in K.
FLOW_PER_AREA = 0.124
REFERENCE_TEMPERATURE = 273.0

LITRES_PER_MINUTE = 6e4
DEGENERATE = (
    "the sines are nearly interchangeable over 0-10 V; the curve is known far better than its "
    "coefficients"
)

# Units of amplitude, frequency and phase of each sine.
_UNITS = ("mm²", "rad/V", "rad") * 3

# Frequencies (rad/V) the search tries for the three sines; over a range of 10 V slower ones cannot
# be told from a straight line, faster ones from noise.
_FREQUENCIES = (0.15, 0.25, 0.35, 0.5, 0.7, 1.0, 1.3, 1.7, 2.2)

# Best combinations of them that are refined.
_REFINED = 6


def effective_area(volume_flow: Array, upstream_pressure: Array, temperature: Array) -> Array:
    """Effective area S in m² by eq. (4), whose pressure is in kPa, from a choked flow.

    ``volume_flow`` is in m³/s of free air, ``upstream_pressure`` in Pa absolute, ``temperature``
    (upstream) in K; shapes (n,) or scalars.

    Examples
    --------
    >>> area = effective_area(np.array(100.0 / 6e4), np.array(601325.0), np.array(293.15))
    >>> round(float(area) * 1e6, 3)  # mm²
    1.39
    """
    litres = np.asarray(volume_flow) * LITRES_PER_MINUTE
    kilopascals = np.asarray(upstream_pressure) * 1e-3
    root = np.sqrt(np.asarray(temperature) / REFERENCE_TEMPERATURE)
    return np.asarray(litres / (FLOW_PER_AREA * kilopascals) * root * 1e-6)


def three_sines(coefficients: npt.ArrayLike, voltage: Array) -> Array:
    """Eq. (5) in m² at ``voltage`` (V), shape (n,); nine coefficients in m², rad/V and rad.

    Raises ValueError for what are no numbers, or not nine.

    Examples
    --------
    >>> float(three_sines([2e-6, 0.5, 0.0, 0, 0, 0, 0, 0, 0], np.array(np.pi)))
    2e-06
    """
    return _sines(_nine("coefficients", coefficients), measured_numbers(voltage, "voltage"))


def _nine(name: str, coefficients: npt.ArrayLike) -> Array:
    (row,) = number_rows({name: coefficients})
    if len(row) != 9:
        raise ValueError(f"{name}: {len(row)} values, three sines have nine")
    return row


def _sines(coefficients: Array, voltage: Array) -> Array:
    amplitude, frequency, phase = coefficients.reshape(3, 3).T
    angle = np.multiply.outer(voltage, frequency) + phase
    return np.asarray(np.sum(amplitude * np.sin(angle), axis=-1))


@dataclass(frozen=True)
class AreaCurve:
    """Fitted eq. (5): nine coefficients in its order, and the scatter about it.

    The coefficients are the paper's, with amplitudes in mm². ``scatter`` is the standard deviation
    of a single point in m², ``freedom`` its degrees of freedom, ``voltages`` (V, shape (n,)) where
    the area was measured, and ``residuals`` (m²) how far it was from the curve there.
    """

    coefficients: tuple[Estimate, ...]
    scatter: float
    freedom: int
    voltages: Array
    residuals: Array

    @property
    def verdict(self) -> Verdict:
        """Whether the points lie about the curve without a pattern."""
        order = np.argsort(self.voltages, kind="stable")
        slopes = _jacobian(np.array(self._fitted), self.voltages[order])
        return whiteness(self.residuals[order], slopes, float(np.ptp(self.area(self.voltages))))

    @property
    def values(self) -> tuple[float, ...]:
        """The nine coefficients as ``valve.area_coefficients`` takes them: m², rad/V, rad."""
        return scaled_amplitudes(self._fitted, -6)

    @property
    def _fitted(self) -> tuple[float, ...]:
        return tuple(estimate.value for estimate in self.coefficients)

    def area(self, voltage: Array) -> Array:
        """Fitted area in m² at ``voltage`` (V)."""
        return three_sines(self.values, voltage)

    def band(self, voltage: Array) -> Array:
        """Half width in m² of the 95 % band about the fitted curve at ``voltage``, shape (n,)."""
        gradient = _jacobian(np.array(self._fitted), np.asarray(voltage)) * 1e-6
        measured = _jacobian(np.array(self._fitted), self.voltages) * 1e-6
        # Through the curve's own directions: combinations of coefficients that leave the curve
        # unchanged have no variance worth the name, and no effect here.
        _, singular, rows = linalg.svd(measured, full_matrices=False)
        seen = singular > 1e-10 * singular[0]
        share = gradient @ (rows[seen] / singular[seen, None]).T
        quantile = stats.t.ppf(0.5 + 0.5 * CONFIDENCE, max(self.freedom, 1))
        return np.asarray(quantile * self.scatter * np.sqrt(np.sum(share**2, axis=1)))


def fit_area_curve(
    voltages: npt.ArrayLike, areas: npt.ArrayLike, start: npt.ArrayLike | None = None
) -> AreaCurve:
    """Fit the three sines of eq. (5) to measured areas.

    Sines come in the order of amplitude, positive but for the last, as the paper writes them.

    Parameters
    ----------
    voltages, areas
        Shape (n,), V and m².
    start
        Nine coefficients to begin with, in m², rad/V and rad. Without, the search begins by
        itself: for given frequencies the curve is linear in the rest, so a coarse grid of
        frequencies is tried and the best refined.

    Raises
    ------
    ValueError
        For fewer than ten points, or at fewer than nine voltages, for areas that are all 0, and
        for what are no finite numbers.

    Examples
    --------
    >>> from rodless_sim import RigParameters
    >>> paper = RigParameters().numbers("valve.area_coefficients")
    >>> voltages = np.linspace(0.0, 10.0, 101)
    >>> bool(np.allclose(fit_area_curve(voltages, three_sines(paper, voltages)).values, paper))
    True
    """
    voltage, area = number_rows({"voltages": voltages, "areas": areas})
    check_points("voltages", voltage, len(_UNITS), "a curve of three sines")
    check_opened("areas", area)
    area = area * 1e6
    starts = _starts(voltage, area) if start is None else [_fitted(_nine("start", start))]
    found = min((_refined(begin, voltage, area) for begin in starts), key=lambda fit: fit[1])[0]
    if start is None:
        found = _ordered(found)
    return _curve(found, voltage, area)


def _fitted(coefficients: Array) -> Array:
    """Return coefficients with amplitudes in mm²: the unknowns are then all of one size."""
    return np.array(scaled_amplitudes(tuple(coefficients.tolist()), 6))


def _refined(start: Array, voltage: Array, area: Array) -> tuple[Array, float]:
    found = optimize.least_squares(
        _residuals,
        start,
        jac=_slopes,
        args=(voltage, area),
        method="lm",
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
        max_nfev=300,
    )
    return np.asarray(found.x), float(found.cost)


def _residuals(values: Array, voltage: Array, area: Array) -> Array:
    return _sines(values, voltage) - area


def _slopes(values: Array, voltage: Array, area: Array) -> Array:  # noqa: ARG001
    return _jacobian(values, voltage)


def _jacobian(values: Array, voltage: Array) -> Array:
    amplitude, frequency, phase = values.reshape(3, 3).T
    angle = np.multiply.outer(voltage, frequency) + phase
    slope = amplitude * np.cos(angle)
    columns = np.stack([np.sin(angle), slope * voltage[:, None], slope], axis=-1)
    return np.asarray(columns.reshape(len(voltage), 9))


def _starts(voltage: Array, area: Array) -> list[Array]:
    count = len(_FREQUENCIES)
    trials = []
    for i in range(count):
        for j in range(i + 1, count):
            for k in range(j + 1, count):
                frequency = np.array([_FREQUENCIES[i], _FREQUENCIES[j], _FREQUENCIES[k]])
                trials.append(_linear_fit(frequency, voltage, area))
    trials.sort(key=lambda trial: trial[1])
    return [trial[0] for trial in trials[:_REFINED]]


def _linear_fit(frequency: Array, voltage: Array, area: Array) -> tuple[Array, float]:
    """Amplitudes and phases for given frequencies: a sine is a sum of one sine and one cosine."""
    angle = np.multiply.outer(voltage, frequency)
    base = np.concatenate([np.sin(angle), np.cos(angle)], axis=1)
    weights, *_ = np.linalg.lstsq(base, area, rcond=1e-8)
    error = float(np.sum((base @ weights - area) ** 2))
    amplitude = np.hypot(weights[:3], weights[3:])
    phase = np.arctan2(weights[3:], weights[:3])
    return np.stack([amplitude, frequency, phase], axis=1).ravel(), error


def _ordered(values: Array) -> Array:
    """Write the same curve as the paper does."""
    sines = values.reshape(3, 3).copy()
    backwards = sines[:, 1] < 0.0
    sines[backwards] *= np.array([-1.0, -1.0, -1.0])
    sines = sines[np.argsort(-np.abs(sines[:, 0]))]
    wanted = np.array([1.0, 1.0, -1.0])
    turned = np.sign(sines[:, 0]) != wanted
    sines[turned, 0] *= -1.0
    sines[turned, 2] += np.pi
    sines[:, 2] = np.mod(sines[:, 2], 2.0 * np.pi)
    return np.asarray(sines.ravel())


def _curve(values: Array, voltage: Array, area: Array) -> AreaCurve:
    freedom = len(voltage) - 9
    residual = area - _sines(values, voltage)
    variance = float(residual @ residual) / max(freedom, 1)
    spread = covariance(_jacobian(values, voltage), variance)
    errors = np.sqrt(np.diag(spread))
    estimates = tuple(
        judged(symmetric(float(value), float(error), freedom, unit), DEGENERATE)
        for value, error, unit in zip(values, errors, _UNITS, strict=True)
    )
    return AreaCurve(estimates, variance**0.5 * 1e-6, freedom, voltage, residual * 1e-6)
