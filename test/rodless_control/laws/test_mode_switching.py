# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The law that is the cascade while the reference moves, and the PID once it rests."""

import itertools
import math
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
    """Every command is the cascade's until 50 ms after the move, and from there on the PID's."""
    found, along, there = (answers(law, 200) for law in (ModeSwitching(), Cascade(), Pid()))
    follows = [k < 100 + round(REST / INTERVAL) - 1 for k in range(200)]
    assert [one.following == 1.0 for one in found] == follows
    expected = [(a if f else t).voltage for f, a, t in zip(follows, along, there, strict=True)]
    assert [one.voltage for one in found] == expected
    assert [one.following_voltage for one in found] == [one.voltage for one in along]
    assert [one.positioning_voltage for one in found] == [one.voltage for one in there]
    assert len(set(expected)) > 150


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


def test_without_a_rest_time_it_changes_at_once() -> None:
    """The first sample at rest is the PID's already."""
    found = answers(ModeSwitching({"mode_switching.rest_time": 0.0}), 110)
    assert [one.following for one in found] == [1.0] * 100 + [0.0] * 10


def test_no_finite_input_leaves_the_limits() -> None:
    """Readings and references up to 1e308, in any order, give commands in 0-10 V."""
    law = ModeSwitching()
    for k, (one, other) in enumerate(itertools.product(HOSTILE, HOSTILE)):
        measurement = Measurement(0, one, other, HOSTILE[k % 7], HOSTILE[k % 8])
        reference = ReferencePoint(other, HOSTILE[k % len(HOSTILE)])
        command = law.update(measurement, reference, (1e-3, 1e-9, 0.0, 10.0)[k % 4])
        assert 0.0 <= command.voltage <= 10.0


@pytest.mark.parametrize("at", [60, 180], ids=["following", "at rest"])
def test_new_gains_make_no_jump(at: int) -> None:
    """Evaluated again at the same instant both laws give the voltages they gave before."""
    law = ModeSwitching()
    answers(law, at)
    before = law.update(*sample(at - 1), 0.0)
    changes = {"cascade.position_gain": 1000.0, "controller.kp": 300.0}
    law.configure(law.parameters.with_values(changes))
    assert list(law.update(*sample(at - 1), 0.0)) == pytest.approx(list(before), abs=1e-9)
    fresh = ModeSwitching(changes)
    assert law.gains == fresh.gains


def test_after_a_gap_both_integrals_stay() -> None:
    """The filters start anew; what either law has integrated does not."""
    law = ModeSwitching({"controller.error_dead_band": 0.0, "cascade.integral_zone": 1.0})
    answers(law, 60)
    before = law.memory
    assert before.positioning.integral != 0.0
    assert before.following.drive.integral != 0.0
    law.hold()
    law.update(Measurement(0, 0.15, 3e5, 3e5, 6e5), ReferencePoint(0.15), 5.0)
    assert law.memory.positioning.integral == before.positioning.integral
    assert law.memory.following.drive.integral == before.following.drive.integral
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
