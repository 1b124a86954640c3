# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the controller says at its start, and once positions are answered."""

from rclpy.node import Node

from rodless_base.ros.diagnostics import PERIOD
from rodless_base.topics import JOINT_STATES
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.node.position_watch import REPORT_TIMEOUT, WATCH_PERIOD
from rodless_control.node.watchdog import Watchdog
from rodless_control.setpoint import FROM_PARAMETERS


class Readiness:
    """Says once, when positions are answered, how the rig runs and what to do next.

    A plant that has said nothing of itself by then, such as a real one, is left out.
    """

    def __init__(self, node: Node, watchdog: Watchdog) -> None:
        """Say it in the log of ``node``."""
        self._node = node
        self._watchdog = watchdog
        self._polls = 0
        self._said = False

    def poll(self, answered: bool, values: ControllerParameters, setpoints: str) -> None:
        """Say it if it is time to; to be called every ``WATCH_PERIOD``.

        ``answered``: whether a position has been; ``setpoints``: the topic to move the rig by.
        """
        if self._said or not answered:
            return
        self._polls += 1
        longest = REPORT_TIMEOUT if self._watchdog.simulated else 1.5 * PERIOD
        report = self._watchdog.report
        self._said = report is not None or self._polls * WATCH_PERIOD > longest
        if self._said:
            plant = report.text() + ", " if report is not None else ""
            line = f"ready: {plant}{_law_and_reference(values)}; {self._next(values, setpoints)}"
            self._node.get_logger().info(line)

    def _next(self, values: ControllerParameters, setpoints: str) -> str:
        if values.text("reference.type") in FROM_PARAMETERS:
            return "it moves by itself"
        where = self._node.get_namespace()
        option = f" --namespace {where}" if where != "/" else ""
        move = f"move it with a set-point on {setpoints}"
        # The command knows the nodes by their names.
        named = self._node.get_name() == "controller"
        return f"{move}: rodless move 58{option}" if named else move


def started_line(node: Node, values: ControllerParameters) -> str:
    """Return the line of a ``node`` that waits for its first position."""
    topic = node.resolve_topic_name(JOINT_STATES)
    return f"started: {_law_and_reference(values)}; waiting for positions on {topic}"


def _law_and_reference(values: ControllerParameters) -> str:
    law, reference = values.text("controller.law"), values.text("reference.type")
    return f"law {law}, reference {reference}"
