# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Internal signals of the controller as topics, for plotting."""

from collections.abc import Iterable

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.one_line import described
from rodless_base.parameters import ParameterError
from rodless_base.ros.cdr import pack_float64
from rodless_base.ros.publish import OnDemand, Outbox
from rodless_control.controller import Law
from rodless_control.loop import Output

REFERENCE = "reference"


class Telemetry:
    """The reference (m) and each of the law's terms, in units of its own, below the node's name."""

    def __init__(self, node: Node, law: Law, qos: QoSProfile | int) -> None:
        """Make the publishers, with the quality of service of the commands."""
        self._node = node
        self._qos = qos
        self._outbox = Outbox(node)
        self._publishers: dict[str, OnDemand] = {}
        self.offer((REFERENCE, *law.TERMS))

    def offer(self, names: Iterable[str]) -> None:
        """Make the publishers that are missing; raises ParameterError where one cannot be."""
        for name in names:
            if name in self._publishers:
                continue
            try:
                publisher = self._node.create_publisher(Float64, f"~/{name}", self._qos)
            except rclpy_implementation.RCLError as error:  # such as by a security policy
                raise ParameterError(f"~/{name} cannot be published: {described(error)}") from error
            self._publishers[name] = OnDemand(publisher, pack_float64, self._outbox)

    def keep_only(self, terms: Iterable[str]) -> None:
        """Leave out all but the reference and these ``terms``."""
        for name in self._publishers.keys() - {REFERENCE, *terms}:
            self._publishers.pop(name).close(self._node)

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
