# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a session keeps up with what its rig sends: what it knows is old where it does not."""

import time
import warnings

# A session this far behind (s, wall clock), for at least as long, is told of.
LAG_THRESHOLD = 1.0


class LagWarning(RuntimeWarning):
    """A session knows of its rig only what was some time ago."""


class LagWatch:
    """Warns once where samples stay more than ``LAG_THRESHOLD`` old while the session waits."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._lag = 0.0
        # By how much (s) the session was behind when it fell behind, and how long (s) it has waited
        # since then.
        self._lag_at_onset: float | None = None
        self._waited = 0.0
        self._looked = 0.0
        self._has_news = False
        self._told = False

    def take(self, sent: int) -> None:
        """Take note of a sample that was ``sent`` (ns, wall clock) and comes now."""
        self._lag = (time.time_ns() - sent) * 1e-9
        self._has_news = True
        if self._lag < LAG_THRESHOLD:
            self._lag_at_onset = None
        elif self._lag_at_onset is None:
            self._lag_at_onset, self._waited = self._lag, 0.0
            self._looked = time.monotonic()

    def begin(self) -> None:
        """Begin to wait: what the test computes between two waits does not count."""
        self._looked = time.monotonic()

    def check(self) -> None:
        """Warn where the session has been behind for a while of waiting and does not catch up."""
        now = time.monotonic()
        before, self._looked = self._looked, now
        if not self._has_news:
            return  # of a plant that is paused or frozen the last sample grows old
        self._has_news = False
        self._waited += now - before
        if self._told or self._lag_at_onset is None or self._waited < LAG_THRESHOLD:
            return
        if self._lag < self._lag_at_onset:  # it catches up: is it at it still, a while later?
            self._lag_at_onset, self._waited = self._lag, 0.0
            return
        self._told = True
        warnings.warn(
            f"this session is {self._lag:.1f} s behind its rig, and so are the samples, "
            "diagnostics and new subscriptions that it knows of: the machine is too busy, or more "
            "comes than it can take; receive less (telemetry, subscriptions), lengthen "
            "time.period, or use mode='lockstep'",
            LagWarning,
            stacklevel=1,
        )
