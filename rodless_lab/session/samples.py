# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The messages of a rig, put together to samples: one row per instant of plant time."""

import math
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns
from rodless_base.constants import NANOSECONDS_PER_SECOND, SECONDS_PER_NANOSECOND

Array = npt.NDArray[np.float64]

# What the PID publishes of itself, the reference first.
TERMS = ("reference", "error", "p", "i", "d", "feedforward")


# Samples by which the topics of a run that is over may differ: a plant that was killed leaves some
# of them behind, as many as waited to be sent.
LARGEST_DIFFERENCE = 100

SET_BACK = (
    "the wall clock was set back during the run, or before the next: by the times at which they "
    "were sent no command can be told to answer one sample or the next; run it once more"
)

LOST = (
    "samples were lost on their way: did the test compute for long, or was it held, without "
    "letting the session run, or is the machine too busy? Or does somebody else publish on the "
    "plant's topics?"
)


class LostSampleError(RuntimeError):
    """Messages of samples have not arrived, or are somebody else's."""


class Sample(NamedTuple):
    """The plant at one instant: s, m, m/s, N, Pa absolute."""

    time: float
    position: float
    velocity: float
    force: float
    pressure_a: float
    pressure_b: float
    supply_pressure: float


@dataclass(frozen=True)
class Samples(Columns):
    """A run as arrays, one entry per sample, SI; named like ``rodless_sim.Trace``.

    ``voltage[k]`` is the last command sent after sample k and before sample k+1, NaN where there
    was none. ``reference``, ``error`` (m), ``p``, ``i``, ``d`` and ``feedforward`` (V) belong to
    that command, NaN where there was none, where its law has no such term, and in a session without
    telemetry. In lock-step it answers sample k; in real time, on a busy machine, it may answer one
    before. ``terms`` holds the TERMS of the law that its controller began with, by name.
    """

    time: Annotated[Array, "s"]
    position: Annotated[Array, "m"]
    velocity: Annotated[Array, "m/s"]
    force: Annotated[Array, "N"]
    pressure_a: Annotated[Array, "Pa"]
    pressure_b: Annotated[Array, "Pa"]
    supply_pressure: Annotated[Array, "Pa"]
    voltage: Annotated[Array, "V"]
    reference: Annotated[Array, "m"]
    error: Annotated[Array, "m"]
    p: Annotated[Array, "V"]
    i: Annotated[Array, "V"]
    d: Annotated[Array, "V"]
    feedforward: Annotated[Array, "V"]
    terms: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)


class Stamped(NamedTuple):
    """A message of the plant: when it was sent (ns, wall clock), plant time (ns), content."""

    sent: int
    stamp: int
    values: tuple[float, ...]


class PlantTopic:
    """What has come on one topic of the plant, run by run: a reset starts a new one."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self.runs: list[list[Stamped]] = []
        # From when on (ns, wall clock) sample 0 after sample 0 begins a run; before, and where it
        # is None, it is the same one offered again.
        self.run_expected_since: int | None = None
        # How often lock-step has offered a sample again, by its run and index: as where commanders
        # come and go.
        self.offered_again: Counter[tuple[int, int]] = Counter()
        self._offered = 0  # when the last one was, the last time (ns, wall clock)

    def is_over(self, run: int) -> bool:
        """Whether a later run has begun."""
        return run + 1 < len(self.runs)

    def put(self, message: Stamped) -> None:
        """Take the next message."""
        last = self.runs[-1][-1].stamp if self.runs else math.inf
        if message.stamp == last and (last > 0 or not self._begins_anew(message)):
            # The middleware, too, may deliver one again, where it had taken the plant for gone.
            if message.sent > self._offered:
                self.offered_again[len(self.runs) - 1, len(self.runs[-1]) - 1] += 1
                self._offered = message.sent
            return
        if message.stamp <= last:
            self.runs.append([])
        self.runs[-1].append(message)
        self._offered = message.sent

    def _begins_anew(self, message: Stamped) -> bool:
        return self.run_expected_since is not None and message.sent >= self.run_expected_since


class Unstamped(NamedTuple):
    """A message without a stamp: when it was sent (ns, wall clock) and its number."""

    sent: int
    value: float


def instant(time: float) -> int:
    """Return plant ``time`` (s) in whole nanoseconds: sums of decimals are not what they look."""
    return round(time * NANOSECONDS_PER_SECOND)


@dataclass
class Received:
    """Everything that has come so far.

    Each run of the plant is complete from its sample 0 on: the plant waits for its recorders.
    """

    joint: PlantTopic = field(default_factory=PlantTopic)
    pressures: tuple[PlantTopic, PlantTopic, PlantTopic] = field(
        default_factory=lambda: (PlantTopic(), PlantTopic(), PlantTopic())
    )
    voltage: list[Unstamped] = field(default_factory=list)
    answers: list[Unstamped] = field(default_factory=list)
    # Of the reference and of each term of the controller's law, by name.
    terms: dict[str, list[Unstamped]] = field(default_factory=dict)
    # Runs whose plant was ended: what was on its way ended with it, of one topic more than another.
    cut_short: set[int] = field(default_factory=set)

    @property
    def topics(self) -> tuple[PlantTopic, ...]:
        """Those of the plant."""
        return (self.joint, *self.pressures)

    @contextmanager
    def expecting_run(self) -> Iterator[None]:
        """Let the plant begin anew in the block, be it from a run that has sample 0 alone."""
        self._expect_run(time.time_ns())
        try:
            yield
        finally:
            self._expect_run(None)

    def _expect_run(self, since: int | None) -> None:
        for topic in self.topics:
            topic.run_expected_since = since

    def cut_run_short(self) -> None:
        """Take note that the plant is ended in the run that it is in."""
        runs = max(len(topic.runs) for topic in self.topics)
        if runs:
            self.cut_short.add(runs - 1)

    @property
    def runs(self) -> int:
        """Number of runs of which a sample is complete."""
        return next((r for r in range(len(self.joint.runs), 0, -1) if self.complete(r - 1)), 0)

    def complete(self, run: int) -> int:
        """Number of samples of a run (0, 1, …) of which every message has come.

        Raises LostSampleError where a topic has left a run that others are still in, by more than
        ``LARGEST_DIFFERENCE``, unless its plant was ended.
        """
        topics = self.topics
        counts = [len(topic.runs[run]) if run < len(topic.runs) else 0 for topic in topics]
        over = [count for count, topic in zip(counts, topics, strict=True) if topic.is_over(run)]
        largest = math.inf if run in self.cut_short else LARGEST_DIFFERENCE
        if over and max(counts) > min(over) + largest:
            raise LostSampleError(LOST)
        return min(counts)

    def sent(self, run: int, index: int) -> int:
        """When a sample was sent (ns, wall clock)."""
        return self.joint.runs[run][index].sent

    @property
    def last_sent(self) -> int:
        """When the newest sample was sent (ns, wall clock)."""
        return self.joint.runs[-1][-1].sent

    @property
    def last_complete_sent(self) -> int:
        """When the newest sample was sent of which every message has come (ns, wall clock)."""
        run = self.runs - 1
        return self.sent(run, self.complete(run) - 1)

    def sample(self, run: int, index: int) -> Sample:
        """Return a complete sample; raises LostSampleError where its messages are not of one."""
        joint = self.joint.runs[run][index]
        pressures = [topic.runs[run][index] for topic in self.pressures]
        if any(pressure.stamp != joint.stamp for pressure in pressures):
            raise LostSampleError(LOST)
        return Sample(
            joint.stamp * SECONDS_PER_NANOSECOND, *joint.values, *(p.values[0] for p in pressures)
        )

    def samples(self, run: int, count: int | None = None) -> Samples:
        """Return the first ``count`` samples of a run, of which every message has come, or all.

        Raises LostSampleError if some are missing.
        """
        count = self.complete(run) if count is None else count
        rows = np.array([self.sample(run, k) for k in range(count)]).reshape(count, -1)
        joint = self.joint.runs[run][:count]
        if joint and joint[0].stamp:  # sample 0 is that of time 0
            raise LostSampleError(LOST)
        if count > 1 and np.ptp(np.diff([message.stamp for message in joint])):
            raise LostSampleError(LOST)
        sent = np.array([message.sent for message in joint], dtype=np.int64)
        end = self._end(run, count)
        if np.any(np.diff([self._before(run), *sent, end]) < 0):
            raise LostSampleError(SET_BACK)
        columns = dict(zip(Sample._fields, rows.T.copy(), strict=True))
        terms = {term: self._term(term, sent, end) for term in self.terms}
        return Samples(
            **columns,
            voltage=_latest(self.voltage, sent, end),
            **{term: terms.get(term, np.full(count, np.nan)) for term in TERMS},
            terms={name: terms[name] for name in terms if name != "reference"},
        )

    def _before(self, run: int) -> float:
        """When the last sample of the run before was sent; minus infinity for never."""
        return self.joint.runs[run - 1][-1].sent if run else -np.inf

    def _end(self, run: int, count: int) -> float:
        """When the sample after the last was sent, be it of the next run; infinity for never."""
        following = [self.joint.runs[run][count:], *self.joint.runs[run + 1 :]]
        return next((messages[0].sent for messages in following if messages), np.inf)

    def _term(self, term: str, sent: npt.NDArray[np.int64], end: float) -> Array:
        """Date a term by the command that it belongs to, which the controller sends first."""
        answers = np.array([answer.sent for answer in self.answers], dtype=np.int64)
        index = [int(np.searchsorted(answers, message.sent)) - 1 for message in self.terms[term]]
        dated = [
            Unstamped(int(answers[k]), message.value)
            for k, message in zip(index, self.terms[term], strict=True)
            if k >= 0
        ]
        return _latest(dated, sent, end)


def _latest(messages: list[Unstamped], sent: npt.NDArray[np.int64], end: float) -> Array:
    """For each sample, the last of ``messages`` sent after it and before the next."""
    found = np.full(len(sent), np.nan)
    for message in messages:
        k = int(np.searchsorted(sent, message.sent)) - 1
        if k >= 0 and message.sent < end:
            found[k] = message.value
    return found


class Cursor:
    """Reads the complete samples of all runs, each once, in order."""

    def __init__(self, received: Received) -> None:
        """Begin with the newest sample there is, or the first to come."""
        self._received = received
        self._run = max(received.runs - 1, 0)
        self._index = max(received.complete(self._run) - 1, 0)

    def begin(self, run: int) -> None:
        """Go on with the first sample of a run, whether it is there or not."""
        self._run, self._index = run, 0

    def next(self) -> tuple[int, Sample] | None:
        """Return when the next sample was sent (ns, wall clock) and the sample, if it is there."""
        found = self.peek()
        self.skip()
        return found

    def skip(self) -> None:
        """Read on without the next sample, if it is there."""
        place = self._place()
        if place is not None:
            self._run, self._index = place[0], place[1] + 1

    def peek(self) -> tuple[int, Sample] | None:
        """Return what :meth:`next` will."""
        place = self._place()
        return (
            None if place is None else (self._received.sent(*place), self._received.sample(*place))
        )

    def _place(self) -> tuple[int, int] | None:
        if self._index < self._received.complete(self._run):
            return self._run, self._index
        return (self._run + 1, 0) if self._received.complete(self._run + 1) else None
