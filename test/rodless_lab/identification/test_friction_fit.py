# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Fits of eq. (29) on points computed by hand from Table 2, and on runs of the rig."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rodless_lab.identification.estimate import Estimate, unknown
from rodless_lab.identification.friction.auxiliary_lines import auxiliary_lines
from rodless_lab.identification.friction.curve import (
    Stribeck,
    friction_force,
    has_unstable_branch,
    turning_points,
)
from rodless_lab.identification.friction.findings import friction_findings
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit, fit_friction
from rodless_lab.identification.friction.form import FrictionForm
from rodless_lab.identification.friction.stick_slip import stick_slip_events
from rodless_lab.identification.friction.uniform_motion import position_noise, uniform_parts
from rodless_lab.identification.parameter_writer import parameter_text
from rodless_sim import RigParameters, simulate

FORWARD = Stribeck(29.0, 12.0, 1.3e-3, 4500.0)
REVERSE = Stribeck(36.0, 12.5, 3.6e-3, 4800.0)
FAST = np.linspace(4e-3, 40e-3, 12)
RIG = RigParameters({"supply.pressure": 0.5e6 + 101325.0})


@pytest.mark.parametrize("curve", [FORWARD, REVERSE])
def test_turning_points_are_the_extremes_of_the_curve(curve: Stribeck) -> None:
    """A general-purpose minimiser finds the same maximum and minimum on either side."""
    ends = turning_points(curve)
    middle = 0.5 * (ends.hump_speed + ends.valley_speed)

    def force(speed: float) -> float:
        return float(friction_force(curve, np.array([speed]))[0])

    low = minimize_scalar(lambda v: -force(v), bounds=(0.0, middle), method="bounded")
    high = minimize_scalar(force, bounds=(middle, 5 * ends.valley_speed), method="bounded")
    assert ends.hump == pytest.approx(-low.fun, abs=1e-5)
    assert ends.valley == pytest.approx(high.fun, abs=1e-5)


def test_a_strong_viscous_term_hides_the_fall() -> None:
    """With B v_s above 0.86 (F_s - F_c) the curve rises throughout and cannot stick-slip."""
    assert has_unstable_branch(FORWARD)
    assert not has_unstable_branch(Stribeck(20.0, 12.0, 3.6e-3, 4800.0))
    ends = turning_points(Stribeck(20.0, 12.0, 3.6e-3, 4800.0))
    assert ends.hump == pytest.approx(ends.valley)


def test_uniform_runs_alone_do_not_inform_the_static_force() -> None:
    """Right of the minimum the drop is spent: F_c and B are found, F_s and v_s are not claimed."""
    fit = fit_friction(FAST, friction_force(FORWARD, FAST), force_errors=0.05).forward
    assert fit.coulomb.value == pytest.approx(12.0, abs=0.05)
    assert fit.viscous.value == pytest.approx(4500.0, rel=2e-3)
    assert not fit.static.informed
    assert not fit.stribeck_velocity.informed
    assert "Stribeck minimum" in fit.static.note


def test_four_points_of_a_bent_curve_are_too_few_not_another_friction() -> None:
    """The rig's own saturating curve at four speeds: not told, and no verdict against its form."""
    rig = RigParameters.preset("calibrated")
    form = FrictionForm.of(rig)
    speeds = np.array([6.4e-3, 12.7e-3, 14.0e-3, 30.9e-3])
    forces = form.force(REVERSE, speeds)
    few = fit_friction(-speeds, -forces, force_errors=0.05, form=form)
    assert not few.reverse.viscous.informed
    assert "too few" in few.reverse.viscous.note
    assert few.verdict.fits
    # Where there are enough, a form that is not theirs does not fit.
    more = np.linspace(4e-3, 60e-3, 12)
    wrong = fit_friction(-more, -form.force(REVERSE, more), force_errors=0.05)
    assert not wrong.verdict.fits


def test_breakaways_and_stops_inform_the_rest() -> None:
    """With the curve's maximum and minimum added, all four values of Table 2 are recovered."""
    ends = turning_points(FORWARD)
    fit = fit_friction(
        FAST,
        friction_force(FORWARD, FAST),
        breakaways=[ends.hump] * 2,
        stops=[ends.valley] * 2,
        force_errors=0.05,
    ).forward
    found = (fit.static, fit.coulomb, fit.stribeck_velocity, fit.viscous)
    assert all(estimate.informed for estimate in found)
    assert [estimate.value for estimate in found] == pytest.approx(list(FORWARD), rel=1e-4)


def test_directions_are_fitted_apart_with_magnitudes() -> None:
    """Signed points of both directions: reverse values come out positive, as the rig takes them."""
    speeds = np.concatenate([FAST, -FAST])
    forces = np.concatenate([friction_force(FORWARD, FAST), -friction_force(REVERSE, FAST)])
    slow = np.linspace(3e-4, 3e-3, 10)
    fit = fit_friction(
        np.concatenate([speeds, -slow]),
        np.concatenate([forces, -friction_force(REVERSE, slow)]),
        force_errors=0.05,
    )
    assert fit.reverse.static.value == pytest.approx(36.0, rel=1e-3)
    assert fit.reverse.stribeck_velocity.value == pytest.approx(3.6e-3, rel=1e-3)
    assert fit.forward.viscous.value == pytest.approx(4500.0, rel=2e-3)


def test_one_wild_point_does_not_move_the_fit() -> None:
    """Robust: a point 60 N off among twelve moves B by less than a percent."""
    forces = friction_force(FORWARD, FAST)
    forces[5] += 60.0
    fit = fit_friction(FAST, forces, force_errors=0.05).forward
    assert fit.viscous.value == pytest.approx(4500.0, rel=0.01)


def test_too_few_points_say_so() -> None:
    """Two points determine nothing worth an interval."""
    fit = fit_friction([5e-3, 9e-3], [34.5, 52.5])
    assert not fit.forward.viscous.informed
    assert "fewer than three" in fit.forward.viscous.note
    assert not fit.reverse.viscous.informed


def test_points_that_are_not_finite_are_refused() -> None:
    """NaN among the forces is an error, not a fit."""
    with pytest.raises(ValueError, match="finite"):
        fit_friction([1e-3, 2e-3, 3e-3], [1.0, np.nan, 2.0])


def test_auxiliary_lines_by_hand() -> None:
    """Points on two straight lines: f_1 from 30 N falling 5 N per mm/s, f_2 10 N + 4 N per mm/s.

    f_1 meets 10 N at 4 mm/s.
    """
    speeds = np.array([0.5, 1.0, 2.0, 6.0, 8.0, 10.0, 12.0]) * 1e-3
    forces = np.array([27.5, 25.0, 20.0, 34.0, 42.0, 50.0, 58.0])
    lines = auxiliary_lines(speeds, forces)
    assert lines.static == pytest.approx(30.0)
    assert lines.coulomb == pytest.approx(10.0)
    assert lines.viscous == pytest.approx(4000.0)
    assert lines.stribeck_velocity == pytest.approx(4e-3)


def test_auxiliary_lines_without_slow_points() -> None:
    """Where nothing lies left of the minimum f_1 cannot be drawn, and the result says so."""
    lines = auxiliary_lines(FAST, friction_force(FORWARD, FAST))
    assert np.isnan(lines.static)
    assert "f_1 cannot be drawn" in lines.note
    assert lines.viscous == pytest.approx(4500.0, rel=1e-6)


def test_uniform_part_is_found_in_a_real_run() -> None:
    """5.4 V: after breakaway the carriage creeps at 6.5 to 7 mm/s; the rig's own speed agrees."""
    run = simulate(RIG, np.full(6000, 5.4), 1e-3, position=0.02)
    part = uniform_parts(run.time, run.position).longest
    assert part.end - part.start > 1.0
    assert part.speed == pytest.approx(part.mean(run.velocity), rel=1e-3)
    assert part.mean(run.force) == pytest.approx(12.0 + 4500.0 * part.speed, abs=0.1)


@pytest.mark.parametrize("place", [0.0, 0.058])
def test_a_carriage_that_stands_is_not_uniform_motion(place: float) -> None:
    """Readings of one and the same number throughout, 0 too, are a carriage that never moves."""
    found = uniform_parts(np.arange(4000) * 1e-3, np.full(4000, place))
    assert not found.parts
    assert "never moves" in found.reason


@pytest.mark.parametrize(
    ("voltage", "reason"), [(5.26, "stick-slip"), (5.1, "the carriage never moves")]
)
def test_runs_without_uniform_motion_say_why(voltage: float, reason: str) -> None:
    """5.26 V sticks and slips, 5.1 V does not even break away."""
    run = simulate(RIG, np.full(8000, voltage), 1e-3, position=0.02)
    found = uniform_parts(run.time, run.position)
    assert not found.parts
    assert reason in found.reason
    with pytest.raises(ValueError, match=reason):
        _ = found.longest


def test_noise_is_measured_whatever_the_motion() -> None:
    """20 µm on an accelerating carriage that also jumps: found within 5 %."""
    time = np.arange(20_000) * 1e-3
    smooth = 0.01 * time + 2e-3 * time**2 + np.where(time > 10.0, 5e-3, 0.0)
    noisy = smooth + np.random.default_rng(1).normal(0.0, 20e-6, len(time))
    assert position_noise(noisy) == pytest.approx(20e-6, rel=0.05)


def test_breakaways_and_stops_of_a_stick_slip_run_are_the_curves_extremes() -> None:
    """At 5.26 V the force swings between the curve's maximum, 29.51 N, and minimum, 22.56 N.

    Inertia lets it overshoot by no more than 0.1 N.
    """
    run = simulate(RIG, np.full(8000, 5.26), 1e-3, position=0.02)
    events = stick_slip_events(run.time, run.position, run.force)
    assert len(events.breakaways) >= 3
    assert len(events.stops) >= 3
    assert events.breakaways == pytest.approx(29.51, abs=0.12)
    assert events.stops == pytest.approx(22.56, abs=0.12)
    assert np.all(np.diff(events.breakaway_times) > 0.5)


@pytest.mark.parametrize(("static", "coulomb"), [(10.7, 10.7), (29.0, None)])
def test_a_weak_rig_whose_coulomb_friction_is_open_has_a_file_that_loads(
    static: float, coulomb: float | None
) -> None:
    """The default F_c may be above the F_s found, which a plant refuses: set to that, with a note.

    Elsewhere it stays open.
    """
    known, still = partial(Estimate, unit="N"), np.empty(0)
    one = DirectionFit(
        known(static, static - 0.1, static + 0.1),
        unknown("N", "open within half its value"),
        Estimate(0.01, 0.009, 0.011, "m/s"),
        Estimate(60.0, 59.0, 61.0, "N s/m"),
        None,
        *(still,) * 4,
    )
    findings = friction_findings(FrictionFit(one, one), RigParameters())
    values = {found.name: found.value for found in findings}
    for side in ("forward", "reverse"):
        assert values[f"friction.{side}.static"] == static
        assert values[f"friction.{side}.coulomb"] == coulomb
    text = parameter_text([], findings)
    assert ("open within half its value; set to F_s" in text) is (coulomb is not None)


def test_friction_loads_on_top_of_its_base() -> None:
    """Told one of F_s and F_c alone: a base whose other one would contradict it gets that, too.

    F_c of 25 N is below the F_s of the paper and above that of a base with 20 N; F_s of 29 N is
    above the F_c of the paper and below that of a base with 30 N.
    """
    still, found = np.empty(0), Estimate(0.01, 0.009, 0.011, "")
    told = {value: Estimate(value, value - 0.1, value + 0.1, "N") for value in (25.0, 29.0)}
    for weak, (static, coulomb), base in (
        ("F_s", (unknown("N", "open"), told[25.0]), {"static": 20.0, "coulomb": 10.0}),
        ("F_c", (told[29.0], unknown("N", "open")), {"static": 40.0, "coulomb": 30.0}),
    ):
        one = DirectionFit(static, coulomb, found, found, None, *(still,) * 4)
        sides = {
            f"friction.{side}.{n}": v for side in ("forward", "reverse") for n, v in base.items()
        }
        below = RigParameters(sides)
        values = {
            finding.name: finding.value
            for finding in friction_findings(FrictionFit(one, one), below)
            if finding.value is not None
        }
        for loaded in (below.with_values(values), RigParameters(values)):
            assert loaded["friction.forward.static"] >= loaded["friction.forward.coulomb"], weak
        assert values["friction.reverse.static"] == values["friction.reverse.coulomb"], weak
