# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The derivative term: of the filtered measurement, and of that alone."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy import signal

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

BANDWIDTH = 300.0
INTERVAL = 1e-3


def velocities(parameters: PidParameters, positions: np.ndarray, interval: float) -> np.ndarray:
    """Velocity behind the derivative term at each of ``positions``."""
    pid = Pid(parameters)
    gain = parameters.number("controller.kd")
    return np.array(
        [-pid.update(Measurement(0, x), ReferencePoint(0.0), interval).d / gain for x in positions]
    )


def test_a_jump_of_the_reference_does_not_reach_it(bare: Make) -> None:
    """A set-point step at rest leaves the term at zero, and the command moves by kp·step alone."""
    pid = Pid(bare(kp=20.0, kd=50.0))
    before = [pid.update(Measurement(0, 0.03), ReferencePoint(0.0), INTERVAL) for _ in range(10)][
        -1
    ]
    after = pid.update(Measurement(0, 0.03), ReferencePoint(0.05), INTERVAL)
    assert before.d == after.d == 0.0
    assert after.voltage - before.voltage == pytest.approx(20.0 * 0.05, rel=1e-14)


def test_it_is_the_exactly_sampled_high_pass(bare: Make) -> None:
    """It follows scipy's zero-order-hold form of w/(s+w), differenced over each interval."""
    positions = 0.01 * np.cumsum(np.random.default_rng(2).standard_normal(500))
    numerator, denominator, _ = signal.cont2discrete(
        ([BANDWIDTH], [1.0, BANDWIDTH]), INTERVAL, method="zoh"
    )
    # The sample closes the interval over which it is held, hence the shift by one.
    held = np.append(positions[1:], 0.0) - positions[0]
    low_pass = signal.lfilter(numerator.ravel(), denominator, held)
    expected = np.diff(low_pass, prepend=0.0) / INTERVAL
    found = velocities(bare(kd=2.0, filter_bandwidth=BANDWIDTH), positions, INTERVAL)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_it_is_the_mean_of_the_continuous_high_pass(bare: Make) -> None:
    """Each value is the mean over its interval of ws/(s+w) driven by the held measurement."""
    positions = 0.01 * np.random.default_rng(3).standard_normal(20)
    positions[0] = 0.0
    found = velocities(bare(kd=2.0, filter_bandwidth=BANDWIDTH), positions, INTERVAL)
    fine = 400
    time = np.arange(fine * (len(positions) - 1) + 1) * INTERVAL / fine
    held = np.append(np.repeat(positions[1:], fine), positions[-1])
    _, output, _ = signal.lsim(([BANDWIDTH, 0.0], [1.0, BANDWIDTH]), held, time, interp=False)
    means = output[:-1].reshape(-1, fine).mean(axis=1)
    # The mean over a fine grid is a left sum: off by half a grid step of a decaying curve.
    assert np.abs(found[1:] - means).max() < BANDWIDTH * INTERVAL / fine * np.abs(means).max()


@pytest.mark.parametrize("interval", [1e-4, 1e-3, 1e-2])
def test_a_ramp_gives_its_slope(bare: Make, interval: float) -> None:
    """Once the filter has settled the velocity of a ramp is exact, however coarse the sampling."""
    slope = -0.37
    positions = slope * interval * np.arange(round(0.2 / interval))
    found = velocities(bare(kd=2.0, filter_bandwidth=BANDWIDTH), positions, interval)
    assert found[-1] == pytest.approx(slope, rel=1e-9)


def test_a_held_position_may_be_sampled_in_pieces(bare: Make) -> None:
    """Two samples of one position move the filter as far as one over both intervals."""
    parameters = bare(kd=1.0, filter_bandwidth=40.0)
    once, twice = Pid(parameters), Pid(parameters)
    for pid in (once, twice):
        pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    whole = once.update(Measurement(0, 0.1), ReferencePoint(0.0), 0.05).d * 0.05
    pieces = (
        twice.update(Measurement(0, 0.1), ReferencePoint(0.0), 0.02).d * 0.02
        + twice.update(Measurement(0, 0.1), ReferencePoint(0.0), 0.03).d * 0.03
    )
    assert pieces == pytest.approx(whole, rel=1e-13)


def test_a_repeated_sample_keeps_it(bare: Make) -> None:
    """No time has passed: the term stays what it was."""
    pid = Pid(bare(kd=3.0))
    pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    moving = pid.update(Measurement(0, 0.02), ReferencePoint(0.0), INTERVAL)
    assert moving.d < 0.0
    assert pid.update(Measurement(0, 0.09), ReferencePoint(0.0), 0.0).d == moving.d
