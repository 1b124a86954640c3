# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Topics of which something is so for longer than it takes DDS to get to know what is there."""

from collections.abc import Callable, Iterable
from time import monotonic

# How often (s, wall clock) they are looked at, and for how long (s) it must have been so: names of
# nodes take a moment. Less has to do where there is no time left.
LOOK_PERIOD = 1.0
DURATION = 5.0
DURATION_AT_THE_END = 1.0


class LastingTopics:
    """Finds them: to be looked for by :meth:`look`, once in ``LOOK_PERIOD``."""

    def __init__(
        self, condition: Callable[[str], bool], clock: Callable[[], float] = monotonic
    ) -> None:
        """Know of none; ``condition`` tells whether it is so of a topic now; ``clock`` is in s."""
        self._condition = condition
        self._clock = clock
        self._since: dict[str, float] = {}
        self.found: list[str] = []

    def look(self, topics: Iterable[str], duration: float = DURATION) -> list[str]:
        """Return those of ``topics`` of which it has become known to be so."""
        now = self._clock()
        self._since = {
            topic: self._since.get(topic, now) for topic in topics if self._condition(topic)
        }
        new = [
            topic
            for topic, since in self._since.items()
            if now - since >= duration and topic not in self.found
        ]
        self.found += new
        return new
