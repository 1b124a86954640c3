# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Internal signals of the controller as topics, for plotting."""

from collections.abc import Iterable, Mapping
from time import monotonic

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.one_line import described
from rodless_base.parameters import ParameterError
from rodless_base.ros.cdr import pack_float64
from rodless_base.ros.publish import OnDemand, Outbox, Throttled, wait_for_readers
from rodless_base.ros.topics import LAST_ONE
from rodless_base.topics import THROTTLED
from rodless_control.controller import Law
from rodless_control.loop import Output

REFERENCE = "reference"

# How long a signal that is left out waits for its readers, in wall-clock s.
LEAVING = 5.0


class Telemetry:
    """The reference (m) and each of the law's terms, in units of its own, below the node's name.

    Each a second time for whoever only looks on, throttled to one value at each :meth:`poll`.
    """

    def __init__(self, node: Node, law: Law, qos: QoSProfile | int) -> None:
        """Make the publishers, with the quality of service of the commands."""
        self._node = node
        self._qos = qos
        self._outbox = Outbox(node)
        self._throttled_outbox = Outbox(node)
        self._publishers: dict[str, OnDemand] = {}
        self._throttled: dict[str, OnDemand] = {}
        # Of a law before, and until when (s, monotonic): readers may be behind.
        self._leaving: dict[str, tuple[OnDemand, OnDemand, float]] = {}
        self._output = Throttled[Output](self._throttled_outbox)
        self.offer((REFERENCE, *law.TERMS))

    def offer(self, names: Iterable[str]) -> None:
        """Make the publishers that are missing; raises ParameterError where one cannot be."""
        for name in names:
            if name in self._publishers:
                continue
            if name in self._leaving:
                self._publishers[name], self._throttled[name], _ = self._leaving.pop(name)
                continue
            topic = f"{THROTTLED}{self._node.get_name()}/{name}"
            throttled = self._publisher(topic, LAST_ONE, self._throttled_outbox)
            # Both or none.
            self._publishers[name] = self._publisher(f"~/{name}", self._qos, self._outbox)
            self._throttled[name] = throttled

    def _publisher(self, topic: str, qos: QoSProfile | int, outbox: Outbox) -> OnDemand:
        try:
            publisher = self._node.create_publisher(Float64, topic, qos)
        except rclpy_implementation.RCLError as error:  # such as by a security policy
            raise ParameterError(f"{topic} cannot be published: {described(error)}") from error
        return OnDemand(publisher, pack_float64, outbox)

    def keep_only(self, terms: Iterable[str]) -> None:
        """Leave out all but the reference and these ``terms``."""
        self._output.last = None  # has those of the law before
        until = monotonic() + LEAVING
        for name in self._publishers.keys() - {REFERENCE, *terms}:
            self._leaving[name] = self._publishers.pop(name), self._throttled.pop(name), until
        self._let_go()

    def _let_go(self) -> None:
        """End the publishers of a law before, once their readers have all or do not take it."""
        for name, (publisher, throttled, until) in list(self._leaving.items()):
            now = monotonic()
            if now > until or wait_for_readers(self._outbox, [publisher.publisher], now):
                del self._leaving[name]
                publisher.close(self._node)
                throttled.close(self._node)

    def poll(self) -> None:
        """Look up which signals have subscribers, and send what was held back, and the last."""
        self._outbox.flush()
        self._let_go()
        for publisher in self._publishers.values():
            publisher.poll()
        due = self._output.due(self._throttled.values())
        if due is not None:
            _publish(self._throttled, due)

    def wait_for_readers(self, deadline: float) -> bool:
        """Give whoever reads the signals time, to ``deadline``; return whether they have them."""
        leaving = [publisher for publisher, _, _ in self._leaving.values()]
        offered = [*self._publishers.values(), *leaving]
        heard = [one.publisher for one in offered if one.subscribers]
        return wait_for_readers(self._outbox, heard, deadline)

    @property
    def lost(self) -> int:
        """Messages lost to a stopped subscriber."""
        return self._outbox.lost

    def publish(self, output: Output) -> None:
        """Publish what has subscribers."""
        _publish(self._publishers, output)
        self._output.last = output


def _publish(publishers: Mapping[str, OnDemand], output: Output) -> None:
    values = {REFERENCE: output.reference, **output.terms}
    for name, publisher in publishers.items():
        # A sample that is offered again has the terms of the law that answered it.
        if publisher.subscribers and name in values:
            publisher.publish(values[name])
