# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The numbers of a step response, on responses known in closed form."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from rodless_lab.runs.step_metrics import SETTLING_BAND, StepMetrics, metric_lines, step_metrics

SPACING = 1e-5
AT = 0.25
TIME = np.arange(0.0, 4.0, SPACING)
STEPS = [(0.0, 0.058), (0.12, 0.02), (-0.01, 0.04)]
RESOLUTION = 1.5 * SPACING


def measured(response: np.ndarray, start: float, target: float) -> StepMetrics:
    """Metrics of a response given as a share of the step, from ``AT`` on."""
    before = np.searchsorted(TIME, AT - SPACING / 2.0)
    share = np.concatenate([np.zeros(before), response[: len(TIME) - before]])
    return step_metrics(
        TIME, start + share * (target - start), 5.0 + 3.0 * share, start, target, TIME[before]
    )


@pytest.mark.parametrize(("start", "target"), STEPS)
def test_first_order_response(start: float, target: float) -> None:
    """1 - exp(-t/T): rises in T·ln 9, settles after T·ln(height/band), never overshoots."""
    constant = 0.2
    found = measured(1.0 - np.exp(-TIME / constant), start, target)
    height = abs(target - start)
    assert found.rise_time == pytest.approx(constant * math.log(9.0), abs=RESOLUTION)
    expected = constant * math.log(height / SETTLING_BAND)
    assert found.settling_time == pytest.approx(expected, abs=RESOLUTION)
    assert found.overshoot == 0.0
    left = (start - target) * math.exp(-(TIME[-1] - AT) / constant)
    assert found.final_error == pytest.approx(left, rel=1e-3)


def second_order(damping: float, rate: float, time: np.ndarray | float) -> np.ndarray | float:
    """Share of a unit step that an underdamped second-order system has made."""
    root = math.sqrt(1.0 - damping**2)
    wave = np.cos(root * rate * time) + damping / root * np.sin(root * rate * time)
    return 1.0 - np.exp(-damping * rate * time) * wave


def last_entry(damping: float, rate: float, band: float) -> float:
    """Time of the last entry into the band: after the last extremum that is outside of it."""
    root = math.sqrt(1.0 - damping**2)
    half_period = math.pi / (root * rate)
    last = math.floor(-math.log(band) * root / (math.pi * damping))
    assert last >= 1
    return float(
        brentq(
            lambda t: abs(second_order(damping, rate, t) - 1.0) - band,
            last * half_period,
            (last + 0.5) * half_period + half_period * 0.49,
        )
    )


@pytest.mark.parametrize(("start", "target"), STEPS)
@pytest.mark.parametrize("damping", [0.2, 0.5, 0.7])
def test_second_order_response(start: float, target: float, damping: float) -> None:
    """Overshoot exp(-πζ/√(1-ζ²)); rise and settling at the roots of the closed form."""
    rate = 30.0
    height = abs(target - start)
    found = measured(np.asarray(second_order(damping, rate, TIME)), start, target)
    peak = height * math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    assert found.overshoot == pytest.approx(peak, rel=1e-6)
    top = math.pi / (rate * math.sqrt(1.0 - damping**2))
    low, high = (
        brentq(lambda t, share=share: second_order(damping, rate, t) - share, 0.0, top)
        for share in (0.1, 0.9)
    )
    assert found.rise_time == pytest.approx(high - low, abs=RESOLUTION)
    entry = last_entry(damping, rate, SETTLING_BAND / height)
    assert found.settling_time == pytest.approx(entry, abs=RESOLUTION)


def test_a_response_that_never_arrives_has_no_times() -> None:
    """Stuck at 70 %: no rise, no settling, and the error of where it stands."""
    found = measured(0.7 * (1.0 - np.exp(-TIME / 0.1)), 0.0, 0.1)
    assert math.isnan(found.rise_time)
    assert math.isnan(found.settling_time)
    assert found.overshoot == 0.0
    assert found.final_error == pytest.approx(-0.03, rel=1e-9)


def test_a_response_that_leaves_the_band_again_settles_afterwards() -> None:
    """A disturbance after the arrival counts: the last entry is what matters."""
    position = np.where(TIME < 1.0, 0.0, 0.05)
    position[(TIME >= 2.0) & (TIME < 2.5)] += 1.1 * SETTLING_BAND
    found = step_metrics(TIME, position, np.zeros(1), 0.0, 0.05, 0.5)
    assert found.settling_time == pytest.approx(2.0, abs=RESOLUTION)
    assert found.rise_time == 0.0
    assert found.overshoot == pytest.approx(1.1 * SETTLING_BAND, rel=1e-9)


def test_at_its_target_all_the_time_it_settles_at_once() -> None:
    """A record that starts inside the band before the step has a settling time of zero."""
    found = step_metrics(TIME, np.full(len(TIME), 0.05), np.zeros(1), 0.0, 0.05, 0.5)
    assert found.settling_time == 0.0
    assert found.final_error == 0.0


def test_the_peak_voltage_is_that_of_its_own_record() -> None:
    """Voltages may be fewer or more than positions."""
    voltage = np.array([5.08, 9.7, 3.0])
    found = step_metrics(TIME, 0.0 * TIME, voltage, 0.0, 0.05, 0.5)
    assert (found.peak_voltage, found.lowest_voltage) == (9.7, 3.0)


def test_the_table_says_which_way_error_and_peaks_are_meant() -> None:
    """1 mm beyond the target is +1 mm, as position minus target; both peaks are named."""
    found = step_metrics(TIME, np.full(len(TIME), 0.051), np.array([3.0, 9.0]), 0.0, 0.05, 0.5)
    lines = [" ".join(line.split()) for line in metric_lines(found)]
    assert "final error, actual - target 1.000 mm" in lines
    assert "peak valve voltage, highest 9.000 V" in lines
    assert "peak valve voltage, lowest 3.000 V" in lines


@pytest.mark.parametrize(
    ("time", "voltage", "target"), [([], [5.0], 0.1), ([0.0], [], 0.1), ([0.0], [5.0], 0.0)]
)
def test_what_is_no_step_response_is_refused(
    time: list[float], voltage: list[float], target: float
) -> None:
    """No samples, no voltages, or a step of no height."""
    samples = np.array(time)
    with pytest.raises(ValueError, match="needs samples and a step"):
        step_metrics(samples, samples, np.array(voltage), 0.0, target, 0.0)


@pytest.mark.parametrize("spoiled", ["time", "position", "voltage"])
def test_a_record_with_a_hole_is_refused(spoiled: str) -> None:
    """One NaN among the samples would pass for a carriage that has settled."""
    record = {"time": TIME.copy(), "position": 0.1 * TIME, "voltage": np.full(TIME.shape, 5.08)}
    record[spoiled][3] = np.nan
    with pytest.raises(ValueError, match="finite"):
        step_metrics(**record, start=0.0, target=0.05, at=0.5)
