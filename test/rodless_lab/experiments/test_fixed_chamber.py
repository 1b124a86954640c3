# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The fixed chambers: initial pressures by hand, and findings that can fail."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rodless_lab.experiments.fixed_chamber import FixedChamberResult, run_fixed_chamber


@pytest.fixture(scope="module")
def result() -> FixedChamberResult:
    """Return the three supplies of the paper."""
    return run_fixed_chamber()


def test_initial_pressures_by_hand(result: FixedChamberResult) -> None:
    """√((Ps² + Pe²)/2) for 0.501325, 0.601325 and 0.701325 MPa: 0.3617, 0.4312, 0.5011 MPa."""
    for run, expected in zip(result.runs, (361658.0, 431195.0, 501061.0), strict=True):
        assert run.start == pytest.approx((expected, expected), rel=0.01)


def test_chambers_end_where_their_flows_balance(result: FixedChamberResult) -> None:
    """The last sample of the run is the balance that the root finder found, within 0.1 kPa."""
    for run in result.runs:
        assert run.pressure_a[-1] == pytest.approx(run.end[0], abs=100.0)
        assert run.pressure_b[-1] == pytest.approx(run.end[1], abs=100.0)


def test_a_valve_that_seals_has_nothing_to_find(result: FixedChamberResult) -> None:
    """Without the leak chambers end at ambient and supply: finding (1) then must not hold."""
    sealed = replace(result, runs=tuple(replace(run, end=run.sealed) for run in result.runs))
    for run in sealed.runs:
        assert run.sealed == pytest.approx((101325.0, run.supply), abs=1.0)
    growth = [row.value for row in sealed.comparisons if row.quantity.startswith("finding (1)")]
    assert growth == pytest.approx([0.0] * 4, abs=1e-3)


def test_finding_2_fails_when_the_pressure_does_not_rise(result: FixedChamberResult) -> None:
    """Three runs at the same initial pressure are no rise."""
    first = result.runs[0]
    flat = replace(
        result, runs=tuple(replace(run, pressure_a=first.pressure_a) for run in result.runs)
    )
    rows = [row for row in flat.comparisons if row.quantity.startswith("finding (2)")]
    assert rows
    assert not any(row.holds for row in rows)


def test_settling_of_a_known_exponential(result: FixedChamberResult) -> None:
    """95 % of an exponential of 0.5 s take 0.5 · ln 20 = 1.498 s; what stays short never is."""
    run = result.runs[0]
    decay = 1e5 + 4e5 * np.exp(-run.time / 0.5)
    assert run.settling(decay, 1e5) == pytest.approx(0.5 * np.log(20.0), abs=2e-3)
    assert run.settling(decay, 0.0) == math.inf


def test_mid_stroke_vents_slower(result: FixedChamberResult) -> None:
    """With 64 instead of 15 cm³ chamber A takes about 64/15 as long."""
    middle = run_fixed_chamber(0.1, (0.4e6,)).runs[0]
    end = result.runs[0]
    slower = middle.settling(middle.pressure_a, middle.end[0])
    faster = end.settling(end.pressure_a, end.end[0])
    assert slower / faster == pytest.approx(64.09 / 15.0, rel=0.05)
