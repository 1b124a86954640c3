"""One sample of the rig as its instruments read it: what the plant publishes and a law is given."""

from typing import NamedTuple

from rodless_base.constants import NANOSECONDS_PER_SECOND


class Measurement(NamedTuple):
    """Readings of one instant.

    A pressure that nobody asked for is NaN: the controller node subscribes to pressures only for a
    law that uses them.
    """

    stamp: int  # ns of plant time
    position: float  # m
    pressure_a: float  # Pa, absolute
    pressure_b: float  # Pa, absolute
    supply_pressure: float  # Pa, absolute

    @property
    def time(self) -> float:
        """Plant time in s."""
        return self.stamp / NANOSECONDS_PER_SECOND
