# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
