# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the controller reports of itself: whether it controls, and what went wrong."""

from rodless_base.fault_counts import lately_text
from rodless_base.ros.diagnostics import (
    CLOSED_VALVE,
    ENABLED,
    LAST_COMMAND,
    OF_THE_LAW,
    PERIOD,
    Diagnostics,
    judge,
    steady_clock,
)
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.publish import LOST
from rodless_control.controller import law_name
from rodless_control.loop import ControlLoop
from rodless_control.node.answers import DISABLED, Answers
from rodless_control.node.inputs import Inputs
from rodless_control.node.reference_inputs import ReferenceInputs
from rodless_control.node.watchdog import Watchdog

# How often a law that is too slow is said to be.
SLOW_LAW_PERIOD = 10.0


class ControllerDiagnostics:
    """Reports once a second, and each failure of the law at once."""

    def __init__(
        self,
        node: GuardedNode,
        loop: ControlLoop,
        inputs: Inputs,
        references: ReferenceInputs,
        watchdog: Watchdog,
        answers: Answers,
    ) -> None:
        """Report of these from now on."""
        self._node = node
        self._loop = loop
        self._inputs = inputs
        self._references = references
        self._watchdog = watchdog
        self._answers = answers
        self._diagnostics = Diagnostics(node, self._faults)
        answers.on_failure = self.publish
        node.create_timer(PERIOD, self.publish, clock=steady_clock())

    def clear(self) -> None:
        """Count faults from now on."""
        self._diagnostics.clear()

    def publish(self) -> None:
        """Report now."""
        faults = self._diagnostics.count()
        slow = self._answers.pace.news(law_name(self._loop.law))
        if slow is not None:
            self._node.get_logger().warning(slow, throttle_duration_sec=SLOW_LAW_PERIOD)
        target = self._loop.setpoints.target
        self._diagnostics.publish(
            self._answers.stamp,
            self._judge(slow),
            {
                "set-point (m)": "none" if target is None else f"{target:g}",
                ENABLED: self._answers.enabled,
                LAST_COMMAND: OF_THE_LAW if self._answers.by_law else CLOSED_VALVE,
                **faults,
                "law's time per sample (ms)": f"{self._answers.pace.law_time * 1e3:.3g}",
            },
        )

    def _faults(self) -> dict[str, int]:
        """Return how often each fault has happened since the start."""
        loop, inputs = self._loop, self._inputs
        return {
            "positions lost": loop.lost,
            "positions not finite": loop.not_finite,
            "samples without the joint": inputs.without_joint,
            "set-points refused": self._references.refused,
            "restarts by time running backwards": loop.restarts,
            "failures of the law": loop.failures,
            LOST: self._answers.lost,
            "samples skipped": self._answers.pace.skipped,
            "samples without all pressures": inputs.incomplete,
        }

    def _judge(self, slow: str | None) -> tuple[bytes, str]:
        warning = slow or lately_text(self._diagnostics.lately())
        if not self._answers.enabled:
            warning = DISABLED
        namesakes = self._diagnostics.namesakes.problem
        return judge(self._problem(), None, (namesakes, warning), "controlling")

    def _problem(self) -> str | None:
        """What keeps the controller from controlling now, unless that is by request."""
        if (failure := self._answers.failure) is not None:
            return failure
        if (missing := self._watchdog.problem) is not None:
            return missing
        if (obstacle := self._answers.obstacle) is not None:
            return f"{obstacle}: no command gets out"
        return self._answers.refusal
