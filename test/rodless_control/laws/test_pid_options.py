# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The options of the PID: each against numbers worked out by hand, and off by default."""

import math
from collections.abc import Callable

import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

INTERVAL = 1e-3


def test_they_are_off_by_default() -> None:
    """What was written before there were any goes on as it was."""
    values = PidParameters()
    assert values["controller.filter"] == "low_pass"
    options = ("gain_boost", "acceleration_feedforward", "parking_error", "parking_correction")
    for option in options:
        assert values[f"controller.{option}"] == 0.0


def test_the_fading_memory_filter_does_not_lag(bare: Make) -> None:
    """On a ramp of 0.1 m/s the derivative term is exact and the error is none, noise aside."""
    pid = Pid(bare(kp=100.0, kd=4.0, filter="fading_memory", filter_bandwidth=376.0))
    for k in range(200):
        position = 0.1 * k * INTERVAL
        command = pid.update(Measurement(0, position), ReferencePoint(position), INTERVAL)
    assert command.d == pytest.approx(-0.4, rel=1e-9)
    assert command.error == pytest.approx(0.0, abs=1e-12)


def test_the_gain_is_boosted_near_the_target(bare: Make) -> None:
    """Of 10 V/m: 15 V/m at a small error, 10·(1 + 0.5/e) V/m at the width, 10 V/m far away."""
    pid = Pid(bare(kp=10.0, gain_boost=0.5, gain_boost_width=1e-3))
    for error, gain in ((1e-7, 15.0), (1e-3, 10.0 * (1.0 + 0.5 / math.e)), (0.05, 10.0)):
        for side in (1.0, -1.0):
            command = pid.update(Measurement(0, 0.1), ReferencePoint(0.1 + side * error), 0.0)
            assert command.p == pytest.approx(gain * side * error, rel=1e-6)


def test_the_acceleration_of_the_reference_is_fed_forward(bare: Make) -> None:
    """0.5 m/s² at 2 V·s²/m are 1 V, on top of 3 V·s/m of the velocity."""
    parameters = bare(feedforward=3.0, acceleration_feedforward=2.0, filter_bandwidth=376.0)
    pid = Pid(parameters)
    for k in range(200):
        velocity = 0.5e-3 * k
        command = pid.update(Measurement(0, 0.1), ReferencePoint(0.1, velocity), INTERVAL)
    assert command.feedforward == pytest.approx(3.0 * velocity + 1.0, rel=1e-12)


def test_parked_the_integral_holds_and_a_hundredth_of_the_rest_acts(bare: Make) -> None:
    """10 µm off at rest: the 25 µm of parking are kept, the integral stays, p shrinks to 1 %."""
    pid = Pid(bare(kp=1000.0, ki=100.0, parking_error=25e-6))
    errors = [1e-3] * 100 + [1e-5] * 300
    commands = [
        pid.update(Measurement(0, 0.1 - error), ReferencePoint(0.1), INTERVAL) for error in errors
    ]
    command = commands[-1]
    assert command.i == commands[-2].i > 0.0
    assert command.p == pytest.approx(0.01 * 1000.0 * 1e-5, rel=1e-9)
    assert command.voltage == pytest.approx(5.0 + command.p + command.i, rel=1e-12)


def test_parked_a_hundredth_of_damping_acts(bare: Make) -> None:
    """At 1 mm/s, slow enough to stay parked, 1 % of kd·v."""
    pid = Pid(bare(kp=0.0, kd=200.0, parking_error=25e-6, filter_bandwidth=1e5))
    for _ in range(400):
        pid.update(Measurement(0, 0.1), ReferencePoint(0.1), INTERVAL)
    step = 1e-3 * INTERVAL
    command = pid.update(Measurement(0, 0.1 + step), ReferencePoint(0.1), INTERVAL)
    assert command.d == pytest.approx(-0.01 * 200.0 * 1e-3, rel=1e-9)
    assert command.voltage == pytest.approx(5.0 + command.d, rel=1e-12)


def crept(make: Make, **options: float) -> Pid:
    """Return a PID without gains, parked at the target, whose carriage has crept 40 µm from it."""
    pid = Pid(make(kp=0.0, ki=0.0, parking_error=25e-6, parking_bandwidth=50.0, **options))
    for error in [0.0] * 10 + [40e-6] * 1000:
        pid.update(Measurement(0, 0.1 - error), ReferencePoint(0.1), INTERVAL)
    return pid


def test_parked_a_carriage_that_creeps_is_held(bare: Make) -> None:
    """40 µm off, 15 µm beyond the 25 µm of parking: 3000 V/m of it, and none where not asked."""
    for correction, expected in ((3000.0, 0.045), (0.0, 0.0)):
        pid = crept(bare, parking_correction=correction)
        command = pid.update(Measurement(0, 0.1 - 40e-6), ReferencePoint(0.1), INTERVAL)
        assert command.p == pytest.approx(expected, abs=1e-6)
        assert command.voltage == pytest.approx(5.0 + expected, abs=1e-6)


def test_the_correction_of_a_parked_carriage_is_switched_on_without_a_jump(bare: Make) -> None:
    """The voltage of that instant is the one before; then the offset fades."""
    pid = crept(bare, tracking_time=1.0)
    sample = Measurement(0, 0.1 - 40e-6), ReferencePoint(0.1)
    before = pid.update(*sample, 0.0).voltage
    pid.configure(pid.parameters.with_values({"controller.parking_correction": 3000.0}))
    command = pid.update(*sample, 0.0)
    assert command.p == pytest.approx(0.045, abs=1e-6)
    assert command.voltage == pytest.approx(before, abs=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"controller.gain_boost": 0.5},
        {"controller.acceleration_feedforward": 0.5},
        {"controller.filter": "fading_memory"},
    ],
    ids=str,
)
def test_an_option_is_switched_on_without_a_jump(
    bare: Make, change: dict[str, float | str]
) -> None:
    """In the middle of a move the voltage stays where it is at that instant."""
    parameters = bare(kp=100.0, ki=9.0, kd=2.0, feedforward=1.5, tracking_time=1.0)
    pid = Pid(parameters)
    for k in range(100):
        time = k * INTERVAL
        sample = Measurement(0, 0.1 * time**2), ReferencePoint(0.1 * time**2 + 1e-3, 0.2 * time)
        pid.update(*sample, INTERVAL)
    before = pid.update(*sample, 0.0).voltage
    pid.configure(parameters.with_values(change))
    assert pid.update(*sample, 0.0).voltage == pytest.approx(before, abs=1e-12)
