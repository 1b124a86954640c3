# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Step and sine: their numbers against the arrays they come from, and against hand calculation."""

import math

import numpy as np
import pytest

from rodless_lab.experiments.sine import reachable_amplitude, run_sine
from rodless_lab.experiments.step import run_step, top_speed


def test_top_speed_by_hand() -> None:
    """255.254 N of supply less 12 N Coulomb over 4500 N·s/m: 54.06 mm/s, which no run exceeds."""
    # 490.8739 mm² x 0.52 MPa = 255.254 N
    assert top_speed() == pytest.approx((255.254 - 12.0) / 4500.0, rel=1e-5)
    assert np.abs(run_step(("paper",)).runs["paper"].velocity).max() <= top_speed()


def test_step_rows_are_measured_on_the_arrays() -> None:
    """Rise and final error in the table are what the position array shows, found another way."""
    result = run_step(("calibrated",))
    run = result.runs["calibrated"]
    rows = {row.quantity: row.value for row in result.comparisons}
    assert rows["calibrated: error at the end"] == pytest.approx((run.position[-1] - 0.058) * 1e3)
    moving = run.time[(run.position > 0.0058) & (run.position < 0.0522)]
    assert rows["calibrated: rise, 10 to 90 %"] == pytest.approx(np.ptp(moving), abs=2.1e-3)
    assert not any(row.startswith("paper") for row in rows)


def test_reachable_amplitude_by_hand() -> None:
    """54.06 mm/s over 2π · 0.381 Hz is 22.6 mm, so 20 mm is within reach and 50 mm is not."""
    assert reachable_amplitude() == pytest.approx(0.05406 / (2 * math.pi * 0.381), rel=1e-3)


def test_sine_of_another_amplitude_is_judged_by_the_paper_alone() -> None:
    """Where nobody has computed a bound before, the paper's 10 mm is the only one."""
    result = run_sine(("calibrated",), amplitude=0.03, centre=0.12)
    row = result.comparisons[0]
    assert row.quantity == "calibrated, 30 mm: largest tracking error"
    assert row.limits is not None
    assert row.limits.highest == 10.0
    assert result.runs["calibrated"].reference.max() == pytest.approx(0.15, abs=1e-6)


def test_below_10_mm_the_papers_bound_says_nothing() -> None:
    """An error of up to 10 mm is no achievement at an amplitude of 2 mm: shown, not judged."""
    result = run_sine(("calibrated",), amplitude=0.002)
    row = result.comparisons[0]
    assert row.quantity == "calibrated, 2 mm: largest tracking error"
    assert row.limits is None


def test_rows_count_from_the_second_period_on() -> None:
    """Errors and the presets' difference, each found on the arrays by another mask."""
    result = run_sine()
    paper, calibrated = result.runs.values()
    late = paper.time[paper.time - 0.5 > 1.0 / 0.381]
    last = len(late)
    rows = {row.quantity: row.value * 1e-3 for row in result.comparisons}
    apart = np.abs(paper.position[-last:] - calibrated.position[-last:]).max()
    assert rows["largest difference between the presets, 20 mm"] == pytest.approx(apart)
    assert rows["paper, 20 mm: largest tracking error"] == pytest.approx(
        np.abs(paper.error[-last:]).max()
    )
    assert np.abs(paper.position - calibrated.position).max() > apart


@pytest.mark.parametrize(("amplitude", "centre"), [(0.0, 0.1), (0.06, 0.05), (0.05, 0.16)])
def test_a_sine_that_cannot_be_is_refused(amplitude: float, centre: float) -> None:
    """One that no sensor tells, or that leaves the stroke on either side: before anything runs."""
    with pytest.raises(ValueError, match=r"which a sensor tells|leaves the stroke"):
        run_sine(("paper",), amplitude, centre)


def test_table_2_cannot_follow_50_mm() -> None:
    """With Table 2's friction the 50 mm sine is missed by more than its unreachable part."""
    result = run_sine(("paper",))
    (row,) = [row for row in result.comparisons if "50 mm" in row.quantity]
    assert row.value > 50.0 - 22.6
    assert row.holds
