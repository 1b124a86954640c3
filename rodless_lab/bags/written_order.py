# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The order in which messages came, where threads compressed and wrote them in another.

Each thread holds one message and then takes the next: what is written once a later message is there
is followed, at the latest after as many messages as there are threads, by one that is later still.
Where time stays back for longer than that, it was set back: the plant was reset.
"""

from collections.abc import Sequence

import numpy as np

from rodless_base.constants import NANOSECONDS_PER_SECOND

# ns, by which a message of few may be written after a later one.
HELD_UP = NANOSECONDS_PER_SECOND

# Messages in a row that are earlier than one before them: more than anybody has threads. So a run
# is told from the next one only where both have that many messages, and some more as are mixed.
STAY_BACK = 128

# By how many messages those right before and after a reset may be written too early or too late.
MIXED = STAY_BACK // 2


def in_order(log_time: Sequence[int]) -> list[int]:
    """Return the places of messages, shape (n,), in the order of ``log_time`` (ns, as written).

    Times go back only where they stay back, or by more than a message is held up.
    """
    apart, starts = _with_runs_apart(log_time)
    places = np.array(apart, dtype=np.intp)
    times = np.array(log_time, dtype=np.int64)[places]
    goes_back = np.diff(times, prepend=times[:1]) < -HELD_UP
    goes_back[starts] = True
    run = np.cumsum(goes_back)
    ordered: list[int] = places[np.lexsort((times, run))].tolist()
    return ordered


def _with_runs_apart(times: Sequence[int]) -> tuple[list[int], list[int]]:
    """Return the places of messages, run by run, and where a run starts as times stay back."""
    places, starts = list(range(len(times))), list[int]()
    begin, place, latest, behind = 0, 0, 0, 0  # latest: the place of the latest time of this run
    while place < len(times):
        time = times[places[place]]
        behind = behind + 1 if place > begin and time < times[places[latest]] else 0
        if behind == 0:
            latest = place
        place += 1
        if behind == STAY_BACK:
            begin = latest = place = _divide(places, times, begin, place)
            starts.append(begin)
            behind = 0
    return places, starts


def _divide(places: list[int], times: Sequence[int], begin: int, end: int) -> int:
    """Put what is of the next run behind what is of the last one; return where it starts.

    The messages before ``end``, STAY_BACK of them, stay back; the last run began at ``begin``.
    """
    # Where a run ends its times are high, where the next one begins they are low; those that are
    # written too late are lower than one before them in either.
    back = places[end - STAY_BACK : end]
    mixed = slice(max(begin, end - STAY_BACK - MIXED), end - STAY_BACK + MIXED)
    here = places[mixed]
    middle = (max(times[place] for place in here) + min(times[place] for place in back)) // 2
    latest, old, new = times[here[0]], list[int](), list[int]()
    for place in here:
        (new if times[place] < min(latest, middle) else old).append(place)
        latest = max(latest, times[place])
    places[mixed] = old + new
    return mixed.start + len(old)
