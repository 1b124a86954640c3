# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages that a stopped subscriber keeps from being sent are counted."""

from collections.abc import Iterator
from time import time_ns

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.impl.implementation_singleton import rclpy_implementation

from rodless_base.measurement import Measurement
from rodless_base.ros import publish
from rodless_control.node.controller_node import ControllerNode
from rodless_lab.session.observer import Observer

NAME = "/lossy/controller"


class Blocked:
    """A publisher whose queue is full and stays so."""

    topic_name = "/lossy/valve/voltage"

    def publish(self, _message: object) -> None:
        """Fail as rclpy does then."""
        raise rclpy_implementation.RCLError("Failed to publish: the queue is full")

    def get_subscription_count(self) -> int:
        """One that has stopped."""
        return 1


# What comes with a message that has just been sent.
NOW = dict.fromkeys(("source_timestamp", "received_timestamp"), time_ns())


@pytest.fixture
def controller(observer: Observer) -> Iterator[ControllerNode]:
    """Return a controller that nothing spins, in the test's own process."""
    controller = ControllerNode(context=observer.context, namespace="/lossy")
    yield controller
    controller.node.destroy_node()


def test_commands_and_telemetry_that_are_lost_stand_among_the_faults(
    observer: Observer, controller: ControllerNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of four each that are held back one is kept and three are lost; the reader is named."""
    monkeypatch.setattr(publish, "QUEUE_DEPTH", 1)
    reference = controller._answers.telemetry._publishers["reference"]
    for k in range(5):
        if k == 1:
            monkeypatch.setattr(controller._answers, "_voltage", Blocked())
            monkeypatch.setattr(reference, "_publisher", Blocked())
            reference.poll()
        controller._answers.take(Measurement(k * 1_000_000, 0.05), NOW)
    controller._poll()

    def published() -> bool:
        controller._diagnostics.publish()
        return NAME in observer.diagnostics

    observer.wait(published, "diagnostics")
    assert observer.diagnostics[NAME].level == DiagnosticStatus.ERROR
    assert "a subscriber of /lossy/valve/voltage has stopped" in observer.diagnostics[NAME].message
    assert observer.counter(NAME, "messages lost to a stopped subscriber") == 6
