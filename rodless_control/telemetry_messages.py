"""The controller's insides on topics of their own, for plotting."""

from rclpy.node import Node
from std_msgs.msg import Float64

from rodless_base.ros_names import QUEUE_DEPTH
from rodless_control.loop import Output

TERMS = ("reference", "error", "p", "i", "d", "feedforward")


class Telemetry:
    """One topic per term below the node's name: m for reference and error, V for the others."""

    def __init__(self, node: Node) -> None:
        """Make the publishers."""
        self._publishers = [
            node.create_publisher(Float64, f"~/{term}", QUEUE_DEPTH) for term in TERMS
        ]

    def publish(self, output: Output) -> None:
        """Publish to those who listen; building a message that nobody reads costs as much."""
        command = output.command
        values = (
            output.reference,
            command.error,
            command.p,
            command.i,
            command.d,
            command.feedforward,
        )
        for publisher, value in zip(self._publishers, values, strict=True):
            if publisher.get_subscription_count():
                publisher.publish(Float64(data=value))
