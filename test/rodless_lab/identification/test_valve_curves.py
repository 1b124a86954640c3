# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Area and flow coefficient from measured flow, eqs. (4), (5), (23), (25)."""

from collections.abc import Callable

import numpy as np
import pytest

from rodless_lab.identification.valve_bench.area_curve import (
    effective_area,
    fit_area_curve,
    three_sines,
)
from rodless_lab.identification.valve_bench.flow_coefficient import (
    fit_flow_coefficient,
    flow_coefficient,
)
from rodless_sim import RigParameters

PAPER = RigParameters()
COEFFICIENTS = PAPER.numbers("valve.area_coefficients")
VOLTAGES = np.linspace(0.0, 10.0, 101)
AREAS = three_sines(COEFFICIENTS, VOLTAGES)


def test_effective_area_by_hand() -> None:
    """Eq. (4) in kPa: 100 L/min at 601.325 kPa and 293.15 K is 1.390 mm²."""
    # 100 / (0.124 * 601.325) * sqrt(293.15 / 273) = 1.34112 * 1.03625 = 1.38974
    area = effective_area(np.array(100.0 / 6e4), np.array(601325.0), np.array(293.15))
    assert float(area) == pytest.approx(1.38974e-6, rel=1e-5)


def test_three_sines_by_hand() -> None:
    """Eq. (5) at 0 V: 2.108 sin 0.1742 + 2.012 sin 2.157 - 0.0933 sin 0.9104 = 1.9678 mm²."""
    # 0.365359 + 1.676090 - 0.073684
    assert float(three_sines(COEFFICIENTS, np.array(0.0))) == pytest.approx(1.96777e-6, rel=1e-4)


def test_coefficients_come_back_from_exact_areas() -> None:
    """Without noise the search, told nothing, finds all nine printed coefficients."""
    fit = fit_area_curve(VOLTAGES, AREAS)
    assert fit.values == pytest.approx(COEFFICIENTS, rel=1e-6)


def test_noisy_areas_give_the_curve_and_admit_what_they_leave_open() -> None:
    """0.01 mm² of noise: the curve is within its band, but the sines are interchangeable.

    No coefficient is claimed with an interval that misses the printed one.
    """
    generator = np.random.default_rng(11)
    voltages, areas = np.tile(VOLTAGES, 6), np.tile(AREAS, 6)
    fit = fit_area_curve(voltages, areas + generator.normal(0.0, 1e-8, areas.shape))
    apart = np.abs(fit.area(VOLTAGES) - AREAS)
    assert np.mean(apart <= fit.band(VOLTAGES)) > 0.9
    assert apart.max() < 0.01e-6
    assert fit.scatter == pytest.approx(1e-8, rel=0.1)
    assert not all(estimate.informed for estimate in fit.coefficients)
    assert "interchangeable" in next(
        estimate.note for estimate in fit.coefficients if not estimate.informed
    )


def test_too_few_points_for_nine_coefficients() -> None:
    """Nine coefficients from nine points would be a fit to noise."""
    with pytest.raises(ValueError, match=r"^9 points refused, a curve of three sines needs 10 or"):
        fit_area_curve(VOLTAGES[:9], AREAS[:9])


@pytest.mark.parametrize("fit", [fit_area_curve, fit_flow_coefficient])
def test_points_that_are_none_are_named(fit: Callable[..., object]) -> None:
    """NaN, columns of two lengths, texts and tables: one line with name and place."""
    good = np.linspace(0.1, 4.9, 50)
    for first, second, said in (
        (good, np.full(50, np.nan), r"^\w+: value 0 is nan, must be finite$"),
        (np.where(good > 4.0, np.inf, good), good, r"^\w+: value 40 is inf, must be finite$"),
        (good, good[:40], r"^\w+: 40 values for 50 \w+$"),
        (good, np.ones((50, 1)), r"^\w+: of shape \(50, 1\), must be one after the other, \(n,\)$"),
        (good, ["much"] * 50, r"^\w+ .* refused: must be numbers"),
        (3.0, 3.0, r"^\w+: of shape \(\), must be"),
    ):
        with pytest.raises(ValueError, match=said) as refusal:
            fit(first, second)
        assert "\n" not in str(refusal.value)


def test_flow_coefficient_by_hand() -> None:
    """Eq. (23): a choked ideal nozzle has C_v 1: 1 mm² at 601.325 kPa and 297 K passes 1.4101 g/s.

    0.68473 * 601325 * 1e-6 / sqrt(287.05 * 297) = 0.411745 / 291.985 = 1.41016e-3 kg/s.
    """
    found = flow_coefficient(np.array(1.41016e-3), np.array(601325.0), np.array(1e-6), 297.0)
    assert float(found) == pytest.approx(1.0, rel=1e-4)


def test_polynomial_comes_back_within_its_intervals() -> None:
    """Eq. (25) from C_v with 0.5 % of noise on both sides of closed; six intervals hold."""
    coefficients = np.array(PAPER.numbers("valve.flow_coefficients"))
    deflection = np.concatenate([np.linspace(-5.0, -0.1, 150), np.linspace(0.1, 4.9, 150)])
    exact = np.polynomial.Polynomial(coefficients)(np.abs(deflection))
    assert fit_flow_coefficient(deflection, exact).values == pytest.approx(coefficients, rel=1e-6)
    inside = []
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(1.0, 5e-3, exact.shape)
        fit = fit_flow_coefficient(deflection, exact * noise)
        inside.append(
            [found.covers(true) for found, true in zip(fit.coefficients, coefficients, strict=True)]
        )
    # 95 % of 40 is 38; four standard deviations below is 32.
    assert np.sum(inside, axis=0).min() >= 32
