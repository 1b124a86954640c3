# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Topics of which something is so for longer than it takes DDS to get to know what is there."""

from collections import Counter
from collections.abc import Callable, Iterable

# How often (s, wall clock) they are looked at, and in how many looks one after the other it must be
# so: names of nodes take a moment. Fewer have to do where there is no time left.
LOOK_PERIOD = 1.0
LOOKS = 5
LOOKS_AT_THE_END = 2


class LastingTopics:
    """Finds them: to be looked for by :meth:`look`, once in ``LOOK_PERIOD``."""

    def __init__(self, is_so: Callable[[str], bool]) -> None:
        """Know of none; ``is_so`` tells whether it is so of a topic now."""
        self._is_so = is_so
        self._looks: Counter[str] = Counter()
        self.found: list[str] = []

    def look(self, topics: Iterable[str], enough: int = LOOKS) -> list[str]:
        """Return those of ``topics`` of which it has become known to be so."""
        self._looks = Counter(
            {topic: self._looks[topic] + 1 for topic in topics if self._is_so(topic)}
        )
        new = [
            topic
            for topic, looks in self._looks.items()
            if looks >= enough and topic not in self.found
        ]
        self.found += new
        return new
