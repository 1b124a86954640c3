# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether the law keeps up with the samples, and which samples to leave out where it does not.

A law that takes longer than the samples are apart would be given ever older ones, and nothing else
of the node would get its turn: no service, no diagnostics.
"""

from collections import deque
from decimal import Decimal
from statistics import median

# A backlog: samples that have waited longer than this (s), for as long again and not less and less,
# as they do after a stall that is over.
BACKLOG = 0.1

# How many samples tell what is usual.
WINDOW = 15


class LawPace:
    """How long the law takes, how long samples wait for it, and which of them to skip."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self.skipped = 0
        self._taken: deque[float] = deque(maxlen=WINDOW)
        self._intervals: deque[float] = deque(maxlen=WINDOW)
        self._sent: float | None = None
        self._backlog: tuple[float, float] | None = None  # since when (s), and its wait (s) then
        self._behind = False
        self._skipped_before = 0
        # s, for a sample since the last news, and between the two before.
        self._longest = self._longest_before = 0.0
        # s that the controller stood still, likewise.
        self._stood = self._stood_before = 0.0

    def see(self, sent: float) -> None:
        """Take note of a sample, answered or not, that was published at ``sent`` (s).

        That may be of another machine's clock.
        """
        if self._sent is not None and sent > self._sent:
            self._intervals.append(sent - self._sent)
        self._sent = sent

    def must_skip(self, received: float, now: float) -> bool:
        """Tell whether to leave out a sample, because newer ones wait behind it.

        It has arrived at ``received``, and its turn comes ``now``, both in s.
        """
        waited = now - received
        self._behind = self._behind or self._is_backlog(waited, now)
        skip = self._behind and waited > self.interval
        self.skipped += skip
        return skip

    def _is_backlog(self, waited: float, now: float) -> bool:
        if waited <= BACKLOG:
            self._backlog = None
            return False
        if self._backlog is None or now < self._backlog[0]:
            # The first, or the first since the wall clock was set back.
            self._backlog = now, waited
        since, at_first = self._backlog
        return now - since > BACKLOG and waited >= at_first

    def pass_over(self, seconds: float) -> None:
        """Count a sample that a newer one passed while the controller stood still for so long."""
        self.skipped += 1
        self._stood = max(self._stood, seconds)

    def took(self, seconds: float) -> None:
        """Take note of how long the law has taken for a sample."""
        self._taken.append(seconds)
        self._longest = max(self._longest, seconds)

    @property
    def law_time(self) -> float:
        """What the law usually takes for a sample, in s; 0 before the first."""
        return median(self._taken) if self._taken else 0.0

    @property
    def interval(self) -> float:
        """What the samples usually are apart, in s; 0 before the second."""
        return median(self._intervals) if self._intervals else 0.0

    def news(self, law: str) -> str | None:
        """Return what to say of samples skipped since the last call, or None for none."""
        # What a long call makes wait may be skipped in the period after it.
        longest = max(self._longest, self._longest_before)
        stood = max(self._stood, self._stood_before)
        self._longest, self._longest_before = 0.0, self._longest
        self._stood, self._stood_before = 0.0, self._stood
        if self.skipped == self._skipped_before:
            # A backlog that goes on began before this report.
            self._behind = False
            return None
        self._skipped_before = self.skipped
        takes = f"{law} takes {_ms(self.law_time)} per sample of {_ms(self.interval)}"
        if self.law_time > 0.5 * self.interval:
            return f"{takes}: samples skipped; make it faster, or lengthen time.period"
        if longest > BACKLOG:
            once = f"{takes}, but once took {_ms(longest)}"
            return f"{once}: samples skipped; it waited, or the machine was too busy"
        if stood > 0.0:
            return (
                f"the controller stood still for {stood:.2f} s: samples skipped; it was stopped, "
                "had no processor, or loaded another law"
            )
        return f"machine too busy: samples skipped ({takes})"


def _ms(seconds: float) -> str:
    """Return a time in ms as people write it: to two significant digits, never with an exponent."""
    return f"{Decimal(f'{seconds * 1e3:.2g}'):f} ms"
