"""ROS times as plant time is counted: whole nanoseconds."""

from builtin_interfaces.msg import Time

NANOSECONDS = 1_000_000_000


def stamp_nanoseconds(stamp: Time) -> int:
    """Return a stamp in ns."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
