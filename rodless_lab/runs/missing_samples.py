# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Samples that a recorder lost: how many, of which topic, and since when."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# By how much of a period one in a hundred intervals may be off, for gaps to be counted in periods.
UNEVEN = 0.25


def missing_samples(stamps: Mapping[str, Array]) -> str:
    """Say which topics lack samples in between, and since when; empty where none does.

    ``stamps`` (s, in order, shape (n,) each) by the topic's name; a topic whose stamps its
    publisher left at zero tells nothing, nor does one whose stamps jitter. A sample that comes late
    by half a period or more, with the next one on time, is late and not missing.
    """
    losses = [(name, *_lost(times)) for name, times in stamps.items() if len(times) > 2]
    losses = [loss for loss in losses if loss[1] > 0]
    if not losses:
        return ""
    counts = ", ".join(f"{lost} of {asked} of {name}" for name, lost, asked, _ in losses)
    return f"samples are missing, from {min(loss[3] for loss in losses):.3f} s on: {counts}"


def _lost(times: Array) -> tuple[int, int, float]:
    """Return how many samples are missing, of how many, and the time (s) before the first gap."""
    apart = np.diff(times)
    period = float(np.median(apart))
    if period <= 0.0:
        return 0, len(times), 0.0
    periods = np.rint(apart / period)
    if np.quantile(np.abs(apart / period - periods), 0.99) > UNEVEN:
        return 0, len(times), 0.0
    lost = int(np.sum(periods - 1))
    return lost, len(times) + lost, float(times[np.argmax(periods > 1)])
