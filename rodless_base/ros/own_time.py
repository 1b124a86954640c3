# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Nodes that know plant time themselves and need no ``/clock`` to tell it."""

from rclpy.clock import ROSClock
from rclpy.node import Node
from rclpy.time import Time


def without_clock_topic(node: Node) -> ROSClock:
    """Take ``node`` off ``/clock``, whatever ``use_sim_time`` says; return its clock to be set.

    At 1 kHz the topic costs as much as the samples, here and in the plant.
    """
    # There is no public way to rclpy's own subscription.
    node._time_source.detach_node()
    clock: ROSClock = node.get_clock()
    tell_time(clock, 0)
    return clock


def tell_time(clock: ROSClock, nanoseconds: int) -> None:
    """Let ``clock`` show plant time (ns), where ``use_sim_time`` is set; 0 for any before that."""
    # A message may have such a stamp, rclpy's clocks do not.
    shown = max(nanoseconds, 0)
    clock.set_ros_time_override(Time(nanoseconds=shown, clock_type=clock.clock_type))
