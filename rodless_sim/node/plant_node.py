"""The plant as a ROS node: samples out, valve voltage in, parameters changeable while running."""

from functools import partial

from rclpy.logging import get_logger
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.constants import CARRIAGE, SPOOL
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.diagnostics import (
    ERROR,
    OK,
    PERIOD,
    WARN,
    diagnostic,
    diagnostics_publisher,
    steady_clock,
)
from rodless_base.ros.in_process import DirectNode
from rodless_base.ros.logs import log_through
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.process import run_node
from rodless_base.ros.publish import LOST, UNKNOWN, OnDemand, Outbox, nodes
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, PRESSURES, VALVE_STATE, VALVE_VOLTAGE
from rodless_sim.node import messages
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.pace import Pace, PaceMeter, PaceNews
from rodless_sim.node.ready import all_listen, ready_line
from rodless_sim.node.realtime import POLL_PERIOD, Realtime
from rodless_sim.node.simulation_interfaces import offer_standard_services
from rodless_sim.node.time_keeper import TimeKeeper
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.state import State
from rodless_sim.rig import Rig
from rodless_sim.timing import nanoseconds


class PlantNode:
    """A rig in plant time, which the wall clock or the commands drive."""

    def __init__(self, **node_options: object) -> None:
        """Settle and start; raises ParameterError for parameters that are no rig's."""
        self.node = DirectNode(
            "plant", automatically_declare_parameters_from_overrides=True, **node_options
        )
        self._parameters = RosParameters(self.node, RigParameters, self._configure)
        self._name_frames(self._parameters.values)
        self._make_publishers()
        self._pressure_variance = pressure_variance(self._parameters.values)
        self._engine = Engine(self._parameters.values, self._publish)
        self._failure: str | None = None
        self._commands = self.node.create_subscription(
            Float64, VALVE_VOLTAGE, self._take_command, QUEUE_DEPTH
        )
        self._commanders: dict[bytes, str] = {}
        self._time = self._make_time_keeper(self._parameters.values)
        self._pace, self._pace_news = self._make_pace_meter(self._parameters.values)
        self._make_services()
        self._say_ready()

    def close(self) -> None:
        """Stop the plant and destroy the node."""
        self._time.close()
        self.node.destroy_node()

    def _name_frames(self, values: RigParameters) -> None:
        self._joint, self._spool = prefixed(values, CARRIAGE), prefixed(values, SPOOL)
        frames = messages.PRESSURE_FRAMES.items()
        self._frames = {field: prefixed(values, frame) for field, frame in frames}

    def _make_publishers(self) -> None:
        # Real time waits for nobody; lock-step loses nothing.
        lockstep = self._parameters.values.text("time.mode") == "lockstep"
        publisher = partial(
            self.node.create_publisher, qos_profile=LOSSLESS if lockstep else QUEUE_DEPTH
        )
        # One for all: the messages of a sample keep their order, whatever holds one back.
        self._outbox = Outbox(self.node)
        self._joint_states = publisher(JointState, JOINT_STATES)
        self._pressures = {
            field: OnDemand(publisher(FluidPressure, topic), messages.pressure, self._outbox)
            for field, topic in PRESSURES.items()
        }
        self._valve_state = OnDemand(
            publisher(JointState, VALVE_STATE), messages.valve_state, self._outbox
        )
        self._clock = (
            OnDemand(publisher(Clock, "/clock"), messages.clock, self._outbox)
            if self._parameters.values["time.publish_clock"]
            else None
        )
        # Whose recorders the run waits for. Whoever lists topics need not know the valve's state.
        self._awaited = [*self._pressures.values(), *([self._clock] if self._clock else [])]
        self._on_demand = [*self._awaited, self._valve_state]
        self._diagnostics = diagnostics_publisher(self.node)

    def _make_time_keeper(self, values: RigParameters) -> TimeKeeper:
        if values.text("time.mode") == "lockstep":
            timeout = values.number("time.command_timeout")
            return Lockstep(self._engine, timeout, self._ready, self._find_commanders, self._outbox)
        wall_period = nanoseconds(values.number("time.period") / values.number("time.speed"))
        return Realtime(self._engine, wall_period, self._ready)

    @staticmethod
    def _make_pace_meter(values: RigParameters) -> tuple[PaceMeter, PaceNews]:
        lockstep = values.text("time.mode") == "lockstep"
        speed = 0.0 if lockstep else values.number("time.speed")
        period = values.number("time.period")
        return PaceMeter(speed, nanoseconds(period)), PaceNews(speed, period)

    def _say_ready(self) -> None:
        samples, commands = self._joint_states.topic_name, self._commands.topic_name
        self.node.get_logger().info(ready_line(self._parameters.values, samples, commands))

    def _make_services(self) -> None:
        self.node.create_service(Trigger, "~/reset", self._reset)
        self.node.create_service(SetBool, "~/pause", self._pause)
        self.node.create_service(Trigger, "~/step", self._step)
        offer_standard_services(self.node, self._time)
        self.node.create_timer(POLL_PERIOD, self._poll, clock=steady_clock())
        self.node.create_timer(PERIOD, self._publish_diagnostics, clock=steady_clock())

    def _ready(self) -> bool:
        """Whether everybody listens whom the run must not start without."""
        recorders = int(self._parameters.values.number("time.recorders"))
        lockstep = self._parameters.values.text("time.mode") == "lockstep"
        # In real time without recorders, too: this polls whom the first sample goes to.
        listening = all_listen(self._joint_states.get_subscription_count, self._awaited, recorders)
        # Last: whoever subscribes to it first has it from sample 0 on.
        self._valve_state.poll()
        return listening or not (recorders or lockstep)

    def _find_commanders(self) -> dict[bytes, str]:
        """Return the nodes that publish commands, by what identifies the publisher."""
        topic = self._commands.topic_name
        # Counting costs a tenth of asking who they are.
        changed = self.node.count_publishers(topic) != len(self._commanders)
        if changed or UNKNOWN in self._commanders.values():
            self._commanders = nodes(self.node.get_publishers_info_by_topic(topic))
        return self._commanders

    def _poll(self) -> None:
        for publisher in self._on_demand:
            publisher.poll()
        self._time.poll()
        if self._engine.failure != self._failure:
            self._failure = self._engine.failure
            if self._failure is not None:
                self.node.get_logger().error(self._failure)
        self._pace.observe(self._engine.rig.nanoseconds, self._time.running)

    def _configure(self, values: RigParameters) -> None:
        self._engine.configure(values)
        self._pressure_variance = pressure_variance(values)

    def _take_command(self, message: Float64) -> None:
        self._time.receive(message.data)

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = self._time.reset()
        return response

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._time.pause(request.data)
        response.success = True
        response.message = "paused" if request.data else "running"
        return response

    def _step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        obstacle = self._time.step()
        response.success = obstacle is None
        response.message = obstacle or ""
        return response

    def _publish(self, measurement: Measurement, state: State) -> None:
        time = measurement.stamp
        if self._clock is not None:
            self._clock.publish(time)
        for field, frame in self._frames.items():
            value = getattr(measurement, field)
            self._pressures[field].publish(value, self._pressure_variance, frame, time)
        self._valve_state.publish(state.voltage, time, self._spool)
        area = self._engine.rig.plant.cylinder.piston_area
        message = messages.joint_state(measurement, state.velocity, area, self._joint)
        self._outbox.send(self._joint_states, message)

    def _publish_diagnostics(self) -> None:
        command = self._engine.command
        faults = {
            "commands lost": command.timeouts,
            "commands not finite": command.not_finite,
            "commands clamped": command.clamped,
            "overruns": self._time.overruns,
            LOST: self._outbox.lost,
        }
        pace = self._take_pace()
        level, message = self._judge(faults)
        flow = self._engine.rig.free_air_flow * 6e4
        self._diagnostics.publish(
            diagnostic(
                self.node,
                messages.stamp(self._engine.rig.nanoseconds),
                level,
                message,
                {
                    "mode": self._parameters.values.text("time.mode"),
                    "paused": self._time.paused,
                    "speed factor": f"{pace.speed_factor:.3f}",
                    "lag (s)": f"{pace.lag:.3f}",
                    "commands received": command.received,
                    **faults,
                    "free-air supply flow (L/min)": f"{flow:.2f}",
                },
            )
        )

    def _take_pace(self) -> Pace:
        pace = self._pace.report()
        news = self._pace_news.hear(pace)
        if news is not None and self._pace_news.behind:
            self.node.get_logger().warning(news)
        elif news is not None:
            self.node.get_logger().info(news)
        return pace

    def _judge(self, faults: dict[str, int]) -> tuple[bytes, str]:
        """Level and message: an error now, a warning for now or for past faults, or all well."""
        seen = [name for name, count in faults.items() if count]
        since_start = ["since start: " + ", ".join(seen)] if seen else []
        # Nothing that a plant at its end lacks is a fault.
        ended = self._engine.ended and self._engine.failure is None
        if self._time.problem is not None and not ended:
            return ERROR, self._time.problem
        if ended or self._time.paused:
            state = "ended" if ended else "paused"
            return (WARN if seen else OK), "; ".join([state, *since_start])
        if self._pace_news.behind:
            return WARN, "; ".join(["plant time falls behind", *since_start])
        if seen:
            return WARN, since_start[0]
        if not self._engine.command.received:
            return OK, "waiting for commands, valve closed"
        return OK, "running"


def pressure_variance(values: RigParameters) -> float:
    """Variance in Pa² of what differs from reading to reading; 0 for ideal instruments."""
    return values.number("sensors.pressure_noise") ** 2


def load() -> None:
    """Load the compiled plant, so that the first sample does not wait for it."""
    log_through("plant")
    get_logger("plant").info("loading the compiled plant")
    Rig().advance(0.0, 1e-3)


def main(stop: Stop) -> int:
    """Run the plant until ``stop``."""
    load()
    return run_node(PlantNode, stop)
