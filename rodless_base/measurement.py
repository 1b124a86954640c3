"""One sample of the rig as its instruments read it: what the plant publishes and a law is given."""

import math
from typing import NamedTuple

from rodless_base.constants import NANOSECONDS_PER_SECOND


class Measurement(NamedTuple):
    """Readings of one instant.

    A pressure that nobody asked for is NaN: the controller node subscribes to pressures only for a
    law that uses them.

    Examples
    --------
    >>> sample = Measurement(2_500_000, 0.058)
    >>> sample.position, sample.time
    (0.058, 0.0025)
    """

    stamp: int  # ns of plant time
    position: float  # m
    pressure_a: float = math.nan  # Pa, absolute
    pressure_b: float = math.nan  # Pa, absolute
    supply_pressure: float = math.nan  # Pa, absolute

    @property
    def time(self) -> float:
        """Plant time in s."""
        return self.stamp / NANOSECONDS_PER_SECOND
