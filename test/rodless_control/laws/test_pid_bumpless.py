# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Changing gains while running does not move the command."""

import math

import pytest

from rodless_control import Measurement, Pid, PidParameters, ReferencePoint
from rodless_control.laws.parts.effort import VOLTAGE_REACH
from rodless_sim import Rig, RigParameters

# Small enough to keep the command of the default gains inside its limits.
POSITIONS = [1e-4 * k + 2e-5 * (-1) ** k for k in range(40)]
LEAD, VELOCITY, INTERVAL = 5e-4, 0.01, 0.01
CHANGES: list[dict[str, float]] = [
    {"controller.kp": 2000.0},
    {"controller.kp": 0.0},
    {"controller.ki": 500.0},
    {"controller.ki": 0.0},
    {"controller.kd": 5.0},
    {"controller.feedforward": 0.0},
    {"controller.filter_bandwidth": 300.0},
    {"controller.kp": 100.0, "controller.ki": 9.0, "controller.kd": 20.0},
    {"controller.kp": 1500.0, "controller.feedforward": 10.0},
]


def running() -> tuple[Pid, tuple[Measurement, ReferencePoint]]:
    """A controller in the middle of a move, and the sample it saw last (without its interval)."""
    pid = Pid(PidParameters())
    for position in POSITIONS:
        sample = (Measurement(0, position), ReferencePoint(position + LEAD, VELOCITY))
        command = pid.update(*sample, INTERVAL)
    assert 0.0 < command.voltage < 10.0
    assert all(abs(term) > 1e-3 for term in (command.p, command.i, command.d, command.feedforward))
    return pid, sample


@pytest.mark.parametrize("change", CHANGES, ids=" ".join)
def test_the_command_is_continuous(change: dict[str, float]) -> None:
    """The law evaluated again at the same instant gives the same voltage to rounding."""
    pid, sample = running()
    before = pid.update(*sample, 0.0).voltage
    pid.configure(PidParameters(change))
    assert pid.update(*sample, 0.0).voltage == pytest.approx(before, abs=1e-13)


def test_parking_that_is_switched_on_or_off_moves_no_command() -> None:
    """Parked, 1 % of the law acts: all of it, as that ended, was a jump.

    So was 1 % of it for a carriage on its way, which was parked at once.
    """
    free = PidParameters({"controller.ki": 0.0})
    parks = free.with_values({"controller.parking_error": 1e-3})
    there, away = (
        (Measurement(0, 0.1), ReferencePoint(0.1 + error, 0.0)) for error in (5e-4, 3e-3)
    )
    pid = Pid(parks)
    for _ in range(100):
        pid.update(*there, INTERVAL)
    parked = pid.update(*there, 0.0)
    assert parked.p == pytest.approx(0.01 * 800.0 * 5e-4)
    pid.configure(free)
    assert pid.update(*there, 0.0).voltage == pytest.approx(parked.voltage, abs=1e-13)
    pid.reset()
    for _ in range(100):
        command = pid.update(*away, INTERVAL)
    pid.configure(parks)
    assert pid.update(*away, INTERVAL) == command


@pytest.mark.parametrize("gains", [(800.0, 5000.0), (5000.0, 800.0)])
def test_what_does_not_show_at_a_limit_is_not_taken_up(gains: tuple[float, float]) -> None:
    """80 mm away the valve is full open with either gain: the offset would outlast the way there.

    At the target it would still have the valve full open, in the one direction or the other.
    """
    before, after = gains
    pid = Pid(PidParameters({"controller.kp": before, "controller.ki": 0.0}))
    away, there = (Measurement(0, 0.1 - error) for error in (0.08, 0.0))
    target = ReferencePoint(0.1, 0.0)
    assert pid.update(away, target, INTERVAL).voltage == 10.0
    pid.configure(PidParameters({"controller.kp": after, "controller.ki": 0.0}))
    assert pid.update(away, target, 0.0).voltage == 10.0
    assert pid.update(there, target, 0.0).i == 0.0


@pytest.mark.parametrize("error", [0.05, -0.05])
@pytest.mark.parametrize("gains", [(20.0, 800.0), (60.0, 5000.0), (5000.0, 20.0)])
def test_new_gains_that_reach_a_limit_move_no_command(
    gains: tuple[float, float], error: float
) -> None:
    """Half open with the old gain, full open with the new one, or back: it stays there."""
    before, after = gains
    pid = Pid(PidParameters({"controller.kp": before, "controller.ki": 0.0}))
    sample = Measurement(0, 0.1 - error), ReferencePoint(0.1, 0.0)
    command = pid.update(*sample, 0.0).voltage
    pid.configure(PidParameters({"controller.kp": after, "controller.ki": 0.0}))
    assert pid.update(*sample, 0.0).voltage == pytest.approx(command, abs=1e-12)


def test_what_is_taken_up_at_a_limit_counts_the_integral() -> None:
    """Full open by error and integral together: half the gain keeps that, and not a volt more.

    More would still hold the valve open where the error alone no longer does.
    """
    pid = Pid(PidParameters({"controller.ki": 500.0}))
    target = ReferencePoint(0.1)
    for k in range(2000):
        integral = pid.update(Measurement(0, 0.098), target, 1e-3 if k else 0.0).i
    assert 0.5 < integral < 0.5 * VOLTAGE_REACH
    away = Measurement(0, 0.1 - VOLTAGE_REACH / 800.0)
    assert pid.update(away, target, 0.0).voltage == 10.0
    pid.configure(PidParameters({"controller.kp": 400.0, "controller.ki": 500.0}))
    command = pid.update(away, target, 0.0)
    assert command.voltage == 10.0
    assert command.p + command.i == pytest.approx(VOLTAGE_REACH, abs=1e-9)


def test_gains_that_push_the_other_way_move_no_command() -> None:
    """Full open towards the target by the one gain, away from it by the other."""
    pid = Pid(PidParameters({"controller.kp": 5000.0, "controller.kd": 0.0}))
    for k in range(200):  # at 0.5 m/s, and 30 mm from its target
        sample = Measurement(0, 5e-4 * k), ReferencePoint(5e-4 * k + 0.03, 0.0)
        command = pid.update(*sample, 1e-3).voltage
    assert command == 10.0
    pid.configure(PidParameters({"controller.kp": 0.0, "controller.kd": 100.0}))
    assert pid.update(*sample, 0.0).voltage == 10.0


@pytest.mark.parametrize("change", CHANGES, ids=" ".join)
def test_the_new_gains_act_from_the_next_sample_on(change: dict[str, float]) -> None:
    """The terms are those of the new gains; the jump they make fades with the tracking time."""
    pid, sample = running()
    before = pid.update(*sample, 0.0)
    pid.configure(PidParameters(change))
    start = pid.update(*sample, 0.0)
    moved = pid.update(*sample, INTERVAL)
    number = PidParameters(change).number
    assert moved.p == pytest.approx(number("controller.kp") * LEAD, rel=1e-9)
    assert moved.feedforward == pytest.approx(number("controller.feedforward") * VELOCITY)
    grown = number("controller.ki") * LEAD * INTERVAL
    faded = (start.i - before.i) * -math.expm1(-INTERVAL / number("controller.tracking_time"))
    assert moved.i - start.i == pytest.approx(grown - faded, abs=1e-12)


@pytest.mark.parametrize("preset", ["paper", "calibrated"])
def test_a_change_in_mid_move_does_not_keep_the_carriage_off_its_target(preset: str) -> None:
    """A quarter more gain 0.1 s into the 58 mm step: after 5 s the carriage is within 0.2 mm."""
    rig, parameters = Rig(RigParameters.preset(preset)), PidParameters.preset(preset)
    pid = Pid(parameters)
    for k in range(5000):
        if k == 100:
            stronger = {"controller.kp": 1.25 * parameters.number("controller.kp")}
            pid.configure(parameters.with_values(stronger))
        rig.advance(
            pid.update(Measurement(0, rig.state.position), ReferencePoint(0.058), 1e-3).voltage,
            1e-3,
        )
    assert abs(rig.state.position - 0.058) < 2e-4


@pytest.mark.parametrize(
    "change",
    [
        {"controller.filter_bandwidth": 5.0},
        {"controller.filter_bandwidth": 100.0},
        {"controller.filter_bandwidth": 5000.0},
        {"controller.filter_bandwidth": 100.0, "controller.kp": 1600.0},
        {"controller.filter": "fading_memory"},
    ],
    ids=str,
)
@pytest.mark.parametrize("back", [False, True], ids=["there", "back"])
def test_another_filter_reads_the_same_speed(change: dict[str, float | str], back: bool) -> None:
    """At a steady 0.1 m/s every filter has that for the velocity: the damping stays at 6 V.

    A low-pass lags by what its bandwidth and the speed make. Another bandwidth would read another
    speed in that at the next sample: with 100 rad/s in place of 50, 12 V of damping and not 6.
    """
    there, other = PidParameters(), PidParameters(change)
    pid = Pid(other if back else there)
    for k in range(8000):
        place = 0.1e-3 * k
        sample = Measurement(k * 1_000_000, place), ReferencePoint(place + 1e-4, 0.1)
        command = pid.update(*sample, 1e-3 if k else 0.0)
        if k == 7000:
            pid.update(*sample, 0.0)  # once more
            pid.configure(there if back else other)
        if k >= 7000:
            assert command.d == pytest.approx(-6.0, rel=1e-9)


def test_changes_that_cancel_leave_no_trace() -> None:
    """There and back within one sample, the controller goes on as if nothing had been."""
    (pid, sample), (untouched, _) = running(), running()
    for gain in (3000.0, 800.0):
        pid.configure(PidParameters({"controller.kp": gain}))
    found, expected = pid.update(*sample, INTERVAL), untouched.update(*sample, INTERVAL)
    assert list(found) == pytest.approx(list(expected), abs=1e-12)


def test_the_same_gains_again_change_nothing_at_all() -> None:
    """Setting a parameter to the value it has keeps every bit."""
    (pid, sample), (untouched, _) = running(), running()
    pid.configure(PidParameters())
    assert pid.update(*sample, INTERVAL) == untouched.update(*sample, INTERVAL)


@pytest.mark.parametrize("change", [{"controller.kp": 50.0}, {"controller.filter_bandwidth": 5.0}])
def test_gains_may_change_before_the_first_sample(change: dict[str, float]) -> None:
    """A controller that has seen nothing has nothing to keep continuous."""
    pid = Pid(PidParameters())
    pid.configure(PidParameters(change))
    expected = Pid(PidParameters(change)).update(Measurement(0, 0.0), ReferencePoint(0.01), 0.0)
    assert pid.update(Measurement(0, 0.0), ReferencePoint(0.01), 0.0) == expected


def test_another_filter_after_the_first_sample_is_as_one_from_the_start() -> None:
    """No time has passed by then, in which one would have lagged."""
    other = PidParameters({"controller.filter_bandwidth": 5.0})
    changed, fresh = Pid(PidParameters()), Pid(other)
    for pid in (changed, fresh):
        pid.update(Measurement(0, 0.0), ReferencePoint(0.01), 0.0)
    changed.configure(other)
    sample = Measurement(1_000_000, 1e-4), ReferencePoint(0.01), 1e-3
    assert changed.update(*sample) == fresh.update(*sample)


@pytest.mark.parametrize("change", [{"controller.kp": 1e5}, {"controller.feedforward": 1e3}])
def test_a_change_under_a_wild_set_point_stays_finite(change: dict[str, float]) -> None:
    """A reference of 1e308 at the moment of the change does not end in NaN."""
    pid = Pid(PidParameters())
    pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 0.0)
    pid.update(Measurement(0, 0.0), ReferencePoint(1e308, 1e308), 1e-3)
    pid.configure(PidParameters(change))
    assert 0.0 <= pid.update(Measurement(0, 0.0), ReferencePoint(0.0), 1e-3).voltage <= 10.0
