"""Internal signals of the controller as topics, for plotting."""

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.ros.publish import OnDemand
from rodless_control.controller import Law
from rodless_control.loop import Output

REFERENCE = "reference"


class Telemetry:
    """The reference (m) and each of the law's terms, in units of its own, below the node's name."""

    def __init__(self, node: Node, law: Law, qos: QoSProfile | int) -> None:
        """Make the publishers, with the quality of service of the commands."""
        self._publishers = {
            name: OnDemand(node.create_publisher(Float64, f"~/{name}", qos), _message)
            for name in (REFERENCE, *law.TERMS)
        }

    def poll(self) -> None:
        """Look up which signals have subscribers."""
        for publisher in self._publishers.values():
            publisher.poll()

    def publish(self, output: Output) -> int:
        """Publish what has subscribers; return how many messages were lost."""
        values = {REFERENCE: output.reference, **output.terms}
        return sum(not self._publishers[name].publish(value) for name, value in values.items())


def _message(value: float) -> Float64:
    return Float64(data=value)
