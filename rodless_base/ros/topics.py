"""What goes between the nodes: topic names, queues and stamps."""

from builtin_interfaces.msg import Time
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from rodless_base.constants import NANOSECONDS_PER_SECOND

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"
SETPOINT = "setpoint"

# By field of Measurement, in the order they are published in, before joint_states.
PRESSURES = {
    "pressure_a": "chamber_a/pressure",
    "pressure_b": "chamber_b/pressure",
    "supply_pressure": "supply/pressure",
}

# What a bag of the rig holds.
RIG_TOPICS = (JOINT_STATES, *PRESSURES.values(), VALVE_VOLTAGE, SETPOINT)

# Samples a slow reader, such as a recorder on a busy disk, may fall behind before it loses any.
QUEUE_DEPTH = 1000

# A queue that never drops: a reader that falls behind holds the sender back instead.
LOSSLESS = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)


def stamp_nanoseconds(stamp: Time) -> int:
    """Return a stamp in ns."""
    return int(stamp.sec) * NANOSECONDS_PER_SECOND + int(stamp.nanosec)
