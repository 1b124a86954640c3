"""Topic names and the queue both nodes share."""

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"

# Samples a slow reader, such as a recorder on a busy disk, may fall behind before it loses any.
QUEUE_DEPTH = 1000
