"""The controller as a ROS node: each sample of the rig triggers one valve command."""

from time import perf_counter, time_ns

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.logging import get_logger
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.constants import NANOSECONDS_PER_SECOND, SECONDS_PER_NANOSECOND
from rodless_base.fault_counts import FaultCounts, lately_text
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.parameters import ParameterError
from rodless_base.ros.diagnostics import (
    DIAGNOSTICS,
    ERROR,
    OK,
    PERIOD,
    WARN,
    diagnostic,
    diagnostics_publisher,
    steady_clock,
)
from rodless_base.ros.given import given_parameters
from rodless_base.ros.in_process import DirectNode
from rodless_base.ros.logs import log_through
from rodless_base.ros.message_info import Info
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.process import run_node
from rodless_base.ros.publish import LOST, Outbox
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, SETPOINT, VALVE_VOLTAGE
from rodless_control.controller import law_name
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.loop import ControlLoop, Output
from rodless_control.node.inputs import Inputs
from rodless_control.node.law_pace import LawPace
from rodless_control.node.position_watch import (
    REPORT_TIMEOUT,
    WATCH_PERIOD,
    PositionWatch,
    plant_report,
)
from rodless_control.node.reference_inputs import ReferenceInputs
from rodless_control.node.telemetry import Telemetry
from rodless_control.parameters import NODE_PARAMETERS

# How long the last command may take to arrive; less than Ctrl-C promises.
LAST_COMMAND_TIMEOUT = Duration(seconds=0.5)

# Warnings that could come with every message, in wall-clock seconds; diagnostics count them all.
WARNING_PERIOD = 1.0

# How often a law that is too slow is said to be.
SLOW_LAW_PERIOD = 10.0

# What ~/reset and ~/enable answer.
HOLDS = "holds where it is until a new set-point comes"

# What is said with the failure of a law.
CLOSED_BY_FAILURE = "valve closed until ~/reset or ~/enable"


class ControllerNode:
    """The law of ``controller.law`` on the rig's samples, commanding ``valve/voltage``."""

    def __init__(self, **node_options: object) -> None:
        """Start; raises ParameterError for parameters that are no controller's."""
        self.node = DirectNode(
            "controller", automatically_declare_parameters_from_overrides=True, **node_options
        )
        kind = self._parameters_of_law()
        self._parameters = RosParameters(self.node, kind, self._configure)
        self._loop = ControlLoop(self._parameters.values)
        self._pace = LawPace()
        self._inputs = Inputs(
            self.node,
            self._loop.law.USES_PRESSURES,
            self._joint,
            self._take_sample,
        )
        self._enabled = True
        self._position_watch = PositionWatch()
        self._arrived = self._following = self._lost = False
        self._counts = FaultCounts()
        self._refused = False
        self._reported: str | None = None
        self._stamp = 0
        self._bad_setpoints = 0
        self._ready = self._answered = False
        self._ready_polls = 0
        self._make_interface()
        self.node.get_logger().info(self._started_line())

    def close(self) -> None:
        """Leave the valve closed and destroy the node."""
        if self._may_publish_unprompted:
            self._command_neutral()
            # Destroyed at once, the publisher would take the message with it.
            self._voltage.wait_for_all_acked(LAST_COMMAND_TIMEOUT)
        self.node.destroy_node()

    def _parameters_of_law(self) -> type[ControllerParameters]:
        """Return the node's set for the law it is given; what other laws are given is left out."""
        declared = NODE_PARAMETERS["controller.law"]
        given = given_parameters(self.node, ControllerParameters.NODE)
        name = declared.check(given.get(declared.name, declared.default))
        kind = ControllerParameters.for_law(str(name))
        others = given.keys() - kind.own(given).keys()
        for other in filter(self.node.has_parameter, others):
            self.node.undeclare_parameter(other)
        if others:
            self.node.get_logger().info(
                f"controller.law {name}: leaving out parameters of other laws: "
                + ", ".join(sorted(others))
            )
        return kind

    def _make_interface(self) -> None:
        recorded = self._parameters.values.number("controller.recorders") > 0
        qos = LOSSLESS if recorded else QUEUE_DEPTH
        self._voltage = self.node.create_publisher(Float64, VALVE_VOLTAGE, qos)
        self._outbox = Outbox(self.node)
        self._telemetry = Telemetry(self.node, self._loop.law, qos)
        self._diagnostics = diagnostics_publisher(self.node)
        self._references = ReferenceInputs(self.node, self._loop.setpoints, self._joint)
        self._setpoint = self.node.create_subscription(Float64, SETPOINT, self._take_setpoint, 10)
        self.node.create_subscription(DiagnosticArray, DIAGNOSTICS, self._take_diagnostics, 10)
        self.node.create_service(Trigger, "~/reset", self._reset)
        self.node.create_service(SetBool, "~/enable", self._enable)
        self.node.create_timer(WATCH_PERIOD, self._watch, clock=steady_clock())
        self.node.create_timer(PERIOD, self._publish_diagnostics, clock=steady_clock())

    @property
    def _law_and_reference(self) -> str:
        values = self._parameters.values
        law, reference = values.text("controller.law"), values.text("reference.type")
        return f"law {law}, reference {reference}"

    def _started_line(self) -> str:
        topic = self.node.resolve_topic_name(JOINT_STATES)
        return f"started: {self._law_and_reference}; waiting for positions on {topic}"

    def _report_ready(self) -> None:
        """Say once, when positions are answered, how the rig runs and what to do next.

        A plant that has said nothing of itself by then, such as a real one, is left out.
        """
        if not self._ready and self._answered:
            self._ready_polls += 1
            longest = REPORT_TIMEOUT if self._simulated else 1.5 * PERIOD
            self._ready = (
                self._position_watch.report is not None
                or self._ready_polls * WATCH_PERIOD > longest
            )
            if self._ready:
                self.node.get_logger().info(self._ready_line())

    def _ready_line(self) -> str:
        kind = self._parameters.values.text("reference.type")
        where = self.node.get_namespace()
        option = f" --namespace {where}" if where != "/" else ""
        next_step = (
            "it moves by itself"
            if kind in ("step", "sine")
            else f"move it with a set-point on {self._setpoint.topic_name}: rodless move 58{option}"
        )
        report = self._position_watch.report
        plant = report.text() + ", " if report is not None else ""
        return f"ready: {plant}{self._law_and_reference}; {next_step}"

    def _configure(self, values: ControllerParameters) -> None:
        self._loop.setpoints.check(values)
        self._loop.configure(values)
        self._report_failure()

    def _joint(self) -> str:
        values = self._parameters.values
        return prefixed(values, values.text("controller.joint"))

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            report = plant_report(status, self.node.get_namespace())
            if report is not None:
                self._position_watch.hear(report)

    def _take_sample(self, measurement: Measurement, info: Info) -> None:
        self._arrived = True
        self._stamp = measurement.stamp
        if self._enabled and self._must_skip(info):
            return
        output = self._answer(measurement) if self._enabled else None
        self._refused = self._enabled and output is None
        if output is None:
            self._command_neutral()
            self._report_failure()
        else:
            self._command(output.voltage)
            self._telemetry.publish(output)
            self._answered = True

    def _must_skip(self, info: Info) -> bool:
        # Some middlewares do not tell when a message was received.
        times = info["source_timestamp"], info["received_timestamp"] or info["source_timestamp"]
        sent, received, now = (time * SECONDS_PER_NANOSECOND for time in (*times, time_ns()))
        return self._pace.must_skip(sent, received, now)

    def _answer(self, measurement: Measurement) -> Output | None:
        began = perf_counter()
        output = self._loop.sample(measurement)
        self._pace.took(perf_counter() - began)
        return output

    def _report_failure(self) -> None:
        """Say once why the law is not called any more."""
        failure = self._loop.failure
        if failure is not None and failure != self._reported:
            self.node.get_logger().error(f"{failure}; {CLOSED_BY_FAILURE}")
        self._reported = failure

    def _take_setpoint(self, message: Float64) -> None:
        try:
            self._loop.setpoints.receive(message.data)
        except ParameterError as error:
            self._bad_setpoints += 1
            self.node.get_logger().warning(str(error), throttle_duration_sec=WARNING_PERIOD)

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._loop.reset()
        self._counts.clear(self._faults())
        self._report_failure()
        response.success = True
        response.message = HOLDS
        return response

    def _enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data and (not self._enabled or self._loop.failure):
            self._loop.reset()
            self._report_failure()
        self._enabled = request.data
        response.success = True
        response.message = f"enabled: {HOLDS}" if self._enabled else "disabled: valve closed"
        return response

    @property
    def _with_pressures(self) -> str:
        return " with pressures of its stamp" if self._loop.law.USES_PRESSURES else ""

    @property
    def _simulated(self) -> bool:
        """Whether the node is told that time is the plant's."""
        return bool(self.node.get_parameter("use_sim_time").value)

    @property
    def _in_lockstep(self) -> bool:
        """Whether the plant may count commands: one that nobody has asked for is then too many."""
        report = self._position_watch.report
        return self._simulated if report is None else report.mode == "lockstep"

    @property
    def _may_publish_unprompted(self) -> bool:
        """Whether to send commands without a sample: never in lock-step.

        A simulated plant that has not begun waits for nobody's command.
        """
        timeout = self._parameters.values.number("controller.position_timeout")
        return timeout > 0.0 and not self._in_lockstep and (self._lost or not self._simulated)

    def _subscribe_once_matched(self) -> None:
        """Take the first sample only when its answer will reach everybody who waits for it.

        Then the plant and the recorders are matched with the publisher of commands.
        """
        recorders = self._parameters.values.number("controller.recorders")
        if not self._inputs.subscribed and self._voltage.get_subscription_count() > recorders:
            self._inputs.subscribe()

    def _watch(self) -> None:
        self._outbox.flush()
        self._telemetry.poll()
        self._subscribe_once_matched()
        self._position_watch.poll()
        timeout = self._parameters.values.number("controller.position_timeout")
        if self._arrived:
            self._follow()
        elif not self._following:
            if self._may_publish_unprompted:
                self._command_neutral()
        elif self._position_watch.missing(timeout, self._simulated):
            self._lose_positions()
        self._report_ready()

    def _follow(self) -> None:
        self._arrived, self._following = False, True
        self._position_watch.arrive()
        if self._lost:
            self._lost = False
            self.node.get_logger().info(f"positions{self._with_pressures} come again")

    def _lose_positions(self) -> None:
        self._following, self._lost = False, True
        if self._in_lockstep:
            # The plant stands still without a command. A run must not depend on the wall clock.
            self._loop.lost += 1
            safe = "no command until the next one, a lock-step plant stands still"
        else:
            self._loop.hold()
            self._report_failure()
            self._command_neutral()
            safe = "commanding a closed valve"
        self.node.get_logger().warning(
            f"positions{self._with_pressures} have stopped coming: {safe}"
        )

    def _command_neutral(self) -> None:
        self._command(self._parameters.values.number("controller.neutral_voltage"))

    def _command(self, voltage: float) -> None:
        self._outbox.send(self._voltage, Float64(data=voltage))

    def _faults(self) -> dict[str, int]:
        """Return how often each fault has happened since the start."""
        loop, inputs = self._loop, self._inputs
        faults = {
            "positions lost": loop.lost,
            "positions not finite": loop.not_finite,
            "samples without the joint": inputs.without_joint,
            "set-points refused": self._bad_setpoints + self._references.refused,
            "restarts by time running backwards": loop.restarts,
            "failures of the law": loop.failures,
            LOST: self._outbox.lost + self._telemetry.lost,
            "samples skipped": self._pace.skipped,
        }
        if loop.law.USES_PRESSURES:
            faults["samples without all pressures"] = inputs.incomplete
        return faults

    def _publish_diagnostics(self) -> None:
        faults = self._counts.update(self._faults())
        slow = self._pace.news(law_name(self._loop.law))
        if slow is not None:
            self.node.get_logger().warning(slow, throttle_duration_sec=SLOW_LAW_PERIOD)
        level, text = self._judge(slow)
        values = {
            "set-point (m)": self._setpoint_text,
            **faults,
            "law's time per sample (ms)": f"{self._pace.law_time * 1e3:.3g}",
        }
        second, nanosecond = divmod(self._stamp, NANOSECONDS_PER_SECOND)
        stamp = Time(sec=second, nanosec=nanosecond)
        self._diagnostics.publish(diagnostic(self.node, stamp, level, text, values))

    @property
    def _setpoint_text(self) -> str:
        target = self._loop.setpoints.target
        return "none" if target is None else f"{target:g}"

    def _judge(self, slow: str | None) -> tuple[bytes, str]:
        """Level and message: an error now, a warning for faults of late, or all well."""
        problem = self._problem()
        if problem is not None:
            return ERROR, problem
        if not self._enabled:
            return WARN, "disabled: valve closed"
        lately = self._counts.lately()
        if slow is not None or lately:
            return WARN, slow or lately_text(list(lately))
        return OK, "controlling"

    def _problem(self) -> str | None:
        """What keeps the controller from controlling now, unless that is by request."""
        if self._loop.failure is not None:
            return f"{self._loop.failure}; {CLOSED_BY_FAILURE}"
        if not self._following and not self._arrived:
            safe = "plant stands still" if self._in_lockstep and self._lost else "valve closed"
            return f"no position{self._with_pressures}: {safe}"
        if self._outbox.obstacle is not None:
            return f"{self._outbox.obstacle}: no command gets out"
        if self._enabled and self._refused:
            used = "position or pressure" if self._loop.law.USES_PRESSURES else "position"
            return f"{used} not finite: valve closed"
        return None


def load() -> None:
    """Load the compiled control law, so that the first command does not wait for it."""
    log_through("controller")
    get_logger("controller").info("loading the compiled control law")
    ControlLoop(ControllerParameters()).sample(Measurement(0, 0.0))


def main(stop: Stop) -> int:
    """Run the controller until ``stop``."""
    load()
    return run_node(ControllerNode, stop)
