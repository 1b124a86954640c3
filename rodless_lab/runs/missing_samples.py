# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Samples that a recorder lost: how many, of which topic, and since when."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# By how much of a period one in a hundred intervals may be off, for gaps to be counted in periods.
UNEVEN = 0.25


# The share of intervals taken to have lost nothing: of nine samples in ten lost, one in ten is so.
WHOLE = 0.05

# By how much (s of the recorder) a topic may end before the last one does. A recorder that is asked
# to stop takes what waits of one topic after the other, and a kill costs what came since it last
# wrote, at most 0.1 s ago: tens of ms on a busy machine.
ENDS = 0.1

# And begin after the first one (s): who joins a running rig finds its topics one by one, in
# searches 0.1 s apart, and the middleware takes as long again to connect each of them.
BEGINS = 0.3


class Loss(NamedTuple):
    """What is missing of one topic."""

    topic: str
    lost: int
    asked: int
    since: float  # s, the last sample before the first gap
    where: str = ""  # beyond which end of the topic, if so


def missing_samples(stamps: Mapping[str, Array], pace: float = 1.0) -> str:
    """Say which topics lack samples, and since when; empty where none does.

    ``pace`` is how many s of the stamps' time passed in a second of the recorder's.

    ``stamps`` (s, in order, shape (n,) each) by the topic's name; a topic whose stamps its
    publisher left at zero tells nothing, nor does one whose stamps jitter of those in between. A
    sample that comes late by half a period or more, with the next one on time, is late and not
    missing. What is lost evenly, such as every second sample, looks like a topic that is published
    less often. Beyond its ends a topic lacks what the others have, but for a few samples.
    """
    times = {name: np.unique(one) for name, one in stamps.items()}
    spans = [(one[0], one[-1]) for one in times.values() if len(one) > 1]
    if not spans:
        return ""
    span = float(min(first for first, _ in spans)), float(max(last for _, last in spans))
    losses = [
        loss
        for name, one in times.items()
        if len(one) > 1 and (loss := _loss(name, one, span, pace)).lost > 0
    ]
    if not losses:
        return ""
    counts = ", ".join(
        f"{loss.lost} of {loss.asked} of {loss.topic}{loss.where}" for loss in losses
    )
    return f"samples are missing, {_since(min(loss.since for loss in losses))} on: {counts}"


def _since(time: float) -> str:
    """Return from when on; a run begins at 0, where the last of its topics does."""
    return "from its start" if time < -5e-4 else f"from {abs(time):.3f} s"


def _loss(topic: str, times: Array, span: tuple[float, float], pace: float) -> Loss:
    """Return what a topic lacks of ``span`` (s, that of all topics); ``times`` increase."""
    apart = np.diff(times)
    shortest = float(np.quantile(apart, WHOLE, method="inverted_cdf"))
    period = float(np.median(apart[np.rint(apart / shortest) == 1.0]))
    periods = np.rint(apart / period)
    even = bool(np.quantile(np.abs(apart / period - periods), 0.99) <= UNEVEN)
    inside = int(np.sum(periods - 1)) if even else 0
    # Where samples come as they please, the next one may be as far off as any other was, and their
    # mean tells how many would have followed.
    usual, each = (period, period) if even else (float(apart.max()), float(apart.mean()))
    late, early = float(times[0]) - span[0], span[1] - float(times[-1])
    late = late if late > BEGINS * pace + usual else 0.0
    early = early if early > ENDS * pace + usual else 0.0
    lost = inside + int(late / each + 0.5) + int(early / each + 0.5)
    since = float(times[np.argmax(periods > 1)]) if inside else float(times[-1])
    return Loss(topic, lost, len(times) + lost, span[0] if late else since, _where(late, early))


def _where(late: float, early: float) -> str:
    ends = [f"begins {late:.3f} s late"] if late else []
    ends += [f"ends {early:.3f} s early"] if early else []
    return f", which {' and '.join(ends)}" if ends else ""
