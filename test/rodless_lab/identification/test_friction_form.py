# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Friction is identified in the form of the base, and another form's points are not followed."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rodless_lab.identification.friction.curve import Stribeck, turning_points
from rodless_lab.identification.friction.fit import fit_friction
from rodless_lab.identification.friction.form import PRINTED, FrictionForm
from rodless_sim import RigParameters
from rodless_sim.physics.friction import FORMS

CURVE = Stribeck(29.0, 12.0, 1.3e-3, 4500.0)
SATURATING = FrictionForm.of(RigParameters({"friction.form": "saturating"}))
SPEEDS = np.concatenate([np.linspace(3e-3, 12e-3, 8), np.linspace(15e-3, 60e-3, 8)])


def saturating_by_hand(curve: Stribeck, speed: np.ndarray) -> np.ndarray:
    """F_c + (F_s − F_c) exp(−(v/v_s)²) + B_2 v + (B − B_2) v_k (1 − exp(−v/v_k)), 80 and 5 mm/s."""
    dry = curve.coulomb + (curve.static - curve.coulomb) * np.exp(
        -((speed / curve.stribeck_velocity) ** 2)
    )
    return dry + 80.0 * speed + (curve.viscous - 80.0) * 5e-3 * (1.0 - np.exp(-speed / 5e-3))


def test_the_curve_is_the_plants() -> None:
    """The saturating form written out again agrees to rounding."""
    found = SATURATING.force(CURVE, SPEEDS)
    np.testing.assert_allclose(found, saturating_by_hand(CURVE, SPEEDS), rtol=1e-12)


def test_its_turning_points_are_the_extremes() -> None:
    """A general-purpose minimiser finds the same maximum and minimum."""
    ends = SATURATING.turning_points(CURVE)
    middle = 0.5 * (ends.hump_speed + ends.valley_speed)

    def force(speed: float) -> float:
        return float(saturating_by_hand(CURVE, np.array([speed]))[0])

    low = minimize_scalar(lambda v: -force(v), bounds=(0.0, middle), method="bounded")
    high = minimize_scalar(force, bounds=(middle, 3 * ends.valley_speed), method="bounded")
    assert ends.hump == pytest.approx(-low.fun, abs=1e-3)
    assert ends.valley == pytest.approx(high.fun, abs=1e-3)


def test_eq_29_keeps_its_closed_form() -> None:
    """The printed form's turning points are those of Lambert's function."""
    assert PRINTED.turning_points(CURVE) == turning_points(CURVE)
    assert FORMS[PRINTED.code].NAME == "stribeck"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_saturating_rig_is_found_from_a_base_that_saturates(side: float) -> None:
    """All four values come back within 1 %, and the verdict is that the form fits."""
    ends = SATURATING.turning_points(CURVE)
    noise = np.random.default_rng(1).normal(0.0, 0.05, SPEEDS.shape)
    found = fit_friction(
        side * SPEEDS,
        side * (saturating_by_hand(CURVE, SPEEDS) + noise),
        force_errors=0.05,
        breakaways=[side * ends.hump] * 2,
        stops=[side * ends.valley] * 2,
        form=SATURATING,
    )
    fit = found.forward if side > 0.0 else found.reverse
    values = (fit.static, fit.coulomb, fit.stribeck_velocity, fit.viscous)
    assert [value.value for value in values] == pytest.approx(list(CURVE), rel=0.01)
    assert found.verdict.fits


def test_a_saturating_rig_is_not_followed_by_eq_29() -> None:
    """The same points taken for eq. (29): the verdict says that the form does not fit."""
    found = fit_friction(SPEEDS, saturating_by_hand(CURVE, SPEEDS), force_errors=0.05)
    assert not found.verdict.fits
    assert "forward" in str(found.verdict)


def test_right_points_raise_no_alarm() -> None:
    """Noise as stated about eq. (29), 20 sets: at most one is refused."""
    forces = 12.0 + 17.0 * np.exp(-((SPEEDS / 1.3e-3) ** 2)) + 4500.0 * SPEEDS
    refused = 0
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 0.05, SPEEDS.shape)
        refused += not fit_friction(SPEEDS, forces + noise, force_errors=0.05).verdict.fits
    assert refused < 2
