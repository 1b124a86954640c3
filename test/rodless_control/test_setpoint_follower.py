# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Set-points as they arrive, and the reference made of them."""

import math
import re
from itertools import pairwise

import pytest

from rodless_control import ControllerParameters, ParameterError
from rodless_control.setpoint import SetpointFollower
from rodless_control.trajectory import Waypoint


def follower(kind: str = "setpoint", **values: object) -> SetpointFollower:
    """A follower of type ``kind`` that has seen nothing."""
    return SetpointFollower(parameters(kind, **values))


def parameters(kind: str, **values: object) -> ControllerParameters:
    """Parameters with a reference of type ``kind``."""
    given = {f"reference.{name}": value for name, value in values.items()}
    return ControllerParameters({"reference.type": kind, **given})


@pytest.mark.parametrize("kind", ["setpoint", "ramp", "move"])
def test_it_holds_the_carriage_where_it_is_found(kind: str) -> None:
    """Until a set-point comes the first position is the reference, however the carriage drifts."""
    found = follower(kind)
    assert found.sample(3.0, 0.07) == (0.07, 0.0)
    assert found.sample(4.0, 0.09) == (0.07, 0.0)


def test_a_set_point_acts_from_the_next_sample_on() -> None:
    """The type "setpoint" jumps there, without velocity, and again for each one that comes."""
    found = follower()
    found.sample(0.0, 0.0)
    for target in (0.058, 0.02, 0.058):
        found.receive(target)
        assert found.sample(1.0, 0.0) == (target, 0.0)
        assert found.sample(2.0, 0.0) == (target, 0.0)


@pytest.mark.parametrize("kind", ["setpoint", "ramp", "move"])
def test_a_set_point_may_come_before_the_first_sample(kind: str) -> None:
    """It is kept until the carriage is seen, and then gone to from there."""
    found = follower(kind, velocity=0.05)
    found.receive(0.058)
    start, _ = found.sample(7.0, 0.01)
    assert start == (0.058 if kind == "setpoint" else 0.01)
    assert found.sample(17.0, 0.01) == (0.058, 0.0)


def test_a_ramp_goes_at_its_velocity_from_where_the_reference_is() -> None:
    """A second set-point in mid-ramp turns the reference around without a jump."""
    found = follower("ramp", velocity=0.02)
    found.sample(0.0, 0.01)
    found.receive(0.05)
    assert found.sample(1.0, 0.01) == (0.01, 0.02)
    assert found.sample(2.0, 0.01) == (pytest.approx(0.03), 0.02)
    found.receive(0.02)
    assert found.sample(2.0, 0.01) == (pytest.approx(0.03), -0.02)
    assert found.sample(2.25, 0.01) == (pytest.approx(0.025), -0.02)
    assert found.sample(9.0, 0.01) == (0.02, 0.0)


def test_a_move_is_finished_before_the_latest_set_point_is_gone_to() -> None:
    """Of two set-points that come during a move the first is never gone to."""
    found = follower("move", velocity=0.05, acceleration=0.5, jerk=10.0)
    found.sample(0.0, 0.0)
    found.receive(0.05)
    times = [0.001 * k for k in range(6000)]
    track = []
    for k, time in enumerate(times):
        if k in (300, 400):
            found.receive(0.19 if k == 300 else 0.02)
        track.append(found.sample(time, 0.0)[0])
    first = 0.05 / 0.05 + 0.05 / 0.5 + 0.5 / 10.0
    second = 0.03 / 0.05 + 0.05 / 0.5 + 0.5 / 10.0
    assert max(track) == pytest.approx(0.05, abs=1e-15)
    arrived = next(time for time, x in zip(times, track, strict=True) if abs(x - 0.05) < 1e-12)
    assert arrived == pytest.approx(first, abs=2e-3)
    done = next(time for time, x in zip(times, track, strict=True) if x == 0.02 and time > first)
    assert done == pytest.approx(first + second, abs=2e-3)


def test_moves_in_a_row_keep_the_acceleration_limit() -> None:
    """With set-points coming all the time the sampled velocity never jumps."""
    found = follower("move", velocity=0.05, acceleration=0.5, jerk=10.0)
    velocities = []
    for k in range(5000):
        if k % 37 == 0:
            found.receive(0.1 + 0.1 * math.sin(k))
        velocities.append(found.sample(0.001 * k, 0.0)[1])
    steps = [abs(b - a) for a, b in pairwise(velocities)]
    assert 0.4e-3 < max(steps) <= 0.5e-3 * (1.0 + 1e-9)


def test_a_step_comes_from_the_parameters() -> None:
    """The position does not matter to it."""
    found = follower("step", start=0.01, target=0.06, at=0.5)
    assert found.sample(0.0, 0.03) == (0.01, 0.0)
    assert found.sample(0.499, 0.03) == (0.01, 0.0)
    assert found.sample(0.5, 0.03) == (0.06, 0.0)


def test_a_sine_comes_from_the_parameters() -> None:
    """It waits at its centre for its start and then swings: a quarter of 0.5 Hz takes 0.5 s."""
    found = follower("sine", centre=0.08, amplitude=0.03, frequency=0.5, at=2.0)
    assert found.sample(0.0, 0.0) == (0.08, 0.0)
    assert found.sample(2.5, 0.0)[0] == pytest.approx(0.11, rel=1e-14)
    assert found.sample(3.5, 0.0)[0] == pytest.approx(0.05, rel=1e-14)


@pytest.mark.parametrize("kind", ["sine", "step"])
def test_what_is_chosen_in_mid_run_starts_then(kind: str) -> None:
    """Chosen at 10 s with a start at 0.5 s it starts at the next sample, not in the past."""
    found = follower()
    found.sample(9.0, 0.05)
    found.configure(parameters(kind, at=0.5, centre=0.05, start=0.0, target=0.05))
    position, velocity = found.sample(10.0, 0.05)
    assert position == 0.05
    if kind == "sine":
        assert velocity == pytest.approx(0.02 * 2.0 * math.pi * 0.381, rel=1e-14)
        quarter = 10.0 + 0.25 / 0.381
        assert found.sample(quarter, 0.05)[0] == pytest.approx(0.07, rel=1e-12)


def test_a_changed_sine_starts_anew_and_other_parameters_leave_it_alone() -> None:
    """Its phase restarts with a new amplitude, not with a new gain, limit or other reference."""
    old = parameters("sine", at=0.0, frequency=1.0)
    found = SetpointFollower(old)
    found.sample(0.0, 0.0)
    beside = ("controller.kp", "reference.maximum", "reference.velocity", "reference.start")
    for name in beside:
        found.configure(old.with_values({name: 0.15}))
        assert found.sample(0.25, 0.0)[0] == pytest.approx(0.12, rel=1e-14), name
    found.configure(old.with_values({"reference.amplitude": 0.01}))
    assert found.sample(0.5, 0.0)[0] == 0.1
    assert found.sample(0.75, 0.0)[0] == pytest.approx(0.11, rel=1e-14)


def test_a_running_ramp_keeps_its_velocity() -> None:
    """A new velocity counts for the next set-point."""
    found = follower("ramp", velocity=0.02)
    found.sample(0.0, 0.0)
    found.receive(0.1)
    found.sample(0.0, 0.0)
    found.configure(parameters("ramp", velocity=0.05))
    assert found.sample(1.0, 0.0) == (pytest.approx(0.02), 0.02)
    found.receive(0.0)
    assert found.sample(1.0, 0.0) == (pytest.approx(0.02), -0.05)


@pytest.mark.parametrize(("kind", "start"), [("setpoint", 0.058), ("ramp", 0.03), ("move", 0.03)])
def test_the_last_set_point_stays_in_force_over_a_reset(kind: str, start: float) -> None:
    """The carriage, found elsewhere, is brought there again."""
    found = follower(kind)
    found.receive(0.02)
    found.receive(0.058)
    for k in range(5000):
        found.sample(0.001 * k, 0.0)
    found.reset()
    assert found.sample(0.0, 0.03)[0] == start
    for k in range(5000):
        position, _ = found.sample(0.001 * k, 0.03)
    assert position == 0.058


@pytest.mark.parametrize("kind", ["ramp", "move"])
def test_a_new_type_starts_from_the_carriage(kind: str) -> None:
    """Changing how set-points are gone to starts over from the position, to the same set-point."""
    found = follower()
    found.receive(0.058)
    found.sample(0.0, 0.0)
    found.configure(parameters(kind))
    assert found.sample(1.0, 0.04)[0] == 0.04
    assert found.sample(9.0, 0.04) == (0.058, 0.0)


@pytest.mark.parametrize("target", [math.nan, math.inf, -math.inf, 1e308, 58.0, 0.201, -0.001])
def test_a_set_point_that_no_rig_could_reach_is_refused(target: float) -> None:
    """Not finite, in millimetres or beyond: the message names it, and the reference stays."""
    found = follower()
    found.receive(0.058)
    with pytest.raises(ValueError, match=re.escape(f"{target!r}")):
        found.receive(target)
    assert found.sample(0.0, 0.0) == (0.058, 0.0)
    found.reset()
    assert found.sample(0.0, 0.0) == (0.058, 0.0)


@pytest.mark.parametrize("kind", ["sine", "step"])
def test_a_set_point_that_would_not_be_followed_is_refused(kind: str) -> None:
    """The line says why; neither it nor the one before it is gone to when the type changes."""
    found = follower()
    found.receive(0.02)
    found.sample(0.0, 0.0)
    found.configure(parameters(kind))
    during = found.sample(1.0, 0.0)
    with pytest.raises(ParameterError) as refusal:
        found.receive(0.1)
    assert str(refusal.value) == (
        f"set-point: 0.1 m ignored, reference.type is {kind}; "
        "set-points need setpoint, ramp or move"
    )
    assert found.sample(1.0, 0.0) == during
    found.configure(parameters("setpoint"))
    assert found.sample(2.0, 0.07) == found.sample(3.0, 0.09) == (0.07, 0.0)
    found.receive(0.1)
    assert found.sample(4.0, 0.07) == (0.1, 0.0)


def test_a_refusal_names_limits_and_the_way_out() -> None:
    """A set-point beyond the travel is answered with both limits and the parameter to change."""
    found = follower(minimum=0.01, maximum=0.15)
    with pytest.raises(ParameterError) as refusal:
        found.receive(0.16)
    assert str(refusal.value) == (
        "set-point: 0.16 m refused, must be from reference.minimum (0.01 m) to reference.maximum "
        "(0.15 m); change reference.maximum for another travel"
    )
    found.receive(0.15)
    found.receive(0.01)
    assert found.sample(0.0, 0.1).position == 0.01
    found.configure(parameters("setpoint", maximum=0.16))
    found.receive(0.16)
    assert found.sample(0.0, 0.1).position == 0.16


@pytest.mark.parametrize("position", [-0.0011, 0.2011])
def test_a_carriage_found_outside_the_travel_is_held_there(position: float) -> None:
    """A carriage that rests 1.1 mm beyond its end is no set-point: it stays where it is."""
    assert follower().sample(0.0, position) == (position, 0.0)


@pytest.mark.parametrize("kind", ["setpoint", "ramp", "move"])
def test_a_limit_must_leave_the_set_point_in_force_within(kind: str) -> None:
    """A move to 150 mm is not left alone by a limit of 100 mm: the limit is refused, by name."""
    found = follower(kind)
    found.check(parameters(kind, maximum=0.1))
    found.sample(0.0, 0.0)
    found.receive(0.15)
    found.sample(0.1, 0.0)
    for change in ({"maximum": 0.1}, {"minimum": 0.16}):
        ((name, value),) = change.items()
        line = f"reference.{name}: {value:g} m refused, the set-point in force is 0.15 m"
        with pytest.raises(ParameterError, match=re.escape(line)):
            found.check(parameters(kind, **change))
    found.check(parameters(kind, minimum=0.15, maximum=0.16))
    # At a limit is within it.
    target = found.target
    found.check(parameters(kind, maximum=target))
    found.check(parameters(kind, minimum=target))
    found.check(parameters("step", maximum=0.1))
    found.receive(0.05)
    if kind == "move":
        # It is finished first, up to 150 mm.
        line = "reference.maximum: 0.1 m refused, the move under way goes to 0.15 m"
        assert refusal(found, parameters(kind, maximum=0.1)) == f"{line}; wait for its end first"
        found.check(parameters("ramp", maximum=0.1))
        found.sample(9.0, 0.0)
    found.check(parameters(kind, maximum=0.1))


def refused_limits(found: SetpointFollower, kind: str = "setpoint") -> list[str]:
    """Try limits at every 10 mm, each alone; return those that are refused, in one line."""
    lines = {
        f"{name} {place}": refusal(found, parameters(kind, **{name: place / 100.0}))
        for name in ("minimum", "maximum")
        for place in range(1, 20)
    }
    refused = [limit for limit, line in lines.items() if line]
    for limit in refused:
        name, place = limit.split()
        start = f"reference.{name}: {int(place) / 100.0:g} m refused, the "
        assert re.fullmatch(re.escape(start) + ".* first", lines[limit]), lines[limit]
    return refused


def refusal(found: SetpointFollower, changed: ControllerParameters) -> str:
    """What a change is refused with, nothing where it is not."""
    try:
        found.check(changed)
    except ParameterError as error:
        return str(error)
    return ""


def limits_beyond(least: int, greatest: int) -> list[str]:
    """The limits, in cm, that leave out what goes from ``least`` to ``greatest``."""
    return [f"minimum {place}" for place in range(1, 20) if place > least] + [
        f"maximum {place}" for place in range(1, 20) if place < greatest
    ]


@pytest.mark.parametrize("kind", ["setpoint", "ramp", "move"])
def test_a_limit_must_leave_the_command_in_force_within(kind: str) -> None:
    """The last of a stream counts, before it is followed and after; a set-point replaces it."""
    found = follower(kind)
    found.sample(0.0, 0.0)
    found.receive_command(0.12, 0.0)
    found.receive_command(0.15, 0.3)
    assert refused_limits(found, kind) == limits_beyond(15, 15)
    found.sample(0.1, 0.0)
    assert refused_limits(found, kind) == limits_beyond(15, 15)
    with pytest.raises(ParameterError, match=r"the command in force is 0\.15 m; send another set-"):
        found.check(parameters(kind, maximum=0.1))
    found.receive(0.05)
    assert refused_limits(found, kind) == limits_beyond(5, 5)
    found.sample(0.2, 0.0)
    assert refused_limits(found, kind) == limits_beyond(5, 5)
    found.forget()
    assert refused_limits(found, kind) == []


def test_a_limit_must_leave_what_is_left_of_a_trajectory_within() -> None:
    """Waiting, under way and done: what has passed does not count, and other changes are free."""
    found = follower()
    points = [Waypoint(1.0, 0.15, 0.0), Waypoint(2.0, 0.055, 0.0), Waypoint(3.0, 0.08, 0.0)]
    found.receive_trajectory(points)
    # Where it begins is not known yet.
    assert refused_limits(found) == limits_beyond(5, 15)
    for time, least, greatest in (
        (0.0, 0, 15),
        (0.9, 5, 15),
        (1.5, 5, 11),
        (2.0, 5, 8),
        (2.5, 6, 8),
        (9.0, 8, 8),
    ):
        position = found.sample(time, 0.0).position
        assert refused_limits(found) == limits_beyond(least, greatest), (time, position)
    assert refused_limits(found, "ramp") == []
    found.receive_trajectory([Waypoint(1.0, 0.12)])
    with pytest.raises(ParameterError, match=r"the trajectory in force reaches 0\.12 m; send anot"):
        found.check(parameters("setpoint", maximum=0.1))
    found.receive(0.02)
    assert refused_limits(found) == limits_beyond(2, 2)


def test_what_leads_in_from_outside_refuses_no_other_parameter() -> None:
    """From 1 mm beyond its end a carriage is led in: a gain and the other limit may change."""
    found = follower()
    found.sample(0.0, -0.001)
    found.receive_trajectory([Waypoint(1.0, 0.05)])
    found.sample(0.1, -0.001)
    found.check(parameters("setpoint").with_values({"controller.kp": 1.0}))
    found.check(parameters("setpoint", maximum=0.1))
    with pytest.raises(ParameterError, match=r"reference\.minimum: 0\.01 m refused"):
        found.check(parameters("setpoint", minimum=0.01))
