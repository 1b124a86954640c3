# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Work on many items over all cores, the results in the order of the items."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from rodless_base.one_line import OneLineError, shown
from rodless_lab.simulation.design import is_whole

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_WORKERS = 1000

# Items per thread that are taken before the first of their results is due: enough to keep all busy
# where one takes much longer than the next, few enough to keep memory flat.
AHEAD = 8

# Items that each of the other threads has, while this one is busy with its own.
GIVEN = 4


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


def check_workers(workers: object) -> None:
    """Raise ValueError for what is no number of threads."""
    if workers is not None and not (is_whole(workers) and 1 <= workers <= MOST_WORKERS):
        raise OneLineError(f"workers {shown(workers)} refused: must be from 1 to {MOST_WORKERS}")


def in_order(
    work: Callable[[Item], Result], items: Iterable[Item], workers: int | None = None
) -> Iterator[Result]:
    """Yield ``work(item)`` of each item in their order, over ``workers`` threads (default: cores).

    The compiled loop releases the GIL, so threads run rigs at once. This thread is one of them: one
    more than there are cores would take turns with those that work. Only a few items per thread are
    taken ahead, so that ``items`` may be a generator of any length. The first item is worked on
    alone: what it compiles, the others find. An exception of ``work`` ends the run where its turn
    comes; no more than what was taken ahead has begun by then.
    """
    left = iter(items)
    for item in left:
        yield work(item)
        break
    count = cores() if workers is None else workers
    if count == 1:
        for item in left:
            yield work(item)
        return
    with ThreadPoolExecutor(count - 1) as others:
        waiting: deque[Future[Result]] = deque()
        try:
            for item in left:
                given = sum(not one.done() for one in waiting)
                free = given < GIVEN * (count - 1)
                waiting.append(others.submit(work, item) if free else _here(work, item))
                while waiting and (waiting[0].done() or len(waiting) == AHEAD * count):
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for one in waiting:
                one.cancel()


def _here(work: Callable[[Item], Result], item: Item) -> Future[Result]:
    """Work on an item in this thread."""
    found: Future[Result] = Future()
    try:
        found.set_result(work(item))
    except Exception as error:
        found.set_exception(error)
    return found
