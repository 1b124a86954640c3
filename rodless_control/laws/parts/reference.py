# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The reference's acceleration, which no reference brings along.

It is the change of the velocity ṙ from sample to sample behind a low-pass of first order. A step of
the velocity asks for any acceleration; more than a cylinder is ever asked for does not count.
"""

import math

from rodless_base.kernels import kernel
from rodless_control.laws.parts.saturation import within

LARGEST_ACCELERATION = 100.0  # m/s²


@kernel
def reference_acceleration(
    bandwidth: float, acceleration: float, change: float, interval: float
) -> float:
    """Acceleration in m/s² after a ``change`` (m/s) of the velocity within ``interval`` (s).

    ``bandwidth`` is in rad/s. An interval of 0 changes nothing.
    """
    if interval <= 0.0:
        return acceleration
    rate = within(change / interval, -LARGEST_ACCELERATION, LARGEST_ACCELERATION)
    return acceleration - math.expm1(-bandwidth * interval) * (rate - acceleration)
