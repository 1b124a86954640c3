# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lost messages of a topic are counted of each publisher by its own numbers."""

import pytest

from rodless_lab.bags.ros.publisher_counters import PublisherCounters

# Controllers started again and again, each heard for two messages, and the newest one's first.
AFTER_MANY = [k for n in range(50) for k in (1000 * (50 - n), 1000 * (50 - n) + 1)] + [1, 2, 3]


@pytest.mark.parametrize(
    ("numbers", "missed"),
    [
        ([1, 2, 3, 4], 0),
        ([7, 8, 9], 0),  # the recorder came later
        ([1, 2, 5, 6, 9], 4),
        ([100, 101, 1, 102, 2, 103, 104], 0),  # a stranger among the controller's
        ([100, 101, 1, 2, 104, 105], 2),  # of the controller's
        ([100, 101, 1, 2, 4, 102], 1),  # of the stranger's
        ([500, 1, 2, 3], 0),  # started again
        ([1, 1, 1, 2, 1], 0),  # who comes, sends and goes
        ([0, 0, 0], 0),  # a middleware that does not count
        ([*AFTER_MANY, 4, 5, 9, 10], 3),  # one that goes on after many that have ended
        ([k for n in range(1, 50) for k in (1000 * n, 1000 * n + 1)][::-1], 0),
    ],
)
def test_what_is_missing_is_counted_for_its_sender(numbers: list[int], missed: int) -> None:
    """By hand; numbers as they come."""
    counters = PublisherCounters()
    assert sum(counters.take(number) for number in numbers) == missed


@pytest.mark.parametrize(
    ("numbers", "turns"),
    [
        ([7, 8, 11], 0),
        ([500, 1, 2, 3], 1),  # started again
        ([100, 1, 101, 2, 102, 3], 3),  # two that take turns: each second number goes back
        ([0, 0, 0], 0),  # a middleware that does not count
    ],
)
def test_turns_are_numbers_that_go_back(numbers: list[int], turns: int) -> None:
    """By hand; one of them is a publisher started again, many are several at once."""
    counters = PublisherCounters()
    for number in numbers:
        counters.take(number)
    assert counters.turns == turns
