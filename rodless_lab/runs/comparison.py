# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Two runs side by side, measured the way the paper compares simulation and experiment."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rodless_lab.runs.measured_run import MeasuredRun, RunError, Setpoint

Array = npt.NDArray[np.float64]

# The steady state is the mean of this last stretch (s), or of the last tenth of a shorter run.
STEADY = 0.5

# What is compared, by field of the runs: label, unit shown, and how many of it make one SI unit.
QUANTITIES = {
    "position": ("position", "mm", 1e3),
    "pressure_a": ("pressure in A", "kPa", 1e-3),
    "pressure_b": ("pressure in B", "kPa", 1e-3),
    "voltage": ("valve voltage", "V", 1.0),
}


@dataclass(frozen=True)
class Difference:
    """Second run minus first, in the unit of the quantity.

    ``steady`` is the mean over the last half second, of a run shorter than 5 s over its last tenth,
    ``largest`` the largest magnitude, reached at ``time``, ``rms`` the root mean square.
    """

    steady: float
    largest: float
    time: float  # s
    rms: float


def differences(first: MeasuredRun, second: MeasuredRun, time: Array) -> dict[str, Difference]:
    """Compare every one of ``QUANTITIES`` at ``time`` (s, shape (n,)), between the samples too."""
    return {
        name: difference(
            time,
            np.interp(time, first.time, getattr(first, name)),
            np.interp(time, second.time, getattr(second, name)),
        )
        for name in QUANTITIES
    }


def difference(time: Array, first: Array, second: Array) -> Difference:
    """Compare two quantities on one time base; shapes (n,). Raises ValueError for no samples."""
    if not len(time):
        raise ValueError("two runs without a common stretch of time cannot be compared")
    apart = second - first
    place = int(np.argmax(np.abs(apart)))
    stretch = min(STEADY, 0.1 * (time[-1] - time[0]))
    end = time >= time[-1] - stretch
    return Difference(
        float(np.mean(apart[end])),
        float(np.abs(apart[place])),
        float(time[place]),
        float(np.sqrt(np.mean(apart**2))),
    )


def common_time(first: Array, second: Array) -> Array:
    """Return the coarser of two even time bases (s) over the stretch both cover.

    Raises :class:`RunError` where that is less than two samples.
    """
    start, end = max(first[0], second[0]), min(first[-1], second[-1])
    period = max(np.diff(first).mean(), np.diff(second).mean())
    count = int((end - start) / period + 1e-9) + 1
    if count < 2:
        raise RunError("the two runs have no stretch of time in common")
    return np.asarray(start + period * np.arange(count))


def aligned(
    first: tuple[MeasuredRun, Setpoint | None], second: tuple[MeasuredRun, Setpoint | None]
) -> tuple[MeasuredRun, MeasuredRun]:
    """Put two recorded runs on one time: by their first set-points, else by their starts.

    Set-points of which it is not known when they were given say nothing of it.
    """
    (run, own), (other, others) = first, second
    if own is None or others is None or own.doubt or others.doubt:
        return run, other
    shift = others.time[0] - own.time[0]
    return replace(run, time=run.time + shift), other
