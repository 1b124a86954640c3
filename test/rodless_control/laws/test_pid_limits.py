# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The command stays within its limits, whatever comes in."""

import itertools
import math
import sys
from collections.abc import Callable

import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint

Make = Callable[..., PidParameters]

LARGEST = sys.float_info.max
HOSTILE = (0.0, 0.05, -0.05, 1e3, -1e9, 1e308, -1e308, LARGEST, -LARGEST, 5e-324)
KINDS = ("conditional_integration", "back_calculation", "none")
HARSH = {"controller.kp": 1e5, "controller.ki": 1e5, "controller.kd": 1e4}


def hostile_samples() -> list[tuple[Measurement, ReferencePoint, float]]:
    """Every pair of huge, tiny and plain references and positions, with velocities to match."""
    pairs = itertools.product(HOSTILE, HOSTILE)
    return [
        (
            Measurement(0, position),
            ReferencePoint(reference, HOSTILE[k % len(HOSTILE)]),
            (1e-3, 1e-9, 0.0, 10.0)[k % 4],
        )
        for k, (reference, position) in enumerate(pairs)
    ]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("gains", [{}, {"controller.kd": 0.0}, {"controller.kp": 0.0}, HARSH])
@pytest.mark.parametrize("zone", [2.5e-3, 10.0])
def test_no_finite_input_leaves_the_limits(kind: str, gains: dict[str, float], zone: float) -> None:
    """Samples up to the largest float, in any order, give commands from 0 to 10 V."""
    changes = {"controller.anti_windup": kind, "controller.integral_zone": zone}
    pid = Pid(PidParameters({**changes, **gains, "controller.feedforward": 1e3}))
    samples = hostile_samples()
    for sample in samples + samples[::-1] + samples[::7]:
        assert 0.0 <= pid.update(*sample).voltage <= 10.0


@pytest.mark.parametrize("wild", [1e308, -1e308])
def test_a_wild_sample_passes(wild: float) -> None:
    """After positions of ±1e308 the controller comes to rest like one that never saw them."""
    pid = Pid(PidParameters())
    pid.update(Measurement(0, 0.05), ReferencePoint(0.05), 0.0)
    for position in (wild, -wild, wild):
        pid.update(Measurement(0, position), ReferencePoint(0.05), 1e-3)
    voltages = [
        pid.update(Measurement(0, 0.05), ReferencePoint(0.05), 1e-3).voltage for _ in range(2000)
    ]
    assert voltages[-1] == pytest.approx(5.08, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_wild_set_point_passes(kind: str) -> None:
    """A reference of 1e308 m asks for 10 V, and nothing is left of it when it is withdrawn."""
    pid = Pid(PidParameters({"controller.anti_windup": kind}))
    pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    assert [
        pid.update(Measurement(0, 0.0), ReferencePoint(1e308), 1e-3).voltage for _ in range(5)
    ] == [10.0] * 5
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 1e-3).voltage == 5.08


@pytest.mark.parametrize("beyond", [1000.5, 1e9, LARGEST])
def test_lengths_and_speeds_past_a_thousand_count_as_a_thousand(bare: Make, beyond: float) -> None:
    """A kilometre and 1000 m/s, either way: reference, position and feed-forward; 999 stays 999."""
    pid = Pid(bare(kp=1.0, feedforward=1.0))
    for side in (1.0, -1.0):
        far = pid.update(Measurement(0, 0.0), ReferencePoint(side * beyond, side * beyond), 1e-3)
        assert (far.p, far.feedforward) == (side * 1000.0, side * 1000.0)
        assert pid.update(Measurement(0, side * beyond), ReferencePoint(0.0), 1e-3).p == -far.p
        near = pid.update(Measurement(0, 0.0), ReferencePoint(side * 999.0, side * 999.0), 1e-3)
        assert (near.p, near.feedforward) == (side * 999.0, side * 999.0)


@pytest.mark.parametrize(("low", "high"), [(0.0, 10.0), (2.0, 8.0), (4.9, 5.2)])
def test_the_limits_are_reached_and_kept(bare: Make, low: float, high: float) -> None:
    """Errors that ask for more than the limits get the limits, others what they ask for."""
    pid = Pid(bare(kp=1.0, minimum_voltage=low, maximum_voltage=high))
    for error in (-9.0, -0.07, 0.0, 0.15, 9.0):
        wanted = min(max(5.0 + error, low), high)
        assert pid.update(
            Measurement(0, 0.0), ReferencePoint(error), 1e-3
        ).voltage == pytest.approx(wanted, rel=1e-15)


def test_feedforward_is_inside_the_limits(bare: Make) -> None:
    """A reference that is too fast saturates the command, it does not push it past the limits."""
    pid = Pid(bare(kp=10.0, feedforward=100.0))
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.1, 0.2), 0.0).voltage == 10.0
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.1, -0.2), 1e-3).voltage == 0.0
    assert pid.update(
        Measurement(0, 0.0), ReferencePoint(0.1, -0.02), 1e-3
    ).voltage == pytest.approx(4.0, rel=1e-14)


def test_saturation_by_feedforward_stops_the_integrator(bare: Make) -> None:
    """The anti-windup sees the whole command, feed-forward included."""
    pid = Pid(bare(ki=1.0, feedforward=100.0, anti_windup="conditional_integration"))
    assert [pid.update(Measurement(0, 0.0), ReferencePoint(0.1, 1.0), 0.1).i for _ in range(9)] == [
        0.0
    ] * 9
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.1), 0.1).i == pytest.approx(
        0.01, rel=1e-14
    )


def test_dead_zone_voltage_is_inside_the_limits(bare: Make) -> None:
    """Crossing the valve's flat centre adds nothing past a limit."""
    pid = Pid(bare(kp=1.0, dead_zone_voltage=2.0, dead_zone_width=0.01, maximum_voltage=6.5))
    assert pid.update(Measurement(0, 0.0), ReferencePoint(1.0), 0.0).voltage == 6.5
    assert math.isclose(
        pid.update(Measurement(0, 0.0), ReferencePoint(-1.0), 1e-3).voltage, 2.0, rel_tol=1e-14
    )
