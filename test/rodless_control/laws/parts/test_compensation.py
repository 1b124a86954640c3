# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Dead zone, friction, reference acceleration and integral against numbers worked out by hand."""

import math

import pytest

from rodless_control.laws.parts.dead_zone import crossing
from rodless_control.laws.parts.friction import Friction, compensation
from rodless_control.laws.parts.integral import Integrator, integrated
from rodless_control.laws.parts.reference import LARGEST_ACCELERATION, reference_acceleration


def test_the_crossing_of_the_dead_zone() -> None:
    """Odd; tanh 1 of 0.7 V at the width; all of it far away; the slope at 0 is 0.7/0.1."""
    assert crossing(0.7, 0.1, 0.1) == pytest.approx(0.7 * math.tanh(1.0), rel=1e-15)
    assert crossing(0.7, 0.1, -3.0) == -crossing(0.7, 0.1, 3.0)
    assert crossing(0.7, 0.1, 5.0) == pytest.approx(0.7, rel=1e-15)
    assert crossing(0.7, 0.1, 1e-9) / 1e-9 == pytest.approx(7.0, rel=1e-12)
    assert crossing(0.0, 0.1, 2.0) == 0.0


def test_friction_is_overcome_in_the_direction_that_is_wanted() -> None:
    """At rest the error decides, in a move the reference; 3 N + 2 N + 5 N·s/m at 0.1 m/s."""
    friction = Friction(
        3.0, static_width=1e-4, coulomb=2.0, coulomb_width=1e-3, viscous=5.0, lead=0.0
    )
    assert compensation(friction, 0.0, 0.0, 0.0) == 0.0
    assert compensation(friction, 1e-4, 0.0, 0.0) == pytest.approx(3.0 * math.tanh(1.0), rel=1e-15)
    assert compensation(friction, 5e-5, 0.0, 0.0) == pytest.approx(3.0 * math.tanh(0.5), rel=1e-15)
    assert compensation(friction, 0.0, 1e-3, 0.0) == pytest.approx(2.0 * math.tanh(1.0) + 5e-3)
    assert compensation(friction, 1.0, 0.1, 0.0) == pytest.approx(3.0 + 2.0 + 0.5, rel=1e-15)
    assert compensation(friction, -1.0, -0.1, 0.0) == -compensation(friction, 1.0, 0.1, 0.0)


def test_friction_is_overcome_ahead_of_the_reference() -> None:
    """20 ms before a sine reverses it is that of the other side; at rest there is none."""
    friction = Friction(
        0.0, static_width=1e-4, coulomb=2.0, coulomb_width=1e-3, viscous=5.0, lead=0.04
    )
    ahead = compensation(friction, 0.0, -0.1 * 0.02, 0.1)
    assert ahead == pytest.approx(compensation(friction._replace(lead=0.0), 0.0, 0.1 * 0.02, 0.0))
    assert ahead > 0.0
    assert compensation(friction, 0.0, 0.0, 50.0) == 0.0


def test_the_acceleration_of_a_steady_change_of_velocity_is_exact() -> None:
    """0.5 m/s² of the reference come to be known to rounding; the way there is e^(-376 t)."""
    found = 0.0
    for k in range(1, 201):
        found = reference_acceleration(376.0, found, 0.5e-3, 1e-3)
        if k <= 20:
            assert found == pytest.approx(0.5 * -math.expm1(-0.376 * k), rel=1e-12)
    assert found == pytest.approx(0.5, rel=1e-12)


def test_a_step_of_the_velocity_counts_as_a_bounded_acceleration() -> None:
    """However large the step; and time that stands still changes nothing."""
    for step in (1.0, 1e3, -1e3):
        found = reference_acceleration(1e9, 0.0, step, 1e-3)
        assert found == pytest.approx(math.copysign(LARGEST_ACCELERATION, step))
    assert reference_acceleration(376.0, 0.3, 1.0, 0.0) == 0.3


@pytest.mark.parametrize(
    ("error", "saturated", "grown"),
    [
        (1e-4, 0.0, True),
        (1e-4, -1.0, True),  # away from the limit
        (1e-4, 1.0, False),  # against it
        (-1e-4, -1.0, False),
        (-1e-4, 1.0, True),
        (2e-4, 0.0, False),  # outside its zone
        (3e-4, 0.0, False),
    ],
)
def test_the_integral_grows_in_its_zone_and_not_against_a_limit(
    error: float, saturated: float, grown: bool
) -> None:
    """By 50 V/(m·s) of the error and 0.01 s, on top of 0.2 V."""
    found = integrated(Integrator(50.0, 2e-4), 0.2, error, saturated, 0.01)
    assert found == pytest.approx(0.2 + (50.0 * error * 0.01 if grown else 0.0), rel=1e-15)


def test_beyond_its_zone_the_integral_only_unwinds() -> None:
    """At the pace of the zone's edge, 2e-4 m, for an error of -3e-4 m."""
    found = integrated(Integrator(50.0, 2e-4), 0.2, -3e-4, 0.0, 0.01)
    assert found == pytest.approx(0.2 - 50.0 * 2e-4 * 0.01, rel=1e-14)
