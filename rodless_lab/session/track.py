# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the topics of a rig carry around a set-point, and what that says of the move; no ROS."""

import math
from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.topics import VALVE_VOLTAGE
from rodless_lab.runs.step_metrics import SETTLING_BAND, StepMetrics, step_metrics

# Plant time in ns for which the carriage must stay in the band to have settled.
STAY = NANOSECONDS_PER_SECOND // 2

# A reference that rests elsewhere for so long, in ns of wall-clock and of plant time, is not on its
# way.
LONG = NANOSECONDS_PER_SECOND


@dataclass(frozen=True)
class MoveResult:
    """How a move went.

    ``metrics`` is None where the carriage was there already. Times count from the first sample
    after which the reference changed, or from the sending, and then ``from_sending`` says why.
    ``position`` (m) is where the carriage was at the end.
    """

    settled: bool
    position: float
    metrics: StepMetrics | None
    from_sending: str | None


class Track:
    """Messages of one rig in the order they came; ``sent`` is when, in ns of wall clock."""

    def __init__(self, target: float) -> None:
        """Expect a move to ``target`` (m)."""
        self._target = target
        self._sent: list[int] = []
        self._stamps: list[int] = []
        self._positions: list[float] = []
        self._voltages: list[tuple[int, float]] = []
        self._references: list[float] = []
        self._first: int | None = None
        self._inside_since: int | None = None
        self._changed: int | None = None
        self._from_sending: str | None = None
        self._begun = 0
        # When a reference came first that rests elsewhere, and how long it has: each in wall-clock
        # and in plant time, ns.
        self._elsewhere: tuple[int, int] | None = None
        self._rested = (0, 0)
        self.was_reset = False

    def take_sample(self, sent: int, stamp: int, position: float) -> None:
        """Take a position (m) at plant time ``stamp`` (ns)."""
        if self._stamps and stamp < self._stamps[-1]:
            self.was_reset = True
        self._sent.append(sent)
        self._stamps.append(stamp)
        self._positions.append(position)
        # A sensor that is gone says NaN.
        if self._first is None or not abs(position - self._target) <= SETTLING_BAND:
            self._inside_since = None
        elif self._inside_since is None:
            self._inside_since = stamp

    def take_voltage(self, sent: int, voltage: float) -> None:
        """Take a command (V)."""
        self._voltages.append((sent, voltage))

    def take_reference(self, sent: int, reference: float) -> None:
        """Take the reference (m) that the controller follows."""
        before = self._references[-1] if self._references else reference
        self._references.append(reference)
        if self._first is not None and sent > self._begun:
            self._look_elsewhere(sent, reference, reference != before)
        if self._first is not None and self._changed is None and reference != before:
            self._changed = sent

    def _look_elsewhere(self, sent: int, reference: float, moves: bool) -> None:
        if moves or abs(reference - self._target) <= SETTLING_BAND:
            self._elsewhere = None
            return
        if self._elsewhere is None:
            self._elsewhere = sent, self._stamps[-1]
        self._rested = sent - self._elsewhere[0], self._stamps[-1] - self._elsewhere[1]

    def begin(self, sent: int = 0) -> None:
        """The set-point goes out now, at ``sent`` (ns of wall clock); a sample must have come."""
        self._begun = sent
        self._first = len(self._stamps) - 1
        self.was_reset = False
        last = self._references[-2:]
        if not last:
            self._from_sending = "the controller does not publish its reference"
        elif last[0] != last[-1]:
            self._from_sending = "the reference was moving already"
        elif last[-1] == self._target:
            self._from_sending = "the set-point was in force already"

    @property
    def has_samples(self) -> bool:
        """Whether a sample has come."""
        return bool(self._stamps)

    @property
    def has_commands(self) -> bool:
        """Whether a command to the valve has come."""
        return bool(self._voltages)

    @property
    def has_references(self) -> bool:
        """Whether the controller has said its reference."""
        return bool(self._references)

    @property
    def position(self) -> float:
        """The last position in m."""
        return self._positions[-1]

    @property
    def elapsed(self) -> float:
        """Plant time since the set-point went out, in s."""
        return (self._stamps[-1] - self._stamps[self._first or 0]) / NANOSECONDS_PER_SECOND

    @property
    def reference(self) -> float:
        """The last reference in m; NaN before one has come."""
        return self._references[-1] if self._references else math.nan

    @property
    def is_elsewhere(self) -> bool:
        """Whether references that came since the set-point went out have long rested elsewhere."""
        return self._elsewhere is not None and min(self._rested) > LONG and not self.has_settled

    @property
    def is_taken(self) -> bool:
        """Whether the reference has changed since the set-point went out, or was there already."""
        return self._changed is not None or self.reference == self._target

    @property
    def is_followed(self) -> bool:
        """Whether the reference has changed since the set-point went out, or need not."""
        return self._changed is not None or self._from_sending is not None

    @property
    def has_settled(self) -> bool:
        """Whether the carriage has stayed within ±0.2 mm for half a second of plant time."""
        since = self._inside_since
        return self.is_followed and since is not None and self._stamps[-1] - since >= STAY

    def result(self) -> MoveResult:
        """Measure the move; raises ValueError for commands that are missing or not finite."""
        assert self._first is not None
        first, why = self._first, self._from_sending
        if why is None and self._changed is not None:
            first = self._sample_of(self._changed)
        elif why is None:
            why = "the reference has not changed"
        start = self._positions[first]
        if abs(start - self._target) <= SETTLING_BAND:
            return MoveResult(self.has_settled, self.position, None, why)
        voltages = [value for sent, value in self._voltages if sent >= self._sent[first]]
        if not voltages:
            raise ValueError(f"no command on {VALVE_VOLTAGE} since the set-point")
        if not all(map(math.isfinite, voltages)):
            raise ValueError(f"a command on {VALVE_VOLTAGE} is not finite")
        metrics = step_metrics(
            np.array(self._stamps[first:]) / NANOSECONDS_PER_SECOND,
            np.array(self._positions[first:]),
            np.array(voltages),
            start=start,
            target=self._target,
            at=self._stamps[first] / NANOSECONDS_PER_SECOND,
        )
        if not self.has_settled:
            # In the band by the end, but not for long enough to be called settled.
            metrics = replace(metrics, settling_time=math.nan)
        return MoveResult(self.has_settled, self.position, metrics, why)

    def _sample_of(self, reference_sent: int) -> int:
        """Return the index of the sample that a reference belongs to.

        The controller sends a sample's command first and then its reference; the next sample may
        come in between.
        """
        commands = [sent for sent, _ in self._voltages]
        command = bisect_right(commands, reference_sent) - 1
        answered = commands[command] if command >= 0 else reference_sent
        return max(bisect_right(self._sent, answered) - 1, 0)
