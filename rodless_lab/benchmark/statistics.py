# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The arithmetic of the benchmark: quantiles, and which command answers which sample."""

import numpy as np
import numpy.typing as npt


def milliseconds(nanoseconds: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Return times in ms."""
    return np.asarray(nanoseconds * 1e-6, dtype=np.float64)


def statistics(what: str, values: npt.NDArray[np.float64]) -> dict[str, float]:
    """Mean, quantiles and worst of ``values`` (ms, shape (n,)), by name."""
    return {
        f"{what}, mean (ms)": float(values.mean()),
        f"{what}, p50 (ms)": float(np.percentile(values, 50)),
        f"{what}, p99 (ms)": float(np.percentile(values, 99)),
        f"{what}, p99.9 (ms)": float(np.percentile(values, 99.9)),
        f"{what}, worst (ms)": float(values.max()),
    }


def answer_times(
    sent: npt.NDArray[np.int64], commands: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return how long after its sample each command was received, in ns, shape (m,).

    ``sent`` (ns, shape (n,)) is when samples were, ``commands`` (shape (k, 2)) when commands were
    sent and received. Each sample has one command, and most commands are sent before the next
    sample: that tells which sample the first command belongs to.
    """
    latest = np.searchsorted(sent, commands[:, 0], side="right") - 1
    offset = int(np.median(latest - np.arange(len(commands))))
    place = np.arange(len(commands)) + offset
    inside = (place >= 0) & (place < len(sent))
    return np.asarray(commands[inside, 1] - sent[place[inside]])
