# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the integrator does while the command is at a limit."""

from collections.abc import Callable

import numpy as np
import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

KINDS = ("conditional_integration", "back_calculation", "none")


def saturated(parameters: PidParameters, samples: int, interval: float) -> tuple[Pid, np.ndarray]:
    """A controller after ``samples`` with an error of 1 m, and its integral term at each."""
    pid = Pid(parameters)
    return pid, np.array(
        [pid.update(Measurement(0, 0.0), ReferencePoint(1.0), interval).i for _ in range(samples)]
    )


def test_conditional_integration_freezes_and_releases_at_once(bare: Make) -> None:
    """At the limit the integral stays exactly where it is; an error of the other sign moves it."""
    pid, integral = saturated(
        bare(kp=10.0, ki=3.0, anti_windup="conditional_integration"), 100, 0.01
    )
    assert not integral.any()
    back = pid.update(Measurement(0, 0.0), ReferencePoint(-0.1), 0.01)
    assert back.i == pytest.approx(-0.003, rel=1e-13)
    assert back.voltage == pytest.approx(5.0 - 1.0 - 0.003, rel=1e-13)


def test_conditional_integration_lets_the_error_out_of_saturation(bare: Make) -> None:
    """At the upper limit a negative error still integrates: only growth outwards is stopped."""
    pid = Pid(bare(ki=3.0, feedforward=100.0, anti_windup="conditional_integration"))
    terms = [pid.update(Measurement(0, 0.0), ReferencePoint(-0.1, 1.0), 0.1) for _ in range(4)]
    assert {command.voltage for command in terms} == {10.0}
    assert [command.i for command in terms] == pytest.approx([0.0, -0.03, -0.06, -0.09], rel=1e-13)


def test_all_terms_tell_whether_the_command_is_at_its_limit(bare: Make) -> None:
    """4 V of p are 1 V with -3 V of d or feed-forward: the integral grows; with 3 V they are 7."""
    values = {"kp": 40.0, "ki": 3.0, "anti_windup": "conditional_integration"}
    for speed, grown in ((-1.0, 0.03), (1.0, 0.0)):
        ahead = Pid(bare(feedforward=3.0, **values))
        for k in range(2):
            command = ahead.update(Measurement(0, 0.0), ReferencePoint(0.1, speed), 0.1 * k)
        assert (command.p, command.feedforward) == pytest.approx((4.0, 3.0 * speed), rel=1e-12)
        assert command.i == pytest.approx(grown, rel=1e-12)
        damped = Pid(bare(kd=3.0, filter_bandwidth=1e5, **values))
        for k in range(2):  # at rest, then as fast as the other way
            at = Measurement(0, -0.1 * speed * k)
            command = damped.update(at, ReferencePoint(0.1 + at.position), 0.1 * k)
        assert (command.p, command.d) == pytest.approx((4.0, 3.0 * speed), rel=1e-12)
        assert command.i == pytest.approx(grown, rel=1e-12)


def test_conditional_integration_works_at_the_lower_limit(bare: Make) -> None:
    """The lower limit is the mirror image of the upper one."""
    pid = Pid(bare(kp=10.0, ki=3.0, anti_windup="conditional_integration"))
    assert [pid.update(Measurement(0, 0.0), ReferencePoint(-1.0), 0.01).i for _ in range(9)] == [
        0.0
    ] * 9
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.1), 0.01).i == pytest.approx(
        0.003, rel=1e-13
    )


def test_back_calculation_decays_with_the_tracking_time(bare: Make) -> None:
    """15 V too much shrink to the limit as exp(-t/T), the closed form of continuous tracking."""
    interval, tracking_time = 1e-4, 0.1
    parameters = bare(kp=20.0, anti_windup="back_calculation", tracking_time=tracking_time)
    _, integral = saturated(parameters, 5001, interval)
    excess = 20.0 + integral - 5.0
    time = interval * np.arange(5001)
    np.testing.assert_allclose(excess, 15.0 * np.exp(-time / tracking_time), rtol=3e-3)


def test_back_calculation_settles_between_growth_and_tracking(bare: Make) -> None:
    """At a steady error the command rests T·ki·e beyond the limit, where both rates cancel."""
    parameters = bare(kp=5.0, ki=4.0, anti_windup="back_calculation", tracking_time=0.1)
    _, integral = saturated(parameters, 5000, 1e-3)
    # The tracking sees the integral already grown by one interval, hence 0.1 s less 1 ms.
    assert 5.0 + integral[-1] - 5.0 == pytest.approx((0.1 - 1e-3) * 4.0, rel=1e-9)


def test_back_calculation_never_corrects_more_than_the_excess(bare: Make) -> None:
    """With samples slower than the tracking time the command lands on the limit, not below."""
    parameters = bare(kp=20.0, anti_windup="back_calculation", tracking_time=0.01)
    _, integral = saturated(parameters, 3, 1.0)
    assert integral.tolist() == pytest.approx([0.0, -15.0, -15.0], rel=1e-14)


def test_without_anti_windup_the_integral_winds_up(bare: Make) -> None:
    """With "none" it grows at the limit as it does anywhere, and the command sticks there."""
    pid, integral = saturated(bare(kp=10.0, ki=30.0), 101, 0.01)
    np.testing.assert_allclose(integral, 30.0 * 0.01 * np.arange(101), rtol=1e-12)
    assert pid.update(Measurement(0, 0.0), ReferencePoint(-0.1), 0.01).voltage == 10.0


def overshoot(parameters: PidParameters) -> float:
    """Overshoot of a 3 m step on an integrating plant, 0.1 m/s per V about 5 V, as a share."""
    pid, interval, position, highest = Pid(parameters), 0.01, 0.0, 0.0
    for _ in range(6000):
        voltage = pid.update(Measurement(0, position), ReferencePoint(3.0), interval).voltage
        position += 0.1 * (voltage - 5.0) * interval
        highest = max(highest, position)
    assert position == pytest.approx(3.0, abs=0.03)
    return highest / 3.0 - 1.0


def test_anti_windup_saves_overshoot_on_a_saturated_plant(bare: Make) -> None:
    """The same gains overshoot several times more where the integrator winds up."""
    found = {kind: overshoot(bare(kp=10.0, ki=5.0, anti_windup=kind)) for kind in KINDS}
    assert found["none"] > 0.3
    assert found["conditional_integration"] < found["none"] / 3.0
    assert found["back_calculation"] < found["none"] / 3.0
