# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The filter of second degree: no lag, the poles it is declared with, and a known acceleration."""

import math

import numpy as np
import pytest

from rodless_control.laws.parts.fading_memory import Motion, at_rest, estimated

BANDWIDTH = 376.0


def test_it_comes_to_follow_constant_acceleration_exactly() -> None:
    """Position, velocity and acceleration of y = 0.1 + 0.2 t + 1.5 t², 0.1 s after a start at rest.

    A first-order filter would lag behind, a second-order one under acceleration.
    """
    interval, motion = 1e-3, at_rest(0.1)
    for k in range(1, 101):
        time = k * interval
        position = 0.1 + 0.2 * time + 1.5 * time * time
        motion = estimated(BANDWIDTH, motion, position, 0.0, interval)
    assert motion.position == pytest.approx(position, abs=1e-12)
    assert motion.velocity == pytest.approx(0.2 + 3.0 * 0.1, abs=1e-9)
    assert motion.acceleration == pytest.approx(3.0, abs=1e-7)


@pytest.mark.parametrize("interval", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("bandwidth", [10.0, 376.0])
def test_its_poles_are_three_at_the_bandwidth(bandwidth: float, interval: float) -> None:
    """The error's transition from sample to sample has the characteristic polynomial (z - p)³."""
    columns = [
        estimated(bandwidth, Motion(*unit), 0.0, 0.0, interval) for unit in np.eye(3).tolist()
    ]
    found = np.poly(np.array(columns).T)
    pole = math.exp(-bandwidth * interval)
    assert found == pytest.approx(np.poly([pole] * 3), abs=1e-9)


def test_a_known_acceleration_leaves_nothing_to_explain() -> None:
    """Told of all of it, the filter is exact from the first sample and finds no disturbance.

    Told of 3 m/s² where there is 1 m/s², it finds a disturbance of -2 m/s².
    """
    interval, told, mistaken = 1e-3, at_rest(0.0), at_rest(0.0)
    for k in range(1, 201):
        position = 0.5 * (k * interval) ** 2
        told = estimated(BANDWIDTH, told, position, 1.0, interval)
        mistaken = estimated(BANDWIDTH, mistaken, position, 3.0, interval)
        assert told.position == pytest.approx(position, abs=1e-13)
        assert told.acceleration == pytest.approx(0.0, abs=1e-8)
    assert mistaken.acceleration == pytest.approx(-2.0, abs=1e-7)
    assert mistaken.position == pytest.approx(position, abs=1e-12)


def test_it_passes_noise_as_its_impulse_response_says() -> None:
    """White noise of 20 µm comes out with the standard deviation of the sampled response."""
    interval = 1e-3
    motion, response = at_rest(0.0), []
    for k in range(400):
        motion = estimated(BANDWIDTH, motion, float(k == 0), 0.0, interval)
        response.append((motion.position, motion.velocity))
    expected = 2e-5 * np.sqrt(np.square(response).sum(axis=0))
    generator, motion, seen = np.random.default_rng(1), at_rest(0.0), []
    for reading in generator.normal(0.0, 2e-5, 20_000):
        motion = estimated(BANDWIDTH, motion, float(reading), 0.0, interval)
        seen.append((motion.position, motion.velocity))
    assert np.std(seen, axis=0) == pytest.approx(expected, rel=0.05)


def test_time_that_stands_still_changes_nothing() -> None:
    """An interval of 0 returns the very same estimates, whatever is read."""
    motion = Motion(0.1, 0.2, 0.3)
    assert estimated(BANDWIDTH, motion, 5.0, 6.0, 0.0) == motion
