# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the plant says of its faults: on ``/diagnostics``, and latched on a topic of its own."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from rodless_base.ros.diagnostics import OK, WARN, report, status
from rodless_base.ros.publish import Outbox
from rodless_base.ros.topics import LATCHED
from rodless_base.topics import FAULTS
from rodless_sim.faults import active
from rodless_sim.parameters import RigParameters

NONE = "none"


def faults_text(parameters: RigParameters) -> str:
    """Name the faults that are active, with their values."""
    return ", ".join(f"{name} {value}" for name, value in active(parameters).items()) or NONE


def fault_status(node: Node, parameters: RigParameters) -> DiagnosticStatus:
    """Return the faults of a plant as a diagnostic: a warning while any is active."""
    found = active(parameters)
    judgement = (WARN if found else OK, faults_text(parameters))
    return status(node, judgement, found, part="faults")


class FaultPublisher:
    """Publishes what faults there are when that changes, stamped with the first sample of it."""

    def __init__(self, node: Node, outbox: Outbox) -> None:
        """Publish nothing yet; messages go out through ``outbox``, before their sample."""
        self._node = node
        self._outbox = outbox
        self._publisher = node.create_publisher(DiagnosticArray, FAULTS, LATCHED)
        self._last: tuple[dict[str, str], int] | None = None

    def publish(self, parameters: RigParameters, nanoseconds: int) -> None:
        """Publish the faults of ``parameters`` at a plant time (ns), if they are others."""
        found = active(parameters)
        if self._last is not None and found == self._last[0] and nanoseconds >= self._last[1]:
            return
        self._last = found, nanoseconds
        message = report([fault_status(self._node, parameters)], nanoseconds)
        self._outbox.send(self._publisher, message)
