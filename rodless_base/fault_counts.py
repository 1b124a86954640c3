# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Counters of faults, as diagnostics show them: since start or reset, and in the last seconds."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from time import monotonic

# How far back, in s of the wall clock, a fault still raises the level of a diagnostic.
WINDOW = 10.0


class FaultCounts:
    """What differs between now, the last reset, and ``WINDOW`` s ago.

    Whoever meets a fault only ever adds to a total; these totals are given to :meth:`update`.
    """

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        """Begin with no faults; ``now`` is a steady time in s."""
        self._now = now
        self.clear({})

    def clear(self, totals: Mapping[str, int]) -> None:
        """Count from these totals on."""
        self._cleared = dict(totals)
        self._history = deque([(self._now(), self._cleared)])

    def update(self, totals: Mapping[str, int]) -> dict[str, int]:
        """Take the totals as they are now; return how many there are since the last clear."""
        now = self._now()
        self._history.append((now, dict(totals)))
        while self._history[1][0] <= now - WINDOW:
            self._history.popleft()
        return {name: total - self._cleared.get(name, 0) for name, total in totals.items()}

    def lately(self) -> dict[str, int]:
        """Return how many came in the last ``WINDOW`` s before the last update, where any did."""
        (_, before), (_, after) = self._history[0], self._history[-1]
        grown = {name: total - before.get(name, 0) for name, total in after.items()}
        return {name: count for name, count in grown.items() if count}


def lately_text(names: Iterable[str]) -> str | None:
    """Name the faults of the last seconds; None where there are none."""
    text = ", ".join(names)
    return f"in the last {WINDOW:g} s: {text}" if text else None
