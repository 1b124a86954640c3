"""The plant as a ROS node: samples out, valve voltage in, parameters changeable while running."""

import threading
from functools import partial

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros_diagnostics import (
    ERROR,
    OK,
    PERIOD,
    WARN,
    diagnostic,
    diagnostics_publisher,
    steady_clock,
)
from rodless_base.ros_names import JOINT_STATES, QUEUE_DEPTH, VALVE_VOLTAGE
from rodless_base.ros_parameters import RosParameters
from rodless_base.ros_process import run_node
from rodless_base.start import Stop
from rodless_sim import plant_messages as messages
from rodless_sim.command import CommandInput
from rodless_sim.pacing import Pacer
from rodless_sim.parameters import RigParameters
from rodless_sim.rig import Rig, State
from rodless_sim.timing import nanoseconds


class PlantNode:
    """A rig in plant time, paced by the wall clock."""

    def __init__(self, **node_options: object) -> None:
        """Compile, settle and start; raises ParameterError for parameters that are no rig's."""
        self.node = Node(
            "plant", automatically_declare_parameters_from_overrides=True, **node_options
        )
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._paused = False
        self._parameters = RosParameters(self.node, RigParameters, self._configure)
        self._rig = Rig(self._parameters.values)
        self._command = CommandInput(*self._command_settings(self._parameters.values))
        self._period = self._parameters.values.number("time.period")
        self._pacer: Pacer | None = None
        self._compile()
        self._make_interface()
        self._thread = threading.Thread(target=self._run, name="plant", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the plant and destroy the node."""
        self._closing.set()
        self._thread.join()
        self.node.destroy_node()

    def _compile(self) -> None:
        self.node.get_logger().info("loading the compiled plant (the first start compiles it)")
        self._rig.advance(self._rig.state.voltage, self._period)
        self._rig.reset()

    def _make_interface(self) -> None:
        publisher = partial(self.node.create_publisher, qos_profile=QUEUE_DEPTH)
        self._joint_states = publisher(JointState, JOINT_STATES)
        self._pressure_a = publisher(FluidPressure, "chamber_a/pressure")
        self._pressure_b = publisher(FluidPressure, "chamber_b/pressure")
        self._supply = publisher(FluidPressure, "supply/pressure")
        self._clock = (
            publisher(Clock, "/clock") if self._parameters.values["time.publish_clock"] else None
        )
        self.node.create_subscription(Float64, VALVE_VOLTAGE, self._take_command, QUEUE_DEPTH)
        self.node.create_service(Trigger, "~/reset", self._reset)
        self.node.create_service(SetBool, "~/pause", self._pause)
        self.node.create_service(Trigger, "~/step", self._step_once)
        self._diagnostics = diagnostics_publisher(self.node)
        self.node.create_timer(PERIOD, self._publish_diagnostics, clock=steady_clock())

    @staticmethod
    def _command_settings(values: RigParameters) -> tuple[float, float]:
        return values.number("valve.closed_voltage"), values.number("valve.command_timeout")

    def _configure(self, values: RigParameters) -> None:
        with self._lock:
            self._rig.configure(values)
            self._command.configure(*self._command_settings(values))

    def _take_command(self, message: Float64) -> None:
        with self._lock:
            self._command.receive(message.data, self._rig.nanoseconds)

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self._command.reset()
            self._publish(self._rig.reset())
        response.success = True
        return response

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._paused = request.data
        response.success = True
        response.message = "paused" if self._paused else "running"
        return response

    def _step_once(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._paused
        if self._paused:
            self._step()
        else:
            response.message = "pause the plant first"
        return response

    def _run(self) -> None:
        with self._lock:
            self._publish(self._rig.state)
        wall_period = self._period / self._parameters.values.number("time.speed")
        self._pacer = Pacer(nanoseconds(wall_period))
        while self._pacer.wait(self._closing.is_set):
            if not self._paused:
                self._step()

    def _step(self) -> None:
        # Published under the lock, so that a reset cannot overtake the sample before it.
        with self._lock:
            voltage = self._command.voltage(self._rig.nanoseconds)
            self._publish(self._rig.advance(voltage, self._period))

    def _publish(self, state: State) -> None:
        time = self._rig.nanoseconds
        supply = self._rig.parameters.number("supply.pressure")
        if self._clock is not None:
            self._clock.publish(messages.clock(time))
        self._pressure_a.publish(messages.pressure(state.pressure_a, "chamber_a", time))
        self._pressure_b.publish(messages.pressure(state.pressure_b, "chamber_b", time))
        self._supply.publish(messages.pressure(supply, "supply", time))
        self._joint_states.publish(messages.joint_state(state, time))

    def _publish_diagnostics(self) -> None:
        with self._lock:
            time, command = self._rig.nanoseconds, self._command
            supply_flow = self._rig.free_air_flow
        overruns = 0 if self._pacer is None else self._pacer.overruns
        faults = {
            "commands lost": command.timeouts,
            "commands not finite": command.not_finite,
            "commands clamped": command.clamped,
            "overruns": overruns,
        }
        level, message = _judge(faults, command)
        self._diagnostics.publish(
            diagnostic(
                self.node,
                messages.stamp(time),
                level,
                message,
                {
                    "commands received": command.received,
                    **faults,
                    "free-air supply flow (L/min)": f"{supply_flow * 6e4:.2f}",
                },
            )
        )


def _judge(faults: dict[str, int], command: CommandInput) -> tuple[bytes, str]:
    """Level and message: an error now, a warning for what has happened, or all well."""
    if command.received and not command.present:
        return ERROR, "no valid command: valve closed"
    seen = [name for name, count in faults.items() if count]
    if seen:
        return WARN, "has happened: " + ", ".join(seen)
    return OK, "running" if command.received else "waiting for commands, valve closed"


def main(stop: Stop) -> int:
    """Run the plant until ``stop``."""
    return run_node(PlantNode, stop)
