"""What the controller node listens to: positions, and pressures of the same stamp where wanted."""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.measurement import Measurement
from rodless_base.ros.topics import QUEUE_DEPTH, stamp_nanoseconds
from rodless_base.topics import JOINT_STATES, PRESSURES
from rodless_control.samples import Samples


class Inputs:
    """Subscriptions that end in one call of ``take`` per complete measurement."""

    def __init__(
        self, node: Node, pressures: bool, joint: Callable[[], str], take: Callable[..., None]
    ) -> None:
        """Prepare; ``joint`` tells the joint's name, ``take`` gets a measurement."""
        self._node = node
        self._joint = joint
        self._take = take
        self._pressures = PRESSURES if pressures else {}
        self._samples = Samples(["position", *self._pressures])
        self.without_joint = 0
        self.listening = False

    @property
    def incomplete(self) -> int:
        """Samples dropped because a message of theirs never came."""
        return self._samples.incomplete

    def listen(self) -> None:
        """Subscribe, to positions last: a plant that starts with them has then seen the others."""
        self.listening = True
        for field, topic in self._pressures.items():
            self._node.create_subscription(
                FluidPressure, topic, self._pressure_taker(field), QUEUE_DEPTH
            )
        self._node.create_subscription(JointState, JOINT_STATES, self._take_joint, QUEUE_DEPTH)

    def _pressure_taker(self, field: str) -> Callable[[FluidPressure], None]:
        def take(message: FluidPressure) -> None:
            self._put(field, message, float(message.fluid_pressure))

        return take

    def _take_joint(self, message: JointState) -> None:
        """Take the carriage's position; a message without it counts as no sample at all."""
        joint = self._joint()
        if joint not in message.name or len(message.position) != len(message.name):
            self.without_joint += 1
            return
        self._put("position", message, float(message.position[message.name.index(joint)]))

    def _put(self, field: str, message: FluidPressure | JointState, value: float) -> None:
        stamp = stamp_nanoseconds(message.header.stamp)
        measurement: Measurement | None = self._samples.put(field, stamp, value)
        if measurement is not None:
            self._take(measurement)
