"""The controller as a ROS node: each position sample triggers one valve command."""

from time import monotonic_ns

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.logging import get_logger
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.diagnostics import (
    ERROR,
    OK,
    PERIOD,
    WARN,
    diagnostic,
    diagnostics_publisher,
    steady_clock,
)
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.process import run_node
from rodless_base.ros.publish import send
from rodless_base.ros.topics import (
    JOINT_STATES,
    LOSSLESS,
    NANOSECONDS,
    QUEUE_DEPTH,
    VALVE_VOLTAGE,
    stamp_nanoseconds,
)
from rodless_base.start import Stop
from rodless_control.loop import ControlLoop
from rodless_control.node.telemetry import Telemetry
from rodless_control.parameters import PidParameters

# How often, in wall-clock seconds, the node looks whether positions still come.
WATCH_PERIOD = 0.02

# How long the last command may take to arrive; less than Ctrl-C promises.
LAST_WORD = Duration(seconds=0.5)


class ControllerNode:
    """PID on ``joint_states``, commanding ``valve/voltage``."""

    def __init__(self, **node_options: object) -> None:
        """Listen; raises ParameterError for parameters that are no controller's."""
        self.node = Node(
            "controller", automatically_declare_parameters_from_overrides=True, **node_options
        )
        self._parameters = RosParameters(self.node, PidParameters, self._configure)
        self._loop = ControlLoop(self._parameters.values)
        self._enabled = True
        self._arrival: int | None = None
        self._arrived = False
        self._refused = False
        self._stamp = Time()
        self._bad_setpoints = self._bad_samples = 0
        self._listening = False
        self._make_interface()

    def close(self) -> None:
        """Leave the valve closed and destroy the node."""
        if self._may_speak_unasked:
            self._command_neutral()
            # Destroyed at once, the publisher would take the message with it.
            self._voltage.wait_for_all_acked(LAST_WORD)
        self.node.destroy_node()

    def _make_interface(self) -> None:
        recorded = self._parameters.values.number("controller.recorders") > 0
        qos = LOSSLESS if recorded else QUEUE_DEPTH
        self._voltage = self.node.create_publisher(Float64, VALVE_VOLTAGE, qos)
        self._telemetry = Telemetry(self.node, qos)
        self._diagnostics = diagnostics_publisher(self.node)
        self.node.create_subscription(Float64, "setpoint", self._take_setpoint, 10)
        self.node.create_service(Trigger, "~/reset", self._reset)
        self.node.create_service(SetBool, "~/enable", self._enable)
        self.node.create_timer(WATCH_PERIOD, self._watch, clock=steady_clock())
        self.node.create_timer(PERIOD, self._publish_diagnostics, clock=steady_clock())

    def _configure(self, values: PidParameters) -> None:
        self._loop.configure(values)

    def _take_sample(self, message: JointState) -> None:
        position = self._position(message)
        if position is None:
            return
        self._arrived = True
        self._stamp = message.header.stamp
        stamp = stamp_nanoseconds(message.header.stamp)
        output = self._loop.sample(position, stamp) if self._enabled else None
        self._refused = self._enabled and output is None
        if output is None:
            self._command_neutral()
        else:
            send(self._voltage, Float64(data=output.command.voltage))
            self._telemetry.publish(output)

    def _position(self, message: JointState) -> float | None:
        """The carriage's position; a message without it counts as no sample at all."""
        joint = self._parameters.values.text("controller.joint")
        if joint not in message.name or len(message.position) != len(message.name):
            self._bad_samples += 1
            return None
        return float(message.position[message.name.index(joint)])

    def _take_setpoint(self, message: Float64) -> None:
        try:
            self._loop.setpoints.receive(message.data)
        except ValueError as error:
            self._bad_setpoints += 1
            self.node.get_logger().warning(str(error))

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._loop.reset()
        response.success = True
        return response

    def _enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data and not self._enabled:
            self._loop.reset()
        self._enabled = request.data
        response.success = True
        response.message = "enabled" if self._enabled else "disabled: valve closed"
        return response

    @property
    def _simulated(self) -> bool:
        """Whether time is the plant's: a paused plant is then not taken for lost."""
        return bool(self.node.get_parameter("use_sim_time").value)

    @property
    def _may_speak_unasked(self) -> bool:
        """Whether to send commands that no sample asked for; a lock-step plant counts them."""
        timeout = self._parameters.values.number("controller.position_timeout")
        return timeout > 0.0 and not self._simulated

    def _now(self) -> int:
        return int(self.node.get_clock().now().nanoseconds) if self._simulated else monotonic_ns()

    def _listen_once_heard(self) -> None:
        """Take the first sample only when its answer will reach everybody who waits for it."""
        recorders = self._parameters.values.number("controller.recorders")
        if self._listening or self._voltage.get_subscription_count() <= recorders:
            return
        self._listening = True
        self.node.create_subscription(JointState, JOINT_STATES, self._take_sample, QUEUE_DEPTH)

    def _watch(self) -> None:
        self._telemetry.poll()
        self._listen_once_heard()
        if self._arrived:
            self._arrival, self._arrived = self._now(), False
        elif self._arrival is None:
            if self._may_speak_unasked:
                self._command_neutral()
        elif self._positions_are_missing(self._now() - self._arrival):
            self._arrival = None
            self._loop.hold()
            self.node.get_logger().warning(
                "positions have stopped coming: commanding a closed valve"
            )
            self._command_neutral()

    def _positions_are_missing(self, silence: int) -> bool:
        timeout = self._parameters.values.number("controller.position_timeout")
        return 0.0 < timeout * NANOSECONDS < silence

    def _command_neutral(self) -> None:
        neutral = self._parameters.values.number("controller.neutral_voltage")
        send(self._voltage, Float64(data=neutral))

    def _publish_diagnostics(self) -> None:
        faults = {
            "positions lost": self._loop.lost,
            "positions not finite": self._loop.not_finite,
            "samples without the joint": self._bad_samples,
            "set-points refused": self._bad_setpoints,
            "restarts by time running backwards": self._loop.restarts,
        }
        level, text = self._judge(faults)
        self._diagnostics.publish(diagnostic(self.node, self._stamp, level, text, faults))

    def _judge(self, faults: dict[str, int]) -> tuple[bytes, str]:
        """Level and message: an error now, a warning for past faults, or all well."""
        if self._arrival is None:
            return ERROR, "no position: valve closed"
        if not self._enabled:
            return WARN, "disabled: valve closed"
        if self._refused:
            return ERROR, "position not finite: valve closed"
        seen = [name for name, count in faults.items() if count]
        if seen:
            return WARN, "since start: " + ", ".join(seen)
        return OK, "controlling"


def load() -> None:
    """Load the compiled control law, so that the first command does not wait for it."""
    get_logger("controller").info("loading the compiled control law (the first start compiles it)")
    ControlLoop(PidParameters()).sample(0.0, 0)


def main(stop: Stop) -> int:
    """Run the controller until ``stop``."""
    load()
    return run_node(ControllerNode, stop)
