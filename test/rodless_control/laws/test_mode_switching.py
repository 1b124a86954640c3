# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The law that is the cascade while the reference moves, and the PID once it rests."""

import math
import random
from typing import Any

import pytest

from rodless_control import Measurement, Pid, ReferencePoint
from rodless_control.laws.cascade import Cascade
from rodless_control.laws.mode_switching import ModeSwitching

INTERVAL = 1e-3
REST = 0.05
HOSTILE = (0.0, 0.05, -0.05, 1e3, -1e9, 1e308, -1e308, 5e-324)


def sample(k: int) -> tuple[Measurement, ReferencePoint]:
    """Sample ``k`` of a slow move with noise that ends at the hundredth."""
    moved = min(k, 100)
    position = 0.05 + 1e-5 * moved + 5e-6 * (-1) ** k
    pressures = 3.2e5 + 100.0 * moved, 3.1e5 - 80.0 * moved, 6e5
    velocity = 0.01 if k < 100 else 0.0
    measurement = Measurement(k * 1_000_000, position, *pressures)
    return measurement, ReferencePoint(0.0502 + 1e-5 * moved, velocity)


def answers(law: Any, count: int) -> list[Any]:
    """What a law says to the first ``count`` samples."""
    return [law.update(*sample(k), INTERVAL if k else 0.0) for k in range(count)]


def test_each_of_the_two_laws_answers_in_its_turn() -> None:
    """Every command is the cascade's until 50 ms after the move, and from there on the PID's.

    Without integrals: what becomes of those is tested below.
    """
    follower, holder = {"cascade.integral_gain": 0.0}, {"controller.ki": 0.0}
    laws = ModeSwitching({**follower, **holder}), Cascade(follower), Pid(holder)
    found, along, there = (answers(one, 200) for one in laws)
    follows = [k < 100 + round(REST / INTERVAL) - 1 for k in range(200)]
    assert [one.following == 1.0 for one in found] == follows
    expected = [(a if f else t).voltage for f, a, t in zip(follows, along, there, strict=True)]
    assert [one.voltage for one in found] == expected
    errors = [(a if f else t).error for f, a, t in zip(follows, along, there, strict=True)]
    assert [one.error for one in found] == errors
    assert [a.error for a in along] != [t.error for t in there]
    assert [one.following_voltage for one in found] == [one.voltage for one in along]
    assert [one.positioning_voltage for one in found] == [one.voltage for one in there]
    assert len(set(expected)) > 150


def test_a_law_integrates_in_its_turn_only() -> None:
    """Meanwhile the PID keeps what it has, and the cascade has nothing: neither winds up."""
    law = ModeSwitching({"controller.error_dead_band": 0.0, "cascade.integral_zone": 1.0})
    pid, cascade = [], []
    for k in range(300):
        law.update(*sample(k), INTERVAL if k else 0.0)
        pid.append(law.memory.positioning.integral)
        cascade.append(law.memory.following.drive.integral)
    last = 100 + round(REST / INTERVAL) - 2
    assert set(pid[: last + 1]) == {0.0}
    assert len(set(pid[last:])) == 300 - last
    assert 0.0 < cascade[1] < cascade[last]
    assert set(cascade[last + 1 :]) == {0.0}
    kept = pid[-1]
    for k in range(300, 310):
        measurement, reference = sample(k)
        law.update(measurement, reference._replace(velocity=0.01), INTERVAL)
    assert law.memory.positioning.integral == kept
    assert law.memory.following.drive.integral > 0.0


def test_steps_are_those_of_the_pid() -> None:
    """A reference that only jumps never moves: the PID alone has to do with it."""
    law, alone = ModeSwitching(), Pid()
    for k in range(300):
        measurement = Measurement(k * 1_000_000, 0.05 + 1e-4 * min(k, 80), 3.2e5, 3.1e5, 6e5)
        reference = ReferencePoint(0.05 if k < 10 else 0.058)
        command = law.update(measurement, reference, INTERVAL if k else 0.0)
        assert (
            command.voltage == alone.update(measurement, reference, INTERVAL if k else 0.0).voltage
        )


@pytest.mark.parametrize("velocity", [0.02, -0.02])
def test_either_direction_is_a_move(velocity: float) -> None:
    """The cascade follows it at once."""
    law = ModeSwitching()
    measurement, reference = sample(0)
    law.update(measurement, reference._replace(velocity=0.0), 0.0)
    found = law.update(measurement, reference._replace(velocity=velocity), INTERVAL)
    assert found.following == 1.0


def test_a_step_back_opens_the_valve_in_full() -> None:
    """Both laws want 0 V, and that is what comes out."""
    law = ModeSwitching({"controller.neutral_voltage": 4.9})
    for k in range(20):
        measurement = Measurement(k * 1_000_000, 0.15, 3e5, 3e5, 6e5)
        found = law.update(measurement, ReferencePoint(0.05), INTERVAL if k else 0.0)
    assert found.voltage == found.positioning_voltage == found.following_voltage == 0.0


def test_without_a_rest_time_it_changes_at_once() -> None:
    """The first sample at rest is the PID's already."""
    found = answers(ModeSwitching({"mode_switching.rest_time": 0.0}), 110)
    assert [one.following for one in found] == [1.0] * 100 + [0.0] * 10


@pytest.mark.parametrize("rest_time", [0.0, 0.05])
def test_no_finite_input_leaves_the_limits(rest_time: float) -> None:
    """Readings and references up to 1e308, in any order, give commands in 0-10 V from both laws."""
    law, dice, turns = (
        ModeSwitching({"mode_switching.rest_time": rest_time}),
        random.Random(1),
        set(),
    )
    for _ in range(2000):
        position, a, b, supply, wanted, velocity = (dice.choice(HOSTILE) for _ in range(6))
        reference = ReferencePoint(wanted, dice.choice([0.0, velocity]))
        interval = dice.choice((1e-3, 1e-9, 0.0, 10.0))
        command = law.update(Measurement(0, position, a, b, supply), reference, interval)
        assert 0.0 <= command.voltage <= 10.0
        turns.add(command.following)
    assert turns == {0.0, 1.0}


@pytest.mark.parametrize("at", [60, 120, 180], ids=["following", "soon at rest", "at rest"])
def test_new_gains_make_no_jump(at: int) -> None:
    """Evaluated again at the same instant the law whose turn it is gives the voltage of before."""
    law = ModeSwitching()
    answers(law, at)
    before = law.update(*sample(at - 1), 0.0)
    changes = {
        "cascade.position_gain": 1000.0,
        "controller.kp": 300.0,
        "mode_switching.rest_time": 0.5,
    }
    law.configure(law.parameters.with_values(changes))
    after = law.update(*sample(at - 1), 0.0)
    in_turn = "following_voltage" if before.following else "positioning_voltage"
    for term in ("voltage", "error", "following", in_turn):
        assert getattr(after, term) == pytest.approx(getattr(before, term), abs=1e-9)
    fresh = ModeSwitching(changes)
    assert law.gains == fresh.gains


@pytest.mark.parametrize(
    ("at", "change"),
    [(80, {"controller.kd": 200.0}), (190, {"cascade.static_friction": 40.0})],
    ids=["following", "at rest"],
)
def test_new_gains_of_the_other_law_leave_nothing_for_its_turn(
    at: int, change: dict[str, float]
) -> None:
    """As its turn comes the law answers as if it had had them all along, within 1 mV.

    It moved no command when it got them; what it took up then was a jump as its turn began, of
    1.3 V for the PID's damping and 1 V for the cascade's friction.
    """
    law, all_along = ModeSwitching(), ModeSwitching(change)
    turns = set()
    for k in range(300):
        if k == at:
            law.configure(law.parameters.with_values(change))
        measurement, reference = sample(k)
        if k >= 230:
            reference = reference._replace(velocity=0.01)
        interval = INTERVAL if k else 0.0
        found = law.update(measurement, reference, interval)
        expected = all_along.update(measurement, reference, interval)
        if k > at and found.following != (at == 80):
            turns.add(k)
            assert found.voltage == pytest.approx(expected.voltage, abs=1e-3)
    assert len(turns) >= 30


@pytest.mark.parametrize("velocity", [0.0, 0.01], ids=["at rest", "following"])
def test_after_a_gap_integrals_stay(velocity: float) -> None:
    """The filters start anew; what the law whose turn it is has integrated does not."""
    law = ModeSwitching({"controller.error_dead_band": 0.0, "cascade.integral_zone": 1.0})
    answers(law, 60 if velocity else 180)
    before = law.memory
    law.hold()
    law.update(Measurement(0, 0.15, 3e5, 3e5, 6e5), ReferencePoint(0.15, velocity), 5.0)
    assert law.memory.positioning.integral == before.positioning.integral
    if velocity:
        assert law.memory.following.drive.integral == before.following.drive.integral != 0.0
    else:
        assert before.positioning.integral != 0.0
    assert law.memory.following.known.motion.velocity == 0.0


@pytest.mark.parametrize("field", ["position", "pressure_a"])
@pytest.mark.parametrize("at", [60, 180], ids=["following", "at rest"])
def test_a_reading_that_is_not_finite_leaves_no_trace(at: int, field: str) -> None:
    """Neither law keeps it, whoever's turn it is; the next answer is as without it."""
    law, untouched = ModeSwitching(), ModeSwitching()
    for one in (law, untouched):
        answers(one, at)
    measurement, reference = sample(at)
    bad = law.update(measurement._replace(**{field: math.nan}), reference, INTERVAL)
    assert not math.isfinite(bad.voltage)
    assert law.update(measurement, reference, INTERVAL) == untouched.update(
        measurement, reference, INTERVAL
    )
