"""Topic names and queues both nodes share."""

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"

# Samples a slow reader, such as a recorder on a busy disk, may fall behind before it loses any.
QUEUE_DEPTH = 1000

# A queue that never drops: a reader that falls behind holds the sender back instead.
LOSSLESS = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
