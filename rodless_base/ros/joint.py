"""One joint of a JointState."""

from sensor_msgs.msg import JointState

from rodless_base.constants import CARRIAGE
from rodless_base.frames import joint_among


def joint_position(message: JointState, name: str) -> float | None:
    """Return the position (m) of the joint ``name``, or None where the message has none.

    Positions that are not as many as the names belong to no joint for certain.
    """
    if name not in message.name or len(message.position) != len(message.name):
        return None
    return float(message.position[message.name.index(name)])


def carriage_position(message: JointState) -> float | None:
    """Return the position (m) of the carriage, whatever its prefix, or None without one."""
    name = joint_among(CARRIAGE, message.name)
    return None if name is None else joint_position(message, name)
