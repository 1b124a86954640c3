# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the integrator holds, inside the dead-band and over a gap, and where it only unwinds."""

from collections.abc import Callable

import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

KINDS = ("conditional_integration", "back_calculation", "none")
GATES = {"ki": 3.0, "integral_zone": 0.25, "error_dead_band": 0.0625}


def charged(parameters: PidParameters) -> tuple[Pid, float]:
    """A controller whose integrator has worked, and its integral term."""
    pid = Pid(parameters)
    for _ in range(10):
        command = pid.update(Measurement(0, 0.0), ReferencePoint(0.125), 0.1)
    assert command.i == pytest.approx(9 * 3.0 * 0.125 * 0.1, rel=1e-13)
    return pid, command.i


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("error", [0.25, 0.26, 9.0, 0.0625, 0.06, -0.01, 0.0])
def test_outside_its_gates_the_integral_is_kept_exactly(
    bare: Make, kind: str, error: float
) -> None:
    """Pushed further beyond the zone, and within the dead-band, not a bit of it changes."""
    pid, before = charged(bare(**GATES, anti_windup=kind))
    assert [pid.update(Measurement(0, 0.0), ReferencePoint(error), 0.1).i for _ in range(50)] == [
        before
    ] * 50


@pytest.mark.parametrize("kind", KINDS)
def test_a_saturated_command_does_not_move_an_integral_that_holds(bare: Make, kind: str) -> None:
    """Beyond the zone, with the command saturated by feed-forward, the integral is kept."""
    pid, before = charged(bare(**GATES, anti_windup=kind, feedforward=100.0))
    found = [pid.update(Measurement(0, 0.0), ReferencePoint(0.5, 1.0), 0.1) for _ in range(20)]
    assert {command.voltage for command in found} == {10.0}
    assert {command.i for command in found} == {before}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("error", [-0.25, -0.3, -9.0])
def test_beyond_its_zone_an_integral_that_pushes_away_unwinds_to_nothing(
    bare: Make, kind: str, error: float
) -> None:
    """At the pace of the zone's edge, however large the error, and it stops at 0."""
    pid, before = charged(bare(**GATES, anti_windup=kind))
    found = [pid.update(Measurement(0, 0.0), ReferencePoint(error), 0.1).i for _ in range(8)]
    expected = [max(before - 3.0 * 0.25 * 0.1 * (k + 1), 0.0) for k in range(8)]
    assert found == pytest.approx(expected, rel=1e-12)
    assert found[-1] == 0.0


@pytest.mark.parametrize("error", [0.0626, 0.2, -0.2, -0.2499])
def test_between_its_gates_the_integral_moves(bare: Make, error: float) -> None:
    """Inside the zone and outside the dead-band every sample counts."""
    pid, before = charged(bare(**GATES))
    after = pid.update(Measurement(0, 0.0), ReferencePoint(error), 0.1).i
    assert after - before == pytest.approx(3.0 * error * 0.1, rel=1e-12)


def test_a_gap_keeps_the_integral_and_is_not_differentiated(bare: Make) -> None:
    """After hold() a carriage found 50 mm away gives no velocity and no integration."""
    pid, before = charged(bare(**GATES, kd=40.0))
    pid.hold()
    found = pid.update(Measurement(0, 0.05), ReferencePoint(0.175), 10.0)
    assert found.i == before
    assert found.d == 0.0


def test_after_a_gap_differentiation_starts_from_where_the_carriage_is(bare: Make) -> None:
    """The second sample after a gap sees the way from the first, not from before the gap."""
    held, fresh = Pid(bare(kd=2.0)), Pid(bare(kd=2.0))
    for k in range(30):
        held.update(Measurement(0, 0.01 * k), ReferencePoint(0.0), 0.01)
    held.hold()
    for pid in (held, fresh):
        pid.update(Measurement(0, 0.1), ReferencePoint(0.0), 0.01)
    expected = fresh.update(Measurement(0, 0.101), ReferencePoint(0.0), 0.01).d
    assert expected < 0.0
    assert held.update(Measurement(0, 0.101), ReferencePoint(0.0), 0.01).d == expected


def test_a_gap_before_the_first_sample_changes_nothing(bare: Make) -> None:
    """hold() on a new controller leaves it new."""
    held, fresh = Pid(bare(**GATES, kd=2.0)), Pid(bare(**GATES, kd=2.0))
    held.hold()
    for position in (0.0, 0.01):
        sample = (Measurement(0, position), ReferencePoint(0.1), 0.1)
        assert held.update(*sample) == fresh.update(*sample)


def test_within_the_dead_band_it_holds_even_beyond_a_smaller_zone(bare: Make) -> None:
    """A carriage at rest is not disturbed, whichever of the two is the larger."""
    pid, before = charged(bare(**GATES))
    pid.configure(bare(**{**GATES, "integral_zone": 0.03125}))
    found = [pid.update(Measurement(0, 0.0), ReferencePoint(-0.05), 0.1).i for _ in range(20)]
    assert found == [before] * 20
