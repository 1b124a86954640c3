# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Internal signals of the controller as topics, for plotting."""

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.ros.cdr import pack_float64
from rodless_base.ros.publish import OnDemand, Outbox
from rodless_control.controller import Law
from rodless_control.loop import Output

REFERENCE = "reference"


class Telemetry:
    """The reference (m) and each of the law's terms, in units of its own, below the node's name."""

    def __init__(self, node: Node, law: Law, qos: QoSProfile | int) -> None:
        """Make the publishers, with the quality of service of the commands."""
        self._outbox = Outbox(node)
        self._publishers = {
            name: OnDemand(
                node.create_publisher(Float64, f"~/{name}", qos), pack_float64, self._outbox
            )
            for name in (REFERENCE, *law.TERMS)
        }

    def poll(self) -> None:
        """Look up which signals have subscribers, and send what was held back."""
        self._outbox.flush()
        for publisher in self._publishers.values():
            publisher.poll()

    @property
    def lost(self) -> int:
        """Messages lost to a stopped subscriber."""
        return self._outbox.lost

    def publish(self, output: Output) -> None:
        """Publish what has subscribers."""
        self._publishers[REFERENCE].publish(output.reference)
        for name, value in output.terms.items():
            self._publishers[name].publish(value)
