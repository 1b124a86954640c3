# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session's samples against what they are named after."""

import time
from dataclasses import fields

import pytest

from rodless_control import Pid
from rodless_lab.session.samples import (
    TERMS,
    Cursor,
    LostSampleError,
    Received,
    Sample,
    Samples,
    Stamped,
    Unstamped,
)


def test_telemetry_has_the_terms_of_the_pid() -> None:
    """The session names the PID's terms as the law itself does, the reference first."""
    assert ("reference", *Pid.TERMS) == TERMS


def test_a_run_has_a_column_for_each_part_of_a_sample_and_each_term() -> None:
    """Samples are the fields of one sample, the voltage, and the terms, in this order."""
    names = (*Sample._fields, "voltage", *TERMS, "terms")
    assert tuple(field.name for field in fields(Samples)) == names


def received(joint: list[int], pressures: list[int]) -> Received:
    """Samples whose messages have these stamps (ms), sent 1 ns after the other."""
    found = Received()
    for sent, stamp in enumerate(joint):
        found.joint.put(Stamped(sent, 1_000_000 * stamp, (0.1, 0.0, 0.0)))
    for topic in found.pressures:
        for sent, stamp in enumerate(pressures):
            topic.put(Stamped(sent, 1_000_000 * stamp, (4e5,)))
    return found


def test_messages_of_two_instants_make_no_sample() -> None:
    """Where one topic has lost some, position and pressures would be of different times."""
    lossy = received([0, 1, 2, 3], [0, 1, 3, 4])
    assert lossy.sample(0, 1).time == 1e-3
    with pytest.raises(LostSampleError, match="samples were lost on their way"):
        Cursor(lossy).next()
    with pytest.raises(LostSampleError, match="samples were lost on their way"):
        lossy.samples(0)


def test_a_gap_in_all_topics_is_seen_in_the_run() -> None:
    """Each sample is whole, the run is not; one without gaps is."""
    assert len(received([0, 1, 2, 3], [0, 1, 2, 3]).samples(0)) == 4
    with pytest.raises(LostSampleError, match="samples were lost on their way"):
        received([0, 1, 3, 4], [0, 1, 3, 4]).samples(0)


def test_a_run_that_does_not_begin_at_sample_0_is_seen() -> None:
    """Its beginning has come and gone while nobody listened."""
    with pytest.raises(LostSampleError, match="samples were lost on their way"):
        received([5, 6, 7], [5, 6, 7]).samples(0)


def test_a_wall_clock_that_was_set_back_is_no_order_of_commands() -> None:
    """Commands are told apart by it: refused, rather than given to other samples."""
    found = received([0, 1, 2], [0, 1, 2])
    found.voltage.append(Unstamped(3, 6.0))
    assert found.samples(0).voltage[2] == 6.0
    for topic in found.topics:
        topic.put(topic.runs[0][2]._replace(stamp=3_000_000, sent=1))
    with pytest.raises(LostSampleError, match="the wall clock was set back during the run"):
        found.samples(0)


def test_nor_is_one_that_was_set_back_between_two_runs() -> None:
    """By the numbers alone the first command of the second run would answer in the first."""
    found = received([0, 1, 2], [0, 1, 2])
    for topic in found.topics:
        for one in topic.runs[0][:2]:
            topic.put(one._replace(sent=one.sent - 5))
    assert found.runs == 2
    for run in (0, 1):
        with pytest.raises(LostSampleError, match="set back during the run, or before the next"):
            found.samples(run)


def test_a_topic_that_leaves_a_run_alone_tears_it() -> None:
    """As by an older message of somebody else: no later sample would ever be complete."""
    torn = received([*range(300), 0], list(range(300)))
    assert len(torn.samples(0)) == 300
    for stamp in range(300, 500):
        for topic in torn.pressures:
            topic.put(Stamped(stamp, 1_000_000 * stamp, (4e5,)))
    with pytest.raises(LostSampleError, match="does somebody else publish on the plant's topics"):
        torn.complete(0)


def test_a_killed_plant_leaves_its_run_as_it_is() -> None:
    """Some messages of its last sample have not come; the next run begins all the same."""
    killed = received([*range(1, 51), 0, 1], [*range(1, 50), 0, 1, 2])
    assert (killed.complete(0), killed.complete(1)) == (49, 2)


def test_a_first_sample_that_is_offered_again_begins_no_run() -> None:
    """As to a controller that takes its time; one sent after a reset was asked for does.

    Those that were sent before it may come before or within the wait for it.
    """
    again = received([0, 0], [0, 0])
    assert (again.runs, again.complete(0)) == (1, 1)
    sample, earlier = (4e5, 0.0, 0.0), time.time_ns()
    again.joint.put(Stamped(earlier, 0, sample))
    with again.expecting_run():
        for topic in again.pressures:
            topic.put(Stamped(earlier, 0, sample))
        assert again.runs == 1
        for topic in again.topics:
            topic.put(Stamped(time.time_ns(), 0, sample))
    assert [len(topic.runs) for topic in again.topics] == [2] * 4
    assert again.runs == 2
