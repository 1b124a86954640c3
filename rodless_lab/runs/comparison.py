"""Two runs side by side, measured the way the paper compares simulation and experiment."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

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
    """Second run minus first, SI: at the end, at its largest, and its root mean square.

    ``steady`` is the mean over the last half second, ``largest`` the largest magnitude, reached at
    ``time`` (s).
    """

    steady: float
    largest: float
    time: float
    rms: float


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
    """Return the coarser of two even time bases (s) over the stretch both cover."""
    start, end = max(first[0], second[0]), min(first[-1], second[-1])
    period = max(np.diff(first).mean(), np.diff(second).mean())
    count = int((end - start) / period + 1e-9) + 1
    return np.asarray(start + period * np.arange(max(count, 0)))
