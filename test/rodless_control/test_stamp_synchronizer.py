# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages combined to measurements by their stamp."""

import itertools
import math
import random

import pytest

from rodless_control import Measurement
from rodless_control.stamp_synchronizer import StampSynchronizer

CAPACITY = 100

FIELDS = ("position", "pressure_a", "pressure_b", "supply_pressure")


def sample(
    samples: StampSynchronizer, stamp: int, fields: tuple[str, ...] = FIELDS
) -> list[Measurement]:
    """Put all readings of one stamp, each its stamp plus its place, and return what they give."""
    found = [samples.put(field, stamp, stamp + FIELDS.index(field)) for field in fields]
    return [measurement for measurement in found if measurement is not None]


def expected(stamp: int) -> Measurement:
    """The measurement that :func:`sample` stands for."""
    return Measurement(stamp, stamp, stamp + 1, stamp + 2, stamp + 3)


def test_a_position_alone_is_a_measurement_without_pressures() -> None:
    """Where only positions are wanted each one counts at once, and its pressures are NaN."""
    found = StampSynchronizer(["position"], CAPACITY).put("position", 7, 0.05)
    assert found is not None
    assert found[:2] == (7, 0.05)
    assert all(map(math.isnan, found[2:]))


@pytest.mark.parametrize("order", [*itertools.permutations(FIELDS)])
def test_any_order_of_topics_gives_one_measurement(order: tuple[str, ...]) -> None:
    """The last of the four readings completes it, whichever that is, and no other."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    assert [samples.put(field, 5, FIELDS.index(field)) for field in order[:3]] == [None] * 3
    assert samples.put(order[3], 5, FIELDS.index(order[3])) == Measurement(5, 0, 1, 2, 3)
    assert samples.incomplete == 0


def test_topics_may_lag_behind_each_other() -> None:
    """In any merging of four ordered topics every sample comes out once, in order."""
    generator = random.Random(3)
    for _ in range(50):
        topics = {field: list(range(30)) for field in FIELDS}
        samples, found = StampSynchronizer(FIELDS, CAPACITY), []
        while topics:
            field = generator.choice(sorted(topics))
            stamp = topics[field].pop(0)
            found.append(samples.put(field, stamp, stamp + FIELDS.index(field)))
            if not topics[field]:
                del topics[field]
        assert [m for m in found if m is not None] == [expected(k) for k in range(30)]
        assert samples.incomplete == 0


def test_a_sample_that_lacks_a_pressure_is_dropped_with_the_next_complete_one() -> None:
    """Two samples without supply pressure never come out; they are counted once a third is whole.

    Their pressures do not turn up in a later measurement.
    """
    samples = StampSynchronizer(FIELDS, CAPACITY)
    assert sample(samples, 1, FIELDS[:3]) == sample(samples, 2, FIELDS[:3]) == []
    assert samples.incomplete == 0
    assert sample(samples, 3) == [expected(3)]
    assert samples.incomplete == 2
    assert samples.put("supply_pressure", 4, 0.0) is None


@pytest.mark.parametrize("first", FIELDS)
def test_a_reset_of_the_plant_starts_a_new_run(first: str) -> None:
    """Stamps from 0 again, topic by topic, while the old run's last messages still arrive."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    for stamp in range(3):
        assert sample(samples, stamp) == [expected(stamp)]
    others = tuple(field for field in FIELDS if field != first)
    assert samples.put(first, 0, FIELDS.index(first)) is None
    assert sample(samples, 3, others) == []
    assert sample(samples, 0, others) == [expected(0)]
    assert sample(samples, 1) == [expected(1)]
    assert samples.incomplete == 1


def test_a_reset_before_any_other_topic_has_come_is_its_first_run_too() -> None:
    """Pressures that are subscribed to late are first heard in the run after it, from 5 on."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    for stamp in (600, 610, 620, 0):
        assert sample(samples, stamp, FIELDS[:1]) == []
    for stamp in (5, 10):
        assert sample(samples, stamp) == [expected(stamp)]
    assert samples.incomplete == 4


@pytest.mark.parametrize("heard", [(), FIELDS[1:2], FIELDS[1:]], ids=len)
def test_a_reset_while_topics_come_up_holds_none_of_them_in_the_run_before(
    heard: tuple[str, ...],
) -> None:
    """Pressures, some of them heard already, come before the positions of the new run.

    By the topics alone those heard first then would be of the old run, and complete its position.
    """
    samples = StampSynchronizer(FIELDS, CAPACITY)
    whole = [expected(6)] if heard == FIELDS[1:] else []
    assert sample(samples, 5, FIELDS[:1]) == []
    assert sample(samples, 6, (*heard, FIELDS[0])) == whole
    found = [sample(samples, stamp, (*FIELDS[1:], FIELDS[0])) for stamp in range(8)]
    assert found[1:] == [[expected(stamp)] for stamp in range(1, 8)]


def test_readings_of_two_runs_are_never_combined() -> None:
    """An old run's reading at the same stamp does not complete a sample of the new run."""
    samples = StampSynchronizer(["position", "pressure_a"], CAPACITY)
    samples.put("pressure_a", 0, 100.0)
    samples.put("pressure_a", 1, 101.0)
    samples.put("position", 0, 0.0)
    samples.put("position", 0, 0.0)  # offered anew
    assert samples.put("pressure_a", 0, 200.0) is None
    samples.put("pressure_a", 1, 201.0)
    samples.put("position", 1, 0.1)
    found = [samples.put("position", 0, 0.2), samples.put("position", 1, 0.3)]
    assert [m.pressure_a for m in found if m is not None] == [200.0, 201.0]


def test_the_same_sample_again_is_a_measurement_again() -> None:
    """A lock-step plant offers a sample anew to a controller that has lost its answer."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    assert sample(samples, 0) == sample(samples, 0) == [expected(0)]
    assert sample(samples, 1) == [expected(1)]
    assert samples.incomplete == 0


@pytest.mark.parametrize("order", [*itertools.permutations(FIELDS)])
def test_what_comes_again_of_a_whole_sample_lacks_nothing(order: tuple[str, ...]) -> None:
    """A position whose pressures were not sent yet, and then all of that sample again."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    assert sample(samples, 0, FIELDS[:1]) == []
    assert sample(samples, 0, order) == [expected(0)]
    for stamp in (1, 2):
        assert sample(samples, stamp, order) == [expected(stamp)]
    assert samples.incomplete == 0


def test_memory_is_bounded_and_it_recovers() -> None:
    """A topic that never comes holds back no more than the capacity, and may then begin."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    for stamp in range(10 * CAPACITY):
        assert sample(samples, stamp, FIELDS[:3]) == []
        assert len(samples._waiting) <= CAPACITY
    stamp = 10 * CAPACITY
    assert sample(samples, stamp) == [expected(stamp)]
    assert samples.incomplete == stamp
    assert not samples._waiting


def test_runs_that_were_miscounted_are_found_again() -> None:
    """A topic that missed the reset altogether works again once the capacity is used up."""
    samples = StampSynchronizer(["position", "pressure_a"], CAPACITY)
    samples.put("position", 5, 0.0)
    found = []
    for stamp in range(2 * CAPACITY):
        samples.put("pressure_a", stamp, 0.0)
        found.append(samples.put("position", stamp, 0.0))
    assert [m.stamp for m in found[-10:] if m is not None] == [*range(2 * CAPACITY)][-10:]


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("backward", [(30,), (30, 31), (45, 2, 3, 1)])
def test_backward_stamps_on_one_topic_lose_their_own_samples_only(
    field: str, backward: tuple[int, ...]
) -> None:
    """A sensor that stamps wrongly for a moment is no reset of the plant."""
    samples, found = StampSynchronizer(FIELDS, CAPACITY), []
    for stamp in range(50, 200):
        wrong = backward[stamp - 100] if 0 <= stamp - 100 < len(backward) else stamp
        for other in FIELDS:
            given = wrong if other == field else stamp
            found.append(samples.put(other, given, stamp + FIELDS.index(other)))
    whole = [measurement for measurement in found if measurement is not None]
    lost = range(100, 100 + len(backward))
    assert whole == [expected(k) for k in range(50, 200) if k not in lost]
    assert samples.incomplete == 2 * len(backward)


def test_a_reset_after_a_backward_stamp_is_a_reset() -> None:
    """The runs are counted right again: old and new readings of one stamp do not meet."""
    samples = StampSynchronizer(FIELDS, CAPACITY)
    for stamp in range(5):
        sample(samples, stamp)
    samples.put("pressure_b", 2, 0.0)
    for stamp in (5, 6, *range(10)):
        assert sample(samples, stamp) == [expected(stamp)]
