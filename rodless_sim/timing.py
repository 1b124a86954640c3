"""Plant time: integer nanoseconds, and inner steps that divide a period exactly."""

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt


def nanoseconds(duration: float) -> int:
    """Return ``duration`` (s) in whole nanoseconds; raises ValueError unless that is positive."""
    span = duration * 1e9
    if not math.isfinite(span) or round(span) <= 0:
        raise ValueError(f"duration {duration!r} s refused: must be a positive number")
    return round(span)


def sample_times(count: int, period: int) -> npt.NDArray[np.float64]:
    """Return the times in s, shape (count,), of samples ``period`` ns apart, the first at 0."""
    return np.asarray(np.arange(count) * period * 1e-9, dtype=np.float64)


def inner_steps(span: int, longest: float) -> tuple[int, float]:
    """Divide ``span`` (ns) into the fewest equal steps no longer than ``longest`` (s).

    Returns their number and their length in seconds.
    """
    steps = max(1, math.ceil(span / (longest * 1e9) - 1e-9))
    return steps, span * 1e-9 / steps


@lru_cache(maxsize=64)
def division(duration: float, longest: float) -> tuple[int, int, float]:
    """Return ``duration`` (s) in ns, and its :func:`inner_steps`; raises as :func:`nanoseconds`."""
    span = nanoseconds(duration)
    return span, *inner_steps(span, longest)
