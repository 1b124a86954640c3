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
from collections import defaultdict, deque
from collections.abc import Callable
from enum import Enum, auto
from typing import NamedTuple

from rodless_base.constants import NANOSECONDS_PER_SECOND

# Clock messages remembered, to date messages that arrive late: at 1 kHz twice as long as a busy
# machine takes for ``POLLS``, for which those of a rig without a clock wait.
_REMEMBERED = 30_000

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
    ``clock_of`` names the clock of its rig, where that is another than the bag's.
    """

    topic: str
    data: bytes
    sent: int
    received: int
    sequence: int = 0
    stamp: int | None = None
    clock: int | None = None
    clock_of: str = ""


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


class _Course:
    """What a clock has told (ns), and when that was sent (ns, wall clock)."""

    def __init__(self) -> None:
        self.sent: list[int] = []
        self.time: list[int] = []

    def take(self, sent: int, clock: int) -> None:
        self.sent.append(sent)
        self.time.append(clock)
        if len(self.sent) > 2 * _REMEMBERED:
            del self.sent[:-_REMEMBERED]
            del self.time[:-_REMEMBERED]

    def leave_old_times(self) -> None:
        """Keep the last time alone, for whatever is sent from now on."""
        self.sent[:] = [0] * bool(self.sent)
        del self.time[:-1]

    def before(self, sent: int) -> int:
        """Return what was told last before something was sent; of what is earlier, the first."""
        return self.time[max(bisect_right(self.sent, sent) - 1, 0)]


class BagClock:
    """Sorts out which time each message gets.

    In plant time, that is the stamp in its header, or for a message without one the time of the
    last clock message sent before it. Messages from different senders overtake each other on
    the way, so an unstamped message waits until a clock message that was sent after it has come,
    or for ``POLLS`` calls of :meth:`poll`. Before the first clock message nothing can be dated,
    and everything waits; once ``WAITING`` messages of a topic do, all get wall time, and it
    ``gave_up``. Messages of one topic keep their order. Senders on several machines must agree on
    the wall clock.

    Of several rigs in a bag in plant time each has a clock of its own, which dates its messages;
    one that tells nothing for ``POLLS`` calls has none, and its rig's messages the bag's time.
    """

    def __init__(self, base: TimeBase = TimeBase.UNKNOWN) -> None:
        self.base = base
        self.gave_up = False
        self._polls = 0
        # By topic, with the poll in which each message came.
        self._waiting: dict[str, deque[tuple[int, Arrival]]] = {}
        # That of the bag stands under no name, those of further rigs under theirs.
        self._courses: defaultdict[str, _Course] = defaultdict(_Course)
        self._silent: set[str] = set()

    @property
    def _bags(self) -> _Course:
        return self._courses[""]

    def waits_since(self, received: int) -> bool:
        """Whether a message received before then (ns, wall clock) still waits."""
        return any(queue[0][1].received < received for queue in self._waiting.values())

    def put(self, arrival: Arrival) -> list[Timed]:
        """Take the next message that has come; return all that can be dated now."""
        told = self._bags.sent
        long_ago = told[-1] - LONGEST_UNDER_WAY if told else 0
        latest = max(arrival.sent, arrival.received)
        before = self._leave_old_times() if latest < long_ago else []
        return before + self._put(arrival)

    def _put(self, arrival: Arrival) -> list[Timed]:
        told = []
        if arrival.clock is not None:
            told = self.tell(arrival.sent, arrival.clock, arrival.clock_of)
        return told + self._date(arrival)

    def _date(self, arrival: Arrival) -> list[Timed]:
        """Return it with its time; or nothing, where it has to wait."""
        known = None if arrival.topic in self._waiting else self._known(arrival)
        if known is not None:
            return [known]
        queue = self._waiting.setdefault(arrival.topic, deque())
        queue.append((self._polls, arrival))
        if self.base is TimeBase.UNKNOWN and len(queue) >= WAITING:
            self.gave_up = True
            return self.finish()
        return []

    def tell(self, sent: int, clock: int, clock_of: str = "") -> list[Timed]:
        """Take the time of a clock message; return the waiting messages it dates."""
        if self.base is TimeBase.WALL:
            return []
        if not clock_of:
            self.base = TimeBase.PLANT
        course = self._courses[clock_of]
        before = self._leave_old_times() if course.sent and sent < course.sent[-1] else []
        course.take(sent, clock)
        return before + self._take(lambda _, arrival: self._known(arrival))

    def _leave_old_times(self) -> list[Timed]:
        """Date what waits and forget the clock messages: the wall clock has been set back.

        Their times say nothing any more of what is sent from now on, but that it follows the last.
        """
        dated = [] if self.base is TimeBase.UNKNOWN else self._take(lambda _, one: self._timed(one))
        for course in self._courses.values():
            course.leave_old_times()
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
        course = self._course(arrival)
        if time is None and self._own_time(arrival, course or self._bags):
            time = arrival.stamp
        if time is None and course is not None and arrival.sent < course.sent[-1]:
            time = course.before(arrival.sent)
        return None if time is None else Timed(arrival, time, time)

    def _course(self, arrival: Arrival) -> _Course | None:
        """Return what dates it; None where its rig's clock has told nothing yet and still may."""
        own = self._courses[arrival.clock_of]
        if own.sent:
            return own
        return self._bags if arrival.clock_of in self._silent else None

    def _timed(self, arrival: Arrival) -> Timed:
        """Return it with the best time known by now."""
        known = self._known(arrival)
        if known is not None:
            return known
        course = self._course(arrival)
        if course is None:
            self._silent.add(arrival.clock_of)
            course = self._bags
        time = course.before(arrival.sent)
        return Timed(arrival, time, time)

    def _own_time(self, arrival: Arrival, course: _Course) -> bool:
        """Whether the stamp is plant time: set, and nearer to it than to the wall clock's."""
        if not arrival.stamp:
            return False
        to_plant = abs(arrival.stamp - course.time[-1])
        return to_plant <= abs(arrival.stamp - arrival.received)


def leading_time(data: bytes) -> int:
    """Return the time (ns) that a message in CDR begins with: a stamp, or a clock's.

    A time before zero counts as 0: a bag has no such time, and anybody may send one.
    """
    # The second byte of the encapsulation header tells the byte order.
    stamp = _LITTLE_ENDIAN if data[1] & 1 else _BIG_ENDIAN
    seconds, nanoseconds = stamp.unpack_from(data, 4)
    return max(int(seconds * NANOSECONDS_PER_SECOND + nanoseconds), 0)
