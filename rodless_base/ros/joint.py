"""Where a joint is, by its name in ``joint_states``."""

from sensor_msgs.msg import JointState


def joint_position(message: JointState, name: str) -> float | None:
    """Return the position of joint ``name`` (m), None where the message does not hold it."""
    if name not in message.name or len(message.position) != len(message.name):
        return None
    return float(message.position[message.name.index(name)])
