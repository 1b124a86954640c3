# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The clock of a node that knows plant time itself."""

import pytest
from rclpy.clock import ROSClock

from rodless_base.ros.own_time import tell_time

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(("told", "shown"), [(5, 5), (0, 0), (-1, 0), (-(2**61), 0)])
def test_a_time_before_zero_is_shown_as_zero(told: int, shown: int) -> None:
    """Stamps of messages may be negative: the timer that tells them must not fail for it."""
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    tell_time(clock, 7)
    tell_time(clock, told)
    assert clock.now().nanoseconds == shown
