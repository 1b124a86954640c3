# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Samples that have waited while the controller stood still: where the carriage was, not is.

Stopped for seconds, in a law that does not return for as long, or while another law is loaded, it
finds hundreds of them in its queues. Answered one by one, they drive the carriage by its past.
"""

from collections.abc import Callable
from time import monotonic

# Wall-clock s between two signs of life beyond which the controller has stood still.
STALL = 0.1

# s that a sample may be old at the end of a stall: one that comes in time is a little, too.
YOUNG = 0.02

# Wall-clock s after a stall in which samples are told apart. The sender's clock may have been set
# back meanwhile: then none seems to be new.
LONGEST = 2.0


class Stalls:
    """Tells samples that newer ones have passed while the controller stood still.

    The end of a stall by the sender's clock, which may be another machine's, follows from when it
    sent the last sample before, and the steady time that has passed since that was taken.
    """

    def __init__(self, interval: Callable[[], float], now: Callable[[], float] = monotonic) -> None:
        """Watch from now on; ``interval`` (s) is between samples, ``now`` a steady time in s."""
        self._interval = interval
        self._now = now
        self._alive = now()
        # The sender's clock less the steady one, as of the last sample that was no such one; s.
        self._offset: float | None = None
        self._end = 0.0  # of the last stall, by the sender's clock
        self._until = 0.0  # when to tell apart no longer, by the steady clock
        self.lasted = 0.0  # s, the last stall

    def poll(self) -> None:
        """Give a sign of life; to be called much more often than every ``STALL``."""
        now = self._now()
        stood, self._alive = now - self._alive, now
        if stood > STALL and self._offset is not None:
            self.lasted = stood
            self._end, self._until = now + self._offset, now + LONGEST

    @property
    def is_recent(self) -> bool:
        """Whether samples from before the end of a stall may still come."""
        return self._alive < self._until

    def was_passed(self, sent: float) -> bool:
        """Tell whether a newer sample waits behind one that was ``sent`` (s) before a stall ended.

        Where its sender sends none by the clock, that is wrong.
        """
        self.poll()
        if self.is_recent and self._end - sent > max(self._interval(), YOUNG):
            return True
        self._until = 0.0
        self._offset = sent - self._alive
        return False
