# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who commands a plant in lock-step, as far as it is known, and what answers are owed."""

from collections.abc import Callable, Mapping

from rodless_base.ros.publish import UNKNOWN

# Publishers by what identifies them, with the names of their nodes.
Publishers = Mapping[bytes, str]

# Bytes of a GUID that all of one DDS participant share (DDSI-RTPS, 9.3.1: guidPrefix), as good as
# of one process. Where another middleware's identifiers have no such part, a new publisher is a new
# commander.
GUID_PREFIX = 12

# s within which what a publisher sent has come, once it is gone, even where others go on sending.
DRAINED = 0.5


class Account:
    """The answers that a commander owes, counted by their numbers where they have any.

    ``owed`` is how many it has still to give to what was offered; ``last`` the number of the last
    one. Numbers count those that were lost on the way, too.
    """

    def __init__(self) -> None:
        """Nothing has been offered, and nothing answered."""
        self.owed = 0
        self.last: int | None = None

    def offer(self) -> None:
        """Count an offer."""
        self.owed += 1

    def withdraw(self) -> None:
        """Take back an offer that has not gone out."""
        self.owed = max(self.owed - 1, 0)

    def is_due(self, number: int) -> bool:
        """Whether ``number`` is that of an answer to what was offered."""
        return self.last is not None and self.last < number <= self.last + self.owed

    def take(self, number: int | None) -> None:
        """Count the answer of ``number``, and those before it."""
        given = 1 if number is None or self.last is None else number - self.last
        self.owed = max(self.owed - given, 0)
        if number is not None:
            self.last = number


class Crowd:
    """Whether what comes may be sent by another than those who are known by name.

    That a publisher is connected is known before its name is, and while there are two, or what one
    of them sent may still come, no number tells whose it is.
    """

    def __init__(self, matched: Callable[[], int], now: Callable[[], float]) -> None:
        """``matched`` tells how many publishers are connected; ``now`` is in s."""
        self._matched = matched
        self._now = now
        self.is_here = False
        self.is_settled = True  # nobody is about to go, or has gone whose last ones may still come
        self._in_all = 0  # publishers that have been connected at some time
        self._named: set[bytes] = set()  # those of them that were known by name
        self._unnamed = 0
        self._may_come = False  # more of what was sent, since the last poll
        self._unsettled_at = 0.0

    def hear(self) -> None:
        """Take note that a command has come."""
        self._may_come = True

    def connect(self, in_all: int) -> None:
        """Take note of how many have been connected in all: one may have gone again since."""
        self._in_all = in_all

    def lose(self) -> None:
        """Take note that one has gone."""
        self.is_settled, self._may_come = False, True
        self._unsettled_at = self._now()

    def look(self, known: Publishers, before: Publishers) -> bool:
        """Return whether it is here, beside those who are ``known``.

        Where nobody is, somebody comes, who is one more than that if there was one ``before``.
        """
        self._named.update(known)
        # The name may be known first.
        unnamed, self._unnamed = self._unnamed, max(self._in_all - len(self._named), 0)
        if self._unnamed > unnamed or self._is_there(known, before):
            self.is_here = True
            self.lose()
        return self.is_here

    def poll(self, known: Publishers, before: Publishers) -> None:
        """See whether it has gone, and what it sent has come."""
        if self.is_settled or self._is_there(known, before):
            return
        is_late = self._now() - self._unsettled_at > DRAINED
        self.is_settled = not self._may_come or is_late
        self.is_here = self.is_here and not self.is_settled
        self._may_come = False

    def _is_there(self, known: Publishers, before: Publishers) -> bool:
        expected = len(known) or int(not before)
        return len(set(known.values())) > 1 or self._matched() > expected


def share_a_node(some: Publishers, others: Publishers) -> bool:
    """Whether a node has publishers among both: one that makes its own anew still owes answers."""
    return any(
        one[:GUID_PREFIX] == other[:GUID_PREFIX]
        and (name == its_name or UNKNOWN in (name, its_name))
        for one, name in some.items()
        for other, its_name in others.items()
    )
