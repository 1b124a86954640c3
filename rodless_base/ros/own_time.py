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
    """Let ``clock`` show plant time (ns), where ``use_sim_time`` is set."""
    clock.set_ros_time_override(Time(nanoseconds=nanoseconds, clock_type=clock.clock_type))
