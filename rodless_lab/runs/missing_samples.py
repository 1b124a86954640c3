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


class Loss(NamedTuple):
    """What is missing of one topic."""

    topic: str
    lost: int
    asked: int
    since: float  # s, the last sample before the first gap


def missing_samples(stamps: Mapping[str, Array]) -> str:
    """Say which topics lack samples in between, and since when; empty where none does.

    ``stamps`` (s, in order, shape (n,) each) by the topic's name; a topic whose stamps its
    publisher left at zero tells nothing, nor does one whose stamps jitter. A sample that comes late
    by half a period or more, with the next one on time, is late and not missing. What is lost
    evenly, such as every second sample, looks like a topic that is published less often.
    """
    losses = [loss for name, times in stamps.items() if (loss := _loss(name, times)).lost > 0]
    if not losses:
        return ""
    counts = ", ".join(f"{loss.lost} of {loss.asked} of {loss.topic}" for loss in losses)
    return f"samples are missing, from {min(loss.since for loss in losses):.3f} s on: {counts}"


def _loss(topic: str, stamps: Array) -> Loss:
    times = np.unique(stamps)
    nothing = Loss(topic, 0, len(times), 0.0)
    if len(times) < 3:
        return nothing
    apart = np.diff(times)
    shortest = float(np.quantile(apart, WHOLE, method="inverted_cdf"))
    period = float(np.median(apart[np.rint(apart / shortest) == 1.0]))
    periods = np.rint(apart / period)
    if np.quantile(np.abs(apart / period - periods), 0.99) > UNEVEN:
        return nothing
    lost = int(np.sum(periods - 1))
    return Loss(topic, lost, len(times) + lost, float(times[np.argmax(periods > 1)]))
