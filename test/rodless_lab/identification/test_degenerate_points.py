# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Points that determine nothing inform of nothing: refused, or said so."""

import math
import warnings
from collections.abc import Callable

import numpy as np
import pytest

from rodless_lab.identification import fit_area_curve, fit_flow_coefficient, fit_friction
from rodless_lab.identification.estimate import symmetric
from rodless_lab.identification.verdict import whiteness

VOLTS = np.linspace(0.1, 4.9, 30)
SPEEDS = np.linspace(4e-3, 40e-3, 12)

FEW = r"^{0}: {1} different refused, a \w.* needs \d or more$"


@pytest.mark.parametrize(
    ("fit", "name", "unknowns"),
    [(fit_flow_coefficient, "deflections", 6), (fit_area_curve, "voltages", 9)],
)
def test_points_that_leave_the_curve_open_are_refused(
    fit: Callable[..., object], name: str, unknowns: int
) -> None:
    """At fewer places than the curve has coefficients, or no more points than those."""
    for places in (1, 2, unknowns - 1):
        few = np.resize(np.linspace(1.0, 4.0, places), 50)
        with pytest.raises(ValueError, match=FEW.format(name, places)):
            fit(few, 1e-7 * (1.0 + few))
    spread = np.linspace(1.0, 4.0, unknowns)
    with pytest.raises(
        ValueError, match=rf"^{unknowns} points refused, .* needs {unknowns + 1} or"
    ):
        fit(spread, 1e-7 * (1.0 + spread))
    fit(np.tile(spread, 2), 1e-7 * (1.0 + np.tile(spread, 2)))


@pytest.mark.parametrize("fit", [fit_flow_coefficient, fit_area_curve])
def test_a_valve_that_lets_nothing_through_has_no_curve(fit: Callable[..., object]) -> None:
    """Areas, or flow coefficients, that are all 0."""
    with pytest.raises(ValueError, match=r"^(coefficients|areas): all 0 refused, nothing flowed"):
        fit(VOLTS, np.zeros(30))


def test_both_sides_of_the_valve_are_one_place() -> None:
    """The polynomial is of the distance: five to either side are five."""
    both = np.concatenate([-np.arange(1.0, 6.0), np.arange(1.0, 6.0)])
    with pytest.raises(ValueError, match=FEW.format("deflections", 5)):
        fit_flow_coefficient(both, 1.0 + 0.01 * both)


def test_points_without_a_weight_are_none() -> None:
    """All of weight 0, or all but five, leave nothing to fit."""
    for weights, left in ((np.zeros(30), 0), (np.arange(30) < 5, 5)):
        with pytest.raises(ValueError, match=rf"^{left} points refused, a polynomial of degree 5"):
            fit_flow_coefficient(VOLTS, 1.1 - 0.01 * VOLTS, 1.0 * weights)


def test_points_too_close_to_tell_apart_inform_of_nothing() -> None:
    """Places that differ by rounding alone are different, and say no more than one."""
    close = 1.0 + 1e-15 * np.arange(30)
    found = fit_flow_coefficient(close, np.cos(np.arange(30.0)))
    assert not any(estimate.informed for estimate in found.coefficients)


def test_a_constant_is_met_without_a_warning() -> None:
    """Of what is one and the same there is no scatter, and no verdict against it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fit_flow_coefficient(VOLTS, np.ones(30)).verdict.fits
        assert whiteness(np.zeros(30), VOLTS[:, None], 0.0).fits


def test_the_polynomial_is_found_at_any_scale_of_its_argument() -> None:
    """Within 5 mV of closed the fifth power is 1e-12 of the constant, and found all the same."""
    near = 1e-3 * VOLTS
    wanted = [1.0, 10.0, 1e5, 1e8, 1e10, 1e13]
    found = fit_flow_coefficient(near, np.polynomial.Polynomial(wanted)(near))
    assert found.values == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("error", [math.inf, math.nan])
def test_an_interval_without_an_end_informs_of_nothing(error: float) -> None:
    """Whatever the value is."""
    found = symmetric(3.0, error, 10.0, "N")
    assert not found.informed
    assert (found.low, found.high) == (-math.inf, math.inf)
    assert symmetric(3.0, 0.1, 10.0, "N").informed


@pytest.mark.parametrize("errors", [None, 0.1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_points_of_a_force_that_pushes_are_no_friction(errors: float | None, sign: float) -> None:
    """Against the motion in either direction; a slope below 0 alone is none, either."""
    pushing = fit_friction(sign * SPEEDS, -sign * (12.0 + 4500.0 * SPEEDS), force_errors=errors)
    side, name = (pushing.forward, "forward") if sign > 0.0 else (pushing.reverse, "reverse")
    for estimate in (side.static, side.coulomb, side.stribeck_velocity, side.viscous):
        assert not estimate.informed
    assert "and can be from 0 to" in side.coulomb.note
    assert "and can be from 0 to" in side.viscous.note
    said = f"the model does not fit: force that drives the carriage {name}"
    assert said in str(pushing.verdict)
    falling = fit_friction(sign * SPEEDS, sign * (12.0 - 100.0 * SPEEDS), force_errors=errors)
    side = falling.forward if sign > 0.0 else falling.reverse
    assert side.coulomb.informed
    assert not side.viscous.informed


def test_an_interval_of_all_that_can_be_informs_of_nothing() -> None:
    """Speeds too close to tell apart leave B, and with it F_c, anywhere from 0 to the largest."""
    speeds = 20e-3 + 1e-6 * np.arange(5)
    forces = 12.0 + 4500.0 * speeds
    found = fit_friction(speeds, forces, force_errors=5.0).forward
    assert not found.coulomb.informed
    assert not found.viscous.informed
    assert "the run leaves all of its range open, 0 to " in found.viscous.note
    told = fit_friction(np.linspace(10e-3, 50e-3, 5), forces, force_errors=5.0).forward
    assert told.viscous.informed


def test_bounds_that_points_share_widen_the_intervals() -> None:
    """A force by itself, a slope by its share; a push within the force's bound may be none."""
    forces = 12.0 + 4500.0 * SPEEDS
    plain = fit_friction(SPEEDS, forces, force_errors=0.1).forward
    wide = fit_friction(
        SPEEDS, forces, force_errors=0.1, force_bias=2.0, speed_stretch=0.01
    ).forward
    assert wide.coulomb.half_width == pytest.approx(plain.coulomb.half_width + 2.0)
    assert wide.viscous.half_width == pytest.approx(plain.viscous.half_width + 45.0, rel=1e-6)
    hidden = fit_friction(SPEEDS, forces - 13.0, force_errors=0.1, force_bias=2.0)
    assert hidden.forward.coulomb.informed
    assert hidden.verdict.fits
