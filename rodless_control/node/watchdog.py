# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether positions come, and what is safe to do while they do not."""

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from rodless_base.ros.diagnostics import DIAGNOSTICS
from rodless_control.loop import ControlLoop
from rodless_control.node.position_watch import STALL, PlantReport, PositionWatch, plant_report


class Watchdog:
    """Closes the valve while positions do not come; in lock-step it waits, as the plant does."""

    def __init__(
        self,
        node: Node,
        loop: ControlLoop,
        timeout: Callable[[], float],
        close_valve: Callable[[], None],
        hold: Callable[[], None],
    ) -> None:
        """Watch from now on.

        ``timeout`` gives ``controller.position_timeout`` (wall-clock s). ``close_valve`` sends one
        command, ``hold`` has the law wait for positions besides.
        """
        self._node = node
        self._loop = loop
        self._timeout = timeout
        self._command_closed = close_valve
        self._hold = hold
        self._watch = PositionWatch()
        self._arrived = self._following = self._lost = self._closed = False
        node.create_subscription(DiagnosticArray, DIAGNOSTICS, self._take_diagnostics, 10)

    def begin(self) -> None:
        """Take note that positions may come from now on."""
        self._watch.arrive()

    def arrive(self) -> None:
        """Take note of a position of now."""
        self._arrived = True

    @property
    def report(self) -> PlantReport | None:
        """What the plant last said of its time, if it is one that does."""
        return self._watch.report

    @property
    def simulated(self) -> bool:
        """Whether the node is told that time is the plant's."""
        return bool(self._node.get_parameter("use_sim_time").value)

    @property
    def _may_command_unprompted(self) -> bool:
        """Whether to send commands without a sample: never in lock-step.

        A simulated plant that has not begun waits for nobody's command, and where one has gone, its
        reports too, the next may be in lock-step. So may one that has not said yet what it is: it
        is given a moment to send its first position.
        """
        if self._timeout() <= 0.0 or self.in_lockstep:
            return False
        if self.simulated:
            return self._lost and self._watch.reports_come
        return self._lost or self._watch.missing(min(self._timeout(), STALL), simulated=False)

    def _close_valve(self) -> None:
        self._closed = True
        self._command_closed()

    @property
    def problem(self) -> str | None:
        """That no positions come now, if so, and what has been done about it."""
        if self._following or self._arrived:
            return None
        stands = self.in_lockstep and (self._lost or self.report is not None)
        # That of a simulated plant is closed before its first command.
        closed = "valve closed" if self._closed or self.simulated else "valve not commanded"
        return f"no position{self._with_pressures}: {'plant stands still' if stands else closed}"

    def poll(self) -> None:
        """Let time pass; to be called every ``WATCH_PERIOD``."""
        self._watch.poll()
        if self._arrived:
            self._follow()
        elif not self._following:
            if self._may_command_unprompted:
                self._close_valve()
        elif self._watch.missing(self._timeout(), self.simulated):
            self._lose()

    @property
    def in_lockstep(self) -> bool:
        """Whether the plant may count commands: one that nobody has asked for is then too many."""
        return self.simulated if self.report is None else self.plant_waits

    @property
    def plant_waits(self) -> bool:
        """Whether the plant has said that it waits for the answer to each sample."""
        return self.report is not None and self.report.mode == "lockstep"

    @property
    def _with_pressures(self) -> str:
        return " with pressures of its stamp" if self._loop.law.USES_PRESSURES else ""

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            report = plant_report(status, self._node.get_namespace())
            if report is not None:
                self._watch.hear(report)

    def _follow(self) -> None:
        self._arrived, self._following, self._closed = False, True, False
        self._watch.arrive()
        if self._lost:
            self._lost = False
            self._node.get_logger().info(f"positions{self._with_pressures} come again")

    def _lose(self) -> None:
        self._following, self._lost = False, True
        if self.in_lockstep:
            # The plant stands still without a command. A run must not depend on the wall clock.
            self._loop.lost += 1
            safe = "no command until the next one, a lock-step plant stands still"
        else:
            self._hold()
            self._close_valve()
            safe = "commanding a closed valve"
        self._node.get_logger().warning(
            f"positions{self._with_pressures} have stopped coming: {safe}"
        )
