# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The measured position loses its noise, and nothing else."""

import numpy as np
import pytest

from rodless_lab.identification.pressures.course import smoothed

PERIOD = 1e-3
TIME = np.arange(2000) * PERIOD
NOISE = 2e-5


def step_of(length: float, speed: float, acceleration: float) -> np.ndarray:
    """Rest, a move of ``length`` (m) that speeds up and brakes evenly, rest; in closed form."""
    rise = speed / acceleration
    cruise = length / speed - rise
    t = np.clip(TIME - 0.5, 0.0, 2.0 * rise + cruise)
    up = 0.5 * acceleration * np.minimum(t, rise) ** 2
    along = speed * np.clip(t - rise, 0.0, cruise)
    braking = np.clip(t - rise - cruise, 0.0, rise)
    return 0.06 + up + along + speed * braking - 0.5 * acceleration * braking**2


def noise(seed: int) -> np.ndarray:
    """White noise of the data sheet's size."""
    return np.random.default_rng(seed).normal(0.0, NOISE, TIME.shape)


def test_a_position_without_noise_comes_back() -> None:
    """58 mm at 0.5 m/s with 100 m/s²: the jerks at either end stay within 0.1 µm."""
    position = step_of(0.058, 0.5, 100.0)
    assert np.abs(smoothed(position, PERIOD) - position).max() < 1e-7


def test_noise_is_averaged_out_of_smooth_motion() -> None:
    """A sine of 1 Hz under 20 µm of noise: a parabola over 21 samples leaves a third of it."""
    position = 0.1 + 0.02 * np.sin(2.0 * np.pi * TIME)
    left = np.std(smoothed(position + noise(1), PERIOD) - position)
    # Of white noise such a parabola leaves sqrt(9 / (4 * 21)).
    assert left < 1.25 * NOISE * np.sqrt(9.0 / 84.0)


def test_a_jerk_is_not_smoothed_away() -> None:
    """Under 20 µm of noise, the mean of 40 measurements of a fast move is within 40 µm of it."""
    position = step_of(0.058, 0.5, 100.0)
    mean = np.mean([smoothed(position + noise(seed), PERIOD) for seed in range(40)], axis=0)
    assert np.abs(mean - position).max() < 2.0 * NOISE


def test_several_runs_are_smoothed_each_by_itself() -> None:
    """Three at once, one of them at rest: the same as one by one, but for rounding."""
    moving = step_of(0.058, 0.5, 100.0)
    runs = np.stack([moving + noise(1), 0.06 + noise(2), moving + 2.0 * noise(3)])
    expected = np.stack([smoothed(run, PERIOD) for run in runs])
    np.testing.assert_allclose(smoothed(runs, PERIOD), expected, rtol=1e-13)


def test_a_carriage_that_rests_stays_at_its_mean() -> None:
    """Nothing but noise: one position throughout."""
    found = smoothed(0.06 + noise(2), PERIOD)
    assert np.ptp(found) == 0.0
    assert found[0] == pytest.approx(0.06, abs=NOISE)
