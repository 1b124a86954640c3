# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Flow coefficient of the valve from measured mass flow, eq. (23), and its polynomial, eq. (25)."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rodless_base.number_rows import number_rows
from rodless_lab.identification.estimate import Estimate, covariance, symmetric
from rodless_lab.identification.valve_bench.points import check_opened, check_points
from rodless_lab.identification.verdict import Verdict, whiteness
from rodless_sim.physics.air import choked_nozzle_function

Array = npt.NDArray[np.float64]

# The polynomial of eq. (25) has degree 5.
DEGREE = 5


def flow_coefficient(
    mass_flow: Array,
    supply_pressure: Array,
    area: Array,
    temperature: float,
    gas_constant: float = 287.05,
    isentropic_index: float = 1.4,
) -> Array:
    """Flow coefficient C_v by eq. (23) from a choked mass flow in kg/s (Port 4 plus Port 5).

    ``supply_pressure`` in Pa absolute, ``area`` in m², ``temperature`` in K; shapes (n,) or
    scalars.

    Examples
    --------
    >>> nozzle = flow_coefficient(np.array(1.41016e-3), np.array(601325.0), np.array(1e-6), 297.0)
    >>> round(float(nozzle), 4)
    1.0
    """
    ideal = np.asarray(supply_pressure) * np.asarray(area) / np.sqrt(gas_constant * temperature)
    return np.asarray(mass_flow / (ideal * choked_nozzle_function(isentropic_index)))


@dataclass(frozen=True)
class FlowCoefficientCurve:
    """Polynomial of the deflection in V: coefficients in 1/V^k, constant first, and the scatter.

    ``verdict`` says whether the points lie about it without a pattern.
    """

    coefficients: tuple[Estimate, ...]
    scatter: float
    verdict: Verdict = field(default_factory=lambda: Verdict(()))

    @property
    def values(self) -> tuple[float, ...]:
        """The coefficients as the parameter ``valve.flow_coefficients`` takes them."""
        return tuple(estimate.value for estimate in self.coefficients)

    def coefficient(self, deflection: Array) -> Array:
        """C_v at ``deflection`` (V from the closed position, either side), shape (n,)."""
        powers = np.vander(np.abs(deflection), DEGREE + 1, increasing=True)
        return np.asarray(powers @ np.array(self.values))


def fit_flow_coefficient(
    deflections: npt.ArrayLike, coefficients: npt.ArrayLike, weights: npt.ArrayLike | None = None
) -> FlowCoefficientCurve:
    """Fit eq. (25) to C_v measured at ``deflections`` (V from the closed position), shape (n,).

    The argument is the distance from the closed position, the same to either side. ``weights``
    are reciprocal standard errors up to a common factor: near the closed position C_v divides two
    small numbers. A point whose weight is 0 is left out. Raises ValueError for fewer than seven
    points, or at fewer than six distances, for weights below 0, C_v that are all 0, and for what
    are no finite numbers.

    Examples
    --------
    >>> deflections = np.linspace(0.1, 4.9, 50)
    >>> curve = fit_flow_coefficient(deflections, 1.1 - 0.01 * deflections)
    >>> round(curve.values[0], 6), round(curve.values[1], 6)
    (1.1, -0.01)
    """
    columns = {"deflections": deflections, "coefficients": coefficients}
    if weights is not None:
        columns["weights"] = weights
    rows = number_rows(columns)
    if weights is None:
        rows.append(np.ones_like(rows[0]))
    distance, values, weight = _weighed(*rows)
    base = np.vander(distance, DEGREE + 1, increasing=True) * weight[:, None]
    found = _least_squares(base, values * weight)
    freedom = len(distance) - DEGREE - 1
    residual = values * weight - base @ found
    variance = float(residual @ residual) / max(freedom, 1)
    errors = np.sqrt(np.diag(covariance(base, variance)))
    units = [f"1/V^{power}" if power else "" for power in range(DEGREE + 1)]
    estimates = tuple(
        symmetric(float(value), float(error), freedom, unit)
        for value, error, unit in zip(found, errors, units, strict=True)
    )
    order = np.argsort(distance, kind="stable")
    size = float(np.max(np.abs(values * weight)))
    verdict = whiteness(residual[order], base[order], size)
    return FlowCoefficientCurve(estimates, variance**0.5, verdict)


def _weighed(deflection: Array, values: Array, weight: Array) -> tuple[Array, Array, Array]:
    """Return distance, C_v and weight of the points that have one; raises ValueError."""
    if np.any(weight < 0.0):
        raise ValueError(f"weights: {float(weight.min()):g} refused, must not be negative")
    counts = weight > 0.0
    distance = np.abs(deflection[counts])
    check_points("deflections", distance, DEGREE + 1, f"a polynomial of degree {DEGREE}")
    check_opened("coefficients", values[counts])
    return distance, values[counts], weight[counts]


def _least_squares(base: Array, wanted: Array) -> Array:
    """Return the coefficients (p,) of the columns of ``base`` (n, p), whatever their sizes."""
    scale = np.linalg.norm(base, axis=0)
    scale[scale == 0.0] = 1.0
    found, *_ = np.linalg.lstsq(base / scale, wanted, rcond=None)
    return np.asarray(found / scale)
