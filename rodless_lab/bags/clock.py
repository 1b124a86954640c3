# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Give recorded messages their time in the bag: plant time where there is a clock, else wall."""

import struct
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from enum import Enum, auto
from typing import NamedTuple

from rodless_base.constants import NANOSECONDS_PER_SECOND

# Clock messages remembered, to date messages that arrive late.
_REMEMBERED = 10_000

# How many polls a message waits for a clock message. One that was lost on the way and is sent
# again comes seconds late, and all after it with it.
POLLS = 100

# No message is under way for so long (ns): one that came earlier than the last clock message was
# sent, by more, came after it, by a wall clock that has been set back. A latched one was sent long
# ago.
LONGEST_UNDER_WAY = 60 * NANOSECONDS_PER_SECOND

# Messages of one topic that may wait for the first clock message.
WAITING = 20_000

_LITTLE_ENDIAN, _BIG_ENDIAN = struct.Struct("<iI"), struct.Struct(">iI")


class Arrival(NamedTuple):
    """A message as it came: ``sent`` and ``received`` by the wall clock, times in ns.

    ``stamp`` is the time in its header, ``clock`` the time it tells if it is a clock message.
    """

    topic: str
    data: bytes
    sent: int
    received: int
    sequence: int = 0
    stamp: int | None = None
    clock: int | None = None


class Timed(NamedTuple):
    """A message with its log and publication time in the bag (ns)."""

    arrival: Arrival
    log_time: int
    publish_time: int


class TimeBase(Enum):
    """What the times in a bag are: one thing for the whole bag."""

    UNKNOWN = auto()
    PLANT = auto()
    WALL = auto()


class BagClock:
    """Sorts out which time each message gets.

    In plant time, that is the stamp in its header, or for a message without one the time of the
    last clock message sent before it. Messages from different senders overtake each other on
    the way, so an unstamped message waits until a clock message that was sent after it has come,
    or for ``POLLS`` calls of :meth:`poll`. Before the first clock message nothing can be dated,
    and everything waits; once ``WAITING`` messages of a topic do, all get wall time, and it
    ``gave_up``. Messages of one topic keep their order. Senders on several machines must agree on
    the wall clock.
    """

    def __init__(self, base: TimeBase = TimeBase.UNKNOWN) -> None:
        self.base = base
        self.gave_up = False
        self._polls = 0
        # By topic, with the poll in which each message came.
        self._waiting: dict[str, deque[tuple[int, Arrival]]] = {}
        self._clock_sent: list[int] = []
        self._clock_time: list[int] = []

    def waits_since(self, received: int) -> bool:
        """Whether a message received before then (ns, wall clock) still waits."""
        return any(queue[0][1].received < received for queue in self._waiting.values())

    def put(self, arrival: Arrival) -> list[Timed]:
        """Take the next message that has come; return all that can be dated now."""
        long_ago = self._clock_sent[-1] - LONGEST_UNDER_WAY if self._clock_sent else 0
        latest = max(arrival.sent, arrival.received)
        before = self._leave_old_times() if latest < long_ago else []
        return before + self._put(arrival)

    def _put(self, arrival: Arrival) -> list[Timed]:
        if arrival.clock is not None:
            return [*self.tell(arrival.sent, arrival.clock), self._timed(arrival)]
        known = None if arrival.topic in self._waiting else self._known(arrival)
        if known is not None:
            return [known]
        queue = self._waiting.setdefault(arrival.topic, deque())
        queue.append((self._polls, arrival))
        if self.base is TimeBase.UNKNOWN and len(queue) >= WAITING:
            self.gave_up = True
            return self.finish()
        return []

    def tell(self, sent: int, clock: int) -> list[Timed]:
        """Take the time of a clock message; return the waiting messages it dates."""
        if self.base is TimeBase.WALL:
            return []
        self.base = TimeBase.PLANT
        before = self._leave_old_times() if self._clock_sent and sent < self._clock_sent[-1] else []
        self._clock_sent.append(sent)
        self._clock_time.append(clock)
        if len(self._clock_sent) > 2 * _REMEMBERED:
            del self._clock_sent[:-_REMEMBERED]
            del self._clock_time[:-_REMEMBERED]
        return before + self._take(lambda _, arrival: self._known(arrival))

    def _leave_old_times(self) -> list[Timed]:
        """Date what waits and forget the clock messages: the wall clock has been set back.

        Their times say nothing any more of what is sent from now on, but that it follows the last.
        """
        dated = self._take(lambda _, arrival: self._timed(arrival))
        self._clock_sent[:] = [0]
        del self._clock_time[:-1]
        return dated

    def poll(self) -> list[Timed]:
        """Return the messages that have waited for ``POLLS`` polls, with the best time known.

        None are returned while there is no clock.
        """
        if self.base is TimeBase.UNKNOWN:
            return []
        self._polls += 1
        due = self._polls - POLLS
        return self._take(lambda poll, arrival: self._timed(arrival) if poll <= due else None)

    def finish(self) -> list[Timed]:
        """Return all messages that still wait; without a clock, in wall time."""
        if self.base is TimeBase.UNKNOWN:
            self.base = TimeBase.WALL
        return self._take(lambda _, arrival: self._timed(arrival))

    def _take(self, timed: Callable[[int, Arrival], Timed | None]) -> list[Timed]:
        """Take from each topic's waiting messages those before the first that gets no time."""
        taken = []
        for topic, queue in list(self._waiting.items()):
            while queue and (one := timed(*queue[0])) is not None:
                taken.append(one)
                queue.popleft()
            if not queue:
                del self._waiting[topic]
        return taken

    def _known(self, arrival: Arrival) -> Timed | None:
        """Return it with its time, or None where that takes a clock message still to come."""
        if self.base is TimeBase.WALL:
            return Timed(arrival, arrival.received, arrival.sent)
        if self.base is TimeBase.UNKNOWN:
            return None
        time = arrival.clock
        if time is None and self._own_time(arrival):
            time = arrival.stamp
        if time is not None:
            return Timed(arrival, time, time)
        return self._told_before(arrival) if arrival.sent < self._clock_sent[-1] else None

    def _timed(self, arrival: Arrival) -> Timed:
        """Return it with the best time known by now."""
        return self._known(arrival) or self._told_before(arrival)

    def _told_before(self, arrival: Arrival) -> Timed:
        before = bisect_right(self._clock_sent, arrival.sent) - 1
        time = self._clock_time[max(before, 0)]
        return Timed(arrival, time, time)

    def _own_time(self, arrival: Arrival) -> bool:
        """Whether the stamp is plant time: set, and nearer to it than to the wall clock's."""
        if not arrival.stamp:
            return False
        to_plant = abs(arrival.stamp - self._clock_time[-1])
        return to_plant <= abs(arrival.stamp - arrival.received)


def leading_time(data: bytes) -> int:
    """Return the time (ns) that a message in CDR begins with: a stamp, or a clock's.

    A time before zero counts as 0: a bag has no such time, and anybody may send one.
    """
    # The second byte of the encapsulation header tells the byte order.
    stamp = _LITTLE_ENDIAN if data[1] & 1 else _BIG_ENDIAN
    seconds, nanoseconds = stamp.unpack_from(data, 4)
    return max(int(seconds * NANOSECONDS_PER_SECOND + nanoseconds), 0)
