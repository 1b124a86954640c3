# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Commands, which carry no stamp, and the samples that do: which of these each command answers."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns
from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_lab.bags.reader import TopicMessages

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]

# Times of a sample and of what answers it may differ by a hair (s) where both are plant time.
SAME_SAMPLE = 1e-6
_HAIR = round(SAME_SAMPLE * NANOSECONDS_PER_SECOND)

# How large a share of commands, or of samples, out of step is taken for an accident.
_ACCIDENTS = 0.01

# A sample less than this share of a period after the one before: one of them was held up.
_BUNCHED = 0.5

# Fewer times of their own than this share of the samples tell none of them apart: not even a
# recorder that writes all that waits at once does that for a hundred samples on end.
_TOLD_APART = 0.01

# Samples over which their period by the bag's clock is measured.
_SPAN = 100

# How many samples after the one it answers the valve may first hold a command. With no new command
# for longer, it may have closed.
_LATEST = 20


class SampleTimes:
    """When samples and commands were sent, by the bag's clock, and the plant time of the samples.

    Senders' times count where they were recorded: a recorder that is late shifts log times only.
    """

    def __init__(self, samples: TopicMessages, stamp: Array) -> None:
        """Take the samples and their plant times (s)."""
        self._stamp = stamp
        self._by_sender = _senders_times_recorded(samples)
        # Log times may go back; a search needs order, and what is out of it shows as a bunch.
        self._sent = np.maximum.accumulate(self._times(samples))

    def _times(self, messages: TopicMessages) -> Places:
        return messages.publish_time if self._by_sender else messages.log_time

    def answered(self, messages: TopicMessages) -> Places:
        """Return the last sample sent before each message; -1 before the first."""
        return np.searchsorted(self._sent, self._times(messages) + _HAIR, side="right") - 1

    def latency(self, messages: TopicMessages) -> Array:
        """Return how long (s) after that sample each message was sent; NaN before the first."""
        place = self.answered(messages)
        after = (self._times(messages) - self._sent[np.maximum(place, 0)]) * 1e-9
        return np.where(place < 0, np.nan, np.maximum(after, 0.0))

    def plant_time(self, messages: TopicMessages) -> Array:
        """Return the stamp (s) of the sample that each message answers, or a time before all.

        The plant acts on a message from there on if it gets it at once: before the next sample.
        """
        place = self.answered(messages)
        before = (self._times(messages) - self._sent[0]) * 1e-9 * self.speed
        return np.where(place < 0, self._stamp[0] + before, self._stamp[np.maximum(place, 0)])

    @property
    def speed(self) -> float:
        """Plant time per time of the bag's clock."""
        # As floats: two times of 64 bits may lie further apart than one of them can tell.
        took = (float(self._sent[-1]) - float(self._sent[0])) * 1e-9
        return float(self._stamp[-1] - self._stamp[0]) / took if took > 0.0 else 1.0

    @cached_property
    def why_useless(self) -> str:
        """Say why the bag's times do not tell which sample came before a message, if so."""
        distinct = 1 + int(np.count_nonzero(np.diff(self._sent) > _HAIR))
        count = len(self._sent)
        if count < 2 or distinct >= max(2, _TOLD_APART * count):
            return ""
        kind = "publication time" if self._by_sender else "log time"
        return f"{count} samples share {distinct} {kind}{'s' if distinct > 1 else ''}"

    def doubt(self, commands: TopicMessages) -> str:
        """Say why the plant may have got ``commands`` at other samples than they answer, if so.

        That is not in the bag. Where machine or recorder were late, though, it shows.
        """
        if len(self._sent) < 2 or self.why_useless:
            return self.why_useless
        steps = np.diff(self.answered(commands), append=len(self._sent) - 1)
        if np.median(steps) == 1:
            return _odd_ones(steps)
        if len(steps) > (1.0 + _ACCIDENTS) * len(self._sent):
            return f"{len(steps)} commands answer {len(self._sent)} samples"
        # Over many samples: bunches do not change it, nor does a pause.
        span = min(_SPAN, len(self._sent) - 1)
        period = np.median(self._sent[span:] - self._sent[:-span]) / span
        bunched = int(np.count_nonzero(np.diff(self._sent) < _BUNCHED * period))
        if bunched > _ACCIDENTS * len(self._sent):
            return f"{bunched} of {len(self._sent)} samples were recorded in bunches"
        return ""


def _odd_ones(steps: Places) -> str:
    """Say how many commands answer no sample, or several; ``steps`` are samples from one on."""
    odd = int(np.count_nonzero(steps[:-1] != 1))
    if odd > _ACCIDENTS * len(steps):
        return f"{odd} of {len(steps)} commands do not answer one sample each"
    if steps.max() > _LATEST:
        return f"{steps.max()} samples have no command, for which the valve may close"
    return ""


def _senders_times_recorded(samples: TopicMessages) -> bool:
    """Whether publication times are senders' times; else they are log times, or zero."""
    sent = samples.publish_time
    return bool(sent.any() and np.all(np.diff(sent) >= 0))


@dataclass(frozen=True)
class Commands(Columns):
    """Commands in the order they were sent, arrays of one shape (n,).

    ``sample`` counts the carriage's messages on ``joint_states`` from 0: the last one sent before
    the command, which is the one it answers; ``time`` is its stamp. ``latency`` is from the sending
    of that sample to that of the command by the bag's clock: in a bag in plant time it is 0. From
    ``held_from`` on the valve held the command; NaN where another came first, and in a bag without
    ``valve/state``.
    """

    time: Annotated[Array, "s"]
    voltage: Annotated[Array, "V"]
    sample: Annotated[Places, ""]
    latency: Annotated[Array, "s"]
    held_from: Annotated[Array, "s"]

    def during(self, begin: float, end: float) -> "Commands":
        """Return those in force from ``begin`` to ``end`` (s), each until the next.

        Of several at ``end`` the first: where that is the last sample, all later ones answer it.
        """
        hair = _HAIR * 1e-9
        until = np.append(self.time[1:], np.inf)
        inside = (self.time >= begin - hair) | (until > begin + hair)
        inside &= self.time <= end + hair
        last = np.flatnonzero(inside & (self.time >= end - hair))
        inside[last[1:]] = False
        return Commands(**{name: values[inside] for name, values in self.columns().items()})


def held_from(
    answered: Array, voltage: Array, held: tuple[Array, Array], limits: tuple[float, float]
) -> Array:
    """Return when (s) the valve began to hold each command; NaN where it never did.

    ``answered`` (s) and ``voltage`` (V), shape (n,), are of the commands in order; ``held`` are
    times (s) and the voltage (V) that the valve held from each on, shape (m,), within ``limits``.
    """
    start, value = held
    first = np.searchsorted(start, answered - SAME_SAMPLE)
    wanted = np.clip(voltage, *limits)
    found, least = np.full(len(voltage), np.nan), 0
    for k, (place, volts) in enumerate(zip(first, wanted, strict=True)):
        begin = max(int(place), least)
        hits = np.flatnonzero(value[begin : begin + _LATEST] == volts)
        if len(hits):
            least = begin + int(hits[0])
            found[k] = start[least]
    return found


def summary(commands: Commands, period: float, recorded: int | None = None) -> str:
    """Say in one line how fast the commands came and when the valve followed them.

    They may be some of the ``recorded`` ones.
    """
    count = len(commands.time)
    parts = [f"{count} commands"]
    if recorded is not None and recorded != count:
        parts = [f"{count} of {recorded} commands lie in the run"]
    late = np.round((commands.held_from - commands.time) / period)
    followed = np.isfinite(late)
    if not followed.any():
        parts.append("when the valve followed them was not recorded")
    else:
        at_once = np.count_nonzero(late == 0)
        parts.append(f"{at_once} held from the sample that they answer on")
        later = np.count_nonzero(followed) - at_once
        if later:
            parts.append(f"{later} later, by {np.nanmax(late):.0f} samples at most")
        # The last sample's answer acts on nothing in the bag.
        never = np.count_nonzero(~followed & (commands.sample < commands.sample.max()))
        if never:
            parts.append(f"{never} never")
    latency = commands.latency[np.isfinite(commands.latency)] * 1e3
    if latency.any():
        parts.append(
            f"sent {np.median(latency):.2f} ms after it (99 %: {np.percentile(latency, 99):.2f} ms)"
        )
    return ", ".join(parts)
