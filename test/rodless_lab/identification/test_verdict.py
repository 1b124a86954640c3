# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""The tests behind a verdict, on numbers whose distribution is known."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from scipy import stats

from rodless_lab.identification import fit_area_curve, fit_flow_coefficient, three_sines
from rodless_lab.identification.estimate import Estimate, unknown, within
from rodless_lab.identification.parameter_writer import Finding, parameter_text
from rodless_lab.identification.pressures.fit import Solution, estimates_of
from rodless_lab.identification.pressures.valve import valve_findings
from rodless_lab.identification.verdict import Check, Verdict, joined, power, tail
from rodless_sim import RigParameters

DRAWS, SAMPLES = 2000, 300


def white(seed: int) -> np.ndarray:
    """Draws of white numbers of variance 1."""
    return np.random.default_rng(seed).standard_normal((DRAWS, SAMPLES))


@pytest.mark.parametrize("excess", [1.0, 1.1, 1.25, 1.5])
def test_the_tail_is_that_of_chi_square(excess: float) -> None:
    """Mean squares of 300 white numbers: scipy's chi-square of 300 degrees, far into its tail."""
    found = tail(excess, power(white(1), 1))
    exact = stats.chi2.sf(excess * SAMPLES, SAMPLES)
    assert np.log10(found) == pytest.approx(np.log10(exact), abs=0.05 * abs(np.log10(exact)) + 0.1)


def test_what_is_slow_shows_in_means_over_a_block() -> None:
    """A wave of half the noise: mostly hidden in single numbers, plain in means of 30."""
    wave = 0.5 * np.sin(2.0 * np.pi * np.arange(SAMPLES) / 150.0)
    rows = white(2)[:100] + wave
    single = [tail(found, power(white(3), 1)) < 1e-3 for found in power(rows, 1)]
    blocks = [tail(found, power(white(3), 30)) < 1e-3 for found in power(rows, 30)]
    assert np.mean(single) < 0.3
    assert np.mean(blocks) > 0.8


def test_false_alarms_are_as_rare_as_stated() -> None:
    """Verdicts of three checks on white numbers: fewer than 2 in 100 are refused."""
    explained = [power(white(4), length) for length in (1, 10, 60)]
    refused = 0
    for row in white(5)[:1000]:
        pairs = zip((1, 10, 60), explained, strict=True)
        checks = [
            Check("", 0.0, 1.0, "", tail(float(power(row, length)), drawn))
            for length, drawn in pairs
        ]
        refused += not Verdict(tuple(checks)).fits
    assert refused < 20


def test_many_checks_are_corrected_for_their_number() -> None:
    """One in a hundred by chance among twenty is no alarm, and the worst one is named."""
    quiet = [Verdict((Check(f"check {k}", 1.0, 1.0, "Pa", 0.5),)) for k in range(19)]
    worst = Check("scatter", 3.0, 1.0, "Pa", 0.009)
    assert joined([*quiet, Verdict((worst,))]).fits
    alone = Verdict((worst,), "heat")
    assert not alone.fits
    said = "the model does not fit: scatter 3 Pa, explained 1 Pa; likely missing: heat"
    assert str(alone) == said
    assert Verdict(()).fits


def test_an_interval_that_leaves_the_range_is_cut_and_marked() -> None:
    """A leak of 1 ± 3 mm² cannot be negative: from 0, and the note says that it is a bound."""
    found = within(Estimate(1e-6, -2e-6, 4e-6, "m²"), 0.0, 1e-5)
    assert (found.low, found.high) == (0.0, 4e-6)
    assert found.note == "cut at the lower bound of its range, 0 m²"
    inside = Estimate(2e-6, 1e-6, 3e-6, "m²")
    assert within(inside, 0.0, 1e-5) == inside
    assert within(Estimate(-1e-6, -2e-6, 4e-6, "m²"), 0.0, 1e-5).value == 0.0


@pytest.mark.parametrize("value", [-5.0, 25.0])
def test_what_lies_outside_its_range_altogether_is_not_informed(value: float) -> None:
    """Neither a reversed interval, nor a bound that passes for a result."""
    found = within(Estimate(value, value - 1.0, value + 1.0, "N"), 0.0, 20.0)
    assert not found.informed
    interval = f"{value:g} N ({value - 1.0:g} to {value + 1.0:g})"
    assert found.note == f"fits best with {interval}, and can be from 0 to 20 N only"


@pytest.mark.parametrize("mean", [1.2003e6, 1.5e6])
def test_a_supply_above_what_a_plant_can_have_is_written_as_its_bound_or_not_at_all(
    mean: float,
) -> None:
    """Of 1.2003 MPa ± 0.8 kPa 1.2 MPa is left, of 1.5 MPa nothing; the plant loads the file."""
    # The last value is the bias of the supply's sensor, told to 1.2 kPa/√11 by ten readings and
    # what is stated of it.
    problem = SimpleNamespace(readings=10, supply=mean)
    jacobian, still = np.full((11, 1), 1e-3), np.zeros(10)
    solution = Solution(problem, RigParameters(), [], np.zeros(1), still, jacobian, 0.0, 1.0)  # type: ignore[arg-type]
    found = estimates_of(solution)["supply.pressure"]
    assert found.informed == (mean < 1.5e6)
    value = found.value if found.informed else None
    text = parameter_text([], [Finding("supply.pressure", value, {"P_s": found})])
    (loaded,) = yaml.safe_load(text).values()
    expected = {"supply.pressure": 1.2e6} if found.informed else {}
    assert loaded == {"ros__parameters": expected}


@pytest.mark.parametrize(("known", "found"), [(1e-8, 5e-8), (5e-8, None)])
def test_a_conductance_that_no_plant_can_have_is_not_written(
    known: float, found: float | None
) -> None:
    """Five times 0.01 dm³/(s·Pa) is one, five times 0.05 is beyond the highest, 0.1: none."""
    base = RigParameters({"valve.flow_law": "iso_6358", "valve.sonic_conductance": known})
    names = ("valve.closed_voltage", "valve.gap_height", "supply.pressure")
    estimates = {name: unknown("", "not looked at") for name in names}
    estimates["area factor"] = Estimate(5.0, 4.9, 5.1, "")
    fit = SimpleNamespace(solution=SimpleNamespace(parameters=base), estimates=estimates)
    conductance = valve_findings(fit)[-1]  # type: ignore[arg-type]
    assert conductance.name == "valve.sonic_conductance"
    assert conductance.value == (None if found is None else pytest.approx(found))
    parameter_text([], [conductance])


def test_the_area_curve_knows_when_it_is_no_sum_of_sines() -> None:
    """With a bump of 0.02 mm² at 6 V it says so; in 40 noisy sets of its own shape at most one."""
    coefficients = RigParameters().numbers("valve.area_coefficients")
    voltages = np.linspace(0.0, 10.0, 201)
    bump = 2e-8 * np.clip(1.0 - np.abs(voltages - 6.0), 0.0, None)
    alarms = 0
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(0.0, 5e-9, voltages.shape)
        right = fit_area_curve(voltages, three_sines(coefficients, voltages) + noise, coefficients)
        alarms += not right.verdict.fits
    assert alarms <= 2
    wrong = fit_area_curve(
        voltages, three_sines(coefficients, voltages) + bump + noise, coefficients
    )
    assert not wrong.verdict.fits


def test_the_flow_coefficient_knows_when_it_is_no_polynomial() -> None:
    """A step of 2 % at 2.5 V is none; eq. (25) with the same noise is."""
    deflection = np.linspace(0.1, 4.9, 200)
    noise = np.random.default_rng(1).normal(0.0, 5e-3, deflection.shape)
    smooth = 1.1 - 0.02 * deflection
    assert fit_flow_coefficient(deflection, smooth + noise).verdict.fits
    assert fit_flow_coefficient(deflection, smooth).verdict.fits
    step = smooth + np.where(deflection > 2.5, 0.02, 0.0)
    assert not fit_flow_coefficient(deflection, step + noise).verdict.fits
