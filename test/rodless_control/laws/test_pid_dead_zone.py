# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Crossing the valve's flat centre."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

EFFORTS = np.concatenate([np.linspace(1e-6, 0.2, 400), np.linspace(0.21, 4.0, 100)])


def compensation(parameters: PidParameters, efforts: np.ndarray) -> np.ndarray:
    """Voltage about neutral for each effort (V)."""
    pid = Pid(parameters)
    return np.array(
        [
            pid.update(Measurement(0, 0.0), ReferencePoint(float(u)), 0.0).voltage - 5.0
            for u in efforts
        ]
    )


@pytest.fixture
def crossing(bare: Make) -> PidParameters:
    """Return a law that passes its error on, 1 V per metre, over a centre 0.45 V wide."""
    return bare(kp=1.0, dead_zone_voltage=0.45, dead_zone_width=0.02)


def test_it_is_odd(crossing: PidParameters) -> None:
    """Both directions get the same help."""
    forward, reverse = compensation(crossing, EFFORTS), compensation(crossing, -EFFORTS)
    np.testing.assert_allclose(reverse, -forward, rtol=0.0, atol=4e-15)
    assert Pid(crossing).update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0).voltage == 5.0


def test_it_is_monotone_and_never_weakens_the_command(crossing: PidParameters) -> None:
    """More effort gives more voltage, never less than without compensation."""
    voltages = compensation(crossing, EFFORTS)
    assert (np.diff(voltages) > 0.0).all()
    assert (voltages >= EFFORTS - 1e-15).all()


def test_it_is_as_large_as_declared(crossing: PidParameters) -> None:
    """Far from the centre it adds 0.45 V, at its width about three quarters of that."""
    far, near = compensation(crossing, np.array([1.0, 0.02]))
    assert far == pytest.approx(1.45, rel=1e-12)
    e = math.e**2
    assert near - 0.02 == pytest.approx(0.45 * (e - 1.0) / (e + 1.0), rel=1e-12)
    assert 0.7 < (near - 0.02) / 0.45 < 0.8


def test_none_adds_nothing(bare: Make) -> None:
    """With a dead-zone voltage of zero the effort passes unchanged."""
    passed = compensation(bare(kp=1.0), EFFORTS)
    np.testing.assert_allclose(passed, EFFORTS, rtol=0.0, atol=1e-15)
