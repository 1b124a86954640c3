# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The controller as a ROS node: each sample of the rig triggers one valve command."""

import sys

from rclpy.logging import get_logger
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from rodless_base.constants import CARRIAGE
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.in_process import DirectNode
from rodless_base.ros.logs import log_through
from rodless_base.ros.own_time import tell_time, without_clock_topic
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.process import check_arguments, run_node
from rodless_base.ros.profiles import settle_transports
from rodless_base.ros.publish import NOT_RECEIVED
from rodless_base.ros.readings import PositionReader
from rodless_base.ros.topic_types import check_topic_types
from rodless_base.ros.topics import ANSWERS_DEPTH
from rodless_base.start import Stop
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.law_calls import LawCalls
from rodless_control.loop import ControlLoop
from rodless_control.node.answers import DISABLED, Answers
from rodless_control.node.controller_diagnostics import ControllerDiagnostics
from rodless_control.node.inputs import Inputs
from rodless_control.node.law_parameters import LawChoice, parameters_of_law
from rodless_control.node.position_watch import WATCH_PERIOD
from rodless_control.node.ready import Readiness, started_line
from rodless_control.node.reference_inputs import ReferenceInputs
from rodless_control.node.watchdog import Watchdog
from rodless_control.parameters import LAW

# What ~/reset and ~/enable answer.
HOLDS = "holds where it is until a new set-point comes"


def resumes(values: ControllerParameters) -> str:
    """Say what a controller does that begins anew."""
    number = values.number
    match values.text("reference.type"):
        case "sine":
            return "begins its sine anew, from its centre"
        case "step":
            return (
                f"goes to {number('reference.target'):g} m, before plant time "
                f"{number('reference.at'):g} s to {number('reference.start'):g} m"
            )
    return HOLDS


class ControllerNode:
    """The law of ``controller.law`` on the rig's samples, commanding ``valve/voltage``."""

    def __init__(self, **node_options: object) -> None:
        """Start; raises ParameterError for parameters that are no controller's."""
        self.node = DirectNode(
            "controller", automatically_declare_parameters_from_overrides=True, **node_options
        )
        check_topic_types(self.node)
        self._clock = without_clock_topic(self.node)
        kind, given = parameters_of_law(self.node)
        choice = LawChoice(given, kind.DECLARATIONS[LAW].default)
        self._parameters = RosParameters(self.node, kind, self._configure, given, choice.next)
        self._loop = ControlLoop(self._parameters.values)
        # The name, and the parameters that it is from: it is asked for with every sample.
        self._joint_name = ""
        self._joint_of: ControllerParameters | None = None
        self._answers = Answers(
            self.node,
            self._loop,
            ANSWERS_DEPTH,
            lambda: self._number("controller.neutral_voltage"),
            lambda: self._watchdog.plant_waits,
        )
        self._inputs = Inputs(
            self.node,
            self._loop.law.USES_PRESSURES,
            self._joint,
            self._answers.take,
        )
        self._references = ReferenceInputs(
            self.node, self._loop.setpoints, self._joint, self._obstacle
        )
        self._watchdog = Watchdog(
            self.node,
            self._loop,
            lambda: self._number("controller.position_timeout"),
            self._answers.close_valve,
            self._answers.hold,
        )
        self._answers.on_answer = self._watchdog.arrive
        self._diagnostics = ControllerDiagnostics(
            self.node, self._loop, self._inputs, self._references, self._watchdog, self._answers
        )
        self._readiness = Readiness(self.node, self._watchdog)
        self.node.create_service(Trigger, "~/reset", self._reset)
        self.node.create_service(SetBool, "~/enable", self._enable)
        self.node.make_safe = self._make_safe
        self.node.create_timer(WATCH_PERIOD, self._poll, clock=steady_clock())
        self.node.get_logger().info(started_line(self.node, self._parameters.values))

    def close(self) -> None:
        """Leave the valve closed, give readers time, and destroy the node."""
        has_begun = self._answers.any or not self._watchdog.simulated
        if has_begun and not self._watchdog.in_lockstep:
            self._answers.close_valve()
        if not self._answers.wait_for_readers(self.node.end_by):
            self.node.get_logger().warning(NOT_RECEIVED)
        self.node.destroy_node()

    def _number(self, name: str) -> float:
        return self._parameters.values.number(name)

    def _joint(self) -> str:
        values = self._parameters.values
        if values is not self._joint_of:
            self._joint_of = values
            self._joint_name = prefixed(values, values.text("controller.joint"))
        return self._joint_name

    def _obstacle(self) -> str | None:
        if not self._answers.enabled:
            return "the controller is disabled"
        return None if self._loop.failure is None else "the law has failed"

    def _configure(self, values: ControllerParameters) -> None:
        self._loop.setpoints.check(values)
        if values.text(LAW) != self._parameters.values.text(LAW):
            self._change_law(values)
        else:
            self._loop.configure(values)
        self._answers.report_failure()

    def _change_law(self, values: ControllerParameters) -> None:
        """Make another law, which may take seconds: meanwhile the valve is closed."""
        self._close_valve_at_once()
        telemetry = self._answers.telemetry
        try:
            telemetry.offer(values.LAW_CLASS.TERMS)
            if values.LAW_CLASS.USES_PRESSURES:
                self._inputs.use_pressures(True)
            self._loop.change_law(values)
        finally:
            # Of the law that is in force now, whichever that is.
            telemetry.keep_only(self._loop.law.TERMS)
            self._inputs.use_pressures(self._loop.law.USES_PRESSURES)
        before = self._parameters.values.text(LAW)
        now = resumes(values) if self._answers.enabled else DISABLED
        self.node.get_logger().info(f"law {values.text(LAW)} in place of {before}: {now}")

    def _close_valve_at_once(self) -> None:
        """Close it by a command that no sample asks for; in lock-step each answers one."""
        if self._inputs.subscribed and not self._watchdog.in_lockstep:
            self._answers.close_valve()

    def _make_safe(self, reason: str) -> None:
        self._loop.stop(reason)
        self._close_valve_at_once()

    def _poll(self) -> None:
        tell_time(self._clock, self._answers.stamp)
        self._answers.poll()
        self._subscribe_once_matched()
        self._watchdog.poll()
        self._readiness.poll(
            self._answers.any, self._parameters.values, self._references.setpoint_topic
        )

    def _subscribe_once_matched(self) -> None:
        """Take the first sample only when its answer will reach everybody who waits for it.

        Then the plant and the recorders are matched with the publisher of commands.
        """
        recorders = self._number("controller.recorders")
        if not self._inputs.subscribed and self._answers.listeners > recorders:
            self._inputs.subscribe()
            self._watchdog.begin()

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        # In this order: a law that fails again at once is counted.
        self._diagnostics.clear()
        self._answers.reset()
        # Also of a law that has failed again: a rig is reset with it, its valve closed.
        response.success = True
        response.message = self._answers.failure or DISABLED
        if self._answers.enabled and self._answers.failure is None:
            response.message = resumes(self._parameters.values)
        return response

    def _enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        begins = self._answers.enable(request.data)
        if not request.data:  # the next sample may be long in coming
            self._close_valve_at_once()
        failed = self._answers.failure if request.data else None
        response.success = failed is None
        response.message = failed or DISABLED
        if request.data and response.success:
            now = resumes(self._parameters.values) if begins else "it was already, and goes on"
            response.message = f"enabled: {now}"
        return response


def load() -> None:
    """Load the compiled control law: neither the first command nor a new gain waits for it."""
    log_through("controller")
    get_logger("controller").info("loading the compiled control law")
    parameters = ControllerParameters()
    loop = ControlLoop(parameters)
    loop.sample(Measurement(0, 0.0))
    loop.configure(parameters.with_values({"controller.kp": 0.0}))
    PositionReader().read(serialize_message(JointState()), CARRIAGE)


def main(stop: Stop) -> int:
    """Run the controller until ``stop``."""
    check_arguments("controller")
    settle_transports(sys.argv)
    load()
    LawCalls.break_off_once_asked(stop)
    return run_node(ControllerNode, stop)
