"""The controller's insides on topics of their own, for plotting."""

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.ros.publish import OnDemand
from rodless_control.loop import Output

TERMS = ("reference", "error", "p", "i", "d", "feedforward")


class Telemetry:
    """One topic per term below the node's name: m for reference and error, V for the others."""

    def __init__(self, node: Node, qos: QoSProfile | int) -> None:
        """Make the publishers, with the quality of service of the commands."""
        self._publishers = [
            OnDemand(node.create_publisher(Float64, f"~/{term}", qos), _message) for term in TERMS
        ]

    def poll(self) -> None:
        """Look up who listens."""
        for publisher in self._publishers:
            publisher.poll()

    def publish(self, output: Output) -> None:
        """Publish to those who listen."""
        _, *terms = output.command
        for publisher, value in zip(self._publishers, (output.reference, *terms), strict=True):
            publisher.publish(value)


def _message(value: float) -> Float64:
    return Float64(data=value)
