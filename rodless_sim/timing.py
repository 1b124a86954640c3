"""Plant time: integer nanoseconds, and inner steps that divide a period exactly."""

import math
from functools import lru_cache


def nanoseconds(duration: float) -> int:
    """Return ``duration`` (s) in whole nanoseconds; raises ValueError unless that is positive."""
    if not math.isfinite(duration) or round(duration * 1e9) <= 0:
        raise ValueError(f"duration {duration!r} s refused: must be a positive number")
    return round(duration * 1e9)


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
