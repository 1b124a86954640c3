# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages that threads compress and write are put in the order in which they came.

The threads are made here: each takes the next message, holds it for a while, and writes it.
"""

import heapq
from itertools import pairwise
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodless_lab.bags.written_order import HELD_UP, in_order

MILLISECOND = 1_000_000


def as_threads_write(messages: int, threads: int, seed: int, long: float = 200.0) -> list[int]:
    """Return which message is written when: most are held for a moment, a few for ``long``."""
    random = Random(seed)
    busy: list[tuple[float, int]] = []
    written, now = [], 0.0
    for message in range(messages):
        if len(busy) == threads:
            now, done = heapq.heappop(busy)
            written.append(done)
        held = random.random() * (long if random.random() < 0.01 else 1.0)
        heapq.heappush(busy, (now + held, message))
    return written + [message for _, message in sorted(busy)]


def times_of(runs: list[int], period: int, start: int) -> list[int]:
    """The times of messages in ``runs`` of so many, each from ``start`` on."""
    return [start + k * period for length in runs for k in range(length)]


def sorted_back(times: list[int], written: list[int]) -> list[int]:
    """Return the messages in the order that is found for them as they were written."""
    return [written[place] for place in in_order([times[message] for message in written])]


SHARED = {
    "threads": st.integers(1, 16),
    "period": st.sampled_from([MILLISECOND, 2 * MILLISECOND, 5 * MILLISECOND]),
    "start": st.sampled_from([0, 5 * HELD_UP, 2**62]),
    "seed": st.integers(0, 2**32),
}


@given(runs=st.lists(st.integers(300, 700), min_size=1, max_size=4), **SHARED)
def test_each_run_is_found_whole(
    runs: list[int], threads: int, period: int, start: int, seed: int
) -> None:
    """A reset after 0.3 s, which no single message tells from one that was held up.

    Of 16 threads the slowest writes after 50 later messages.
    """
    times = times_of(runs, period, start)
    written = as_threads_write(sum(runs), threads, seed, long=1.5)
    assert sorted_back(times, written) == [*range(sum(runs))]


@pytest.mark.parametrize(
    ("runs", "apart"),
    [
        ([129, 128], True),
        ([200, 900, 200], True),
        ([128, 900], False),
        ([900, 127], False),
        ([500, 100, 500], False),
    ],
)
def test_a_reset_is_found_between_runs_of_enough_messages(runs: list[int], apart: bool) -> None:
    """Less than 129 and 128 messages might as well be one run whose threads write late."""
    times, messages = times_of(runs, MILLISECOND, 0), [*range(sum(runs))]
    assert (sorted_back(times, messages) == messages) is apart


@given(messages=st.integers(0, 600), **SHARED)
def test_without_a_reset_there_is_one_run(
    messages: int, threads: int, period: int, start: int, seed: int
) -> None:
    """However long a message is held: the thread that held it goes on with a later one.

    Up to a second, as far as times that are set back by more are resets of a run of few messages.
    """
    times = times_of([messages], min(period, MILLISECOND), start)
    written = as_threads_write(messages, threads, seed)
    assert sorted_back(times, written) == [*range(messages)]


@pytest.mark.parametrize("threads", [1, 4, 64])
def test_stragglers_are_no_reset(threads: int) -> None:
    """All threads but one hold a message until a hundred are written, and write them in a row."""
    messages = 600
    held = list(range(100, 100 + threads - 1))
    others = [message for message in range(messages) if message not in held]
    written = others[:300] + held + others[300:]
    assert sorted_back(times_of([messages], MILLISECOND, 0), written) == [*range(messages)]


def test_messages_of_one_time_stay_as_they_are() -> None:
    """Of a plant that is paused: nothing tells them apart."""
    assert in_order([7] * 1000) == [*range(1000)]
    assert in_order([]) == []


def test_a_few_messages_go_back_by_more_than_they_are_held_up() -> None:
    """Of set-points there are no hundred: by more than a second they are of another run."""
    seconds = [0, 2, 4, 1, 3, 5]
    assert in_order([second * HELD_UP for second in seconds]) == [0, 1, 2, 3, 4, 5]
    assert in_order([second * HELD_UP // 4 for second in seconds]) == [0, 3, 1, 4, 2, 5]


def test_times_that_fall_all_along_end() -> None:
    """What no recorder writes is put in some order, each message once, in time that is bounded."""
    falling = [2**62 - k**3 for k in range(20_000)]
    order = in_order(falling)
    assert sorted(order) == [*range(20_000)]
    assert any(falling[a] > falling[b] for a, b in pairwise(order))
