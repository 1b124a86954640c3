"""The plant as a ROS node: samples out, valve voltage in, parameters changeable while running."""

from functools import partial

from rclpy.logging import get_logger
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.constants import CARRIAGE, SPOOL
from rodless_base.fault_counts import WINDOW, FaultCounts, lately_text
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.diagnostics import (
    ACTUAL_RATE,
    ERROR,
    MODE,
    OK,
    PERIOD,
    PRESET,
    TARGET_RATE,
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
from rodless_sim.node.clock_publishers import ClockPublishers
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.pace import Pace, PaceMeter, PaceNews
from rodless_sim.node.ready import all_listen, preset_text, ready_line
from rodless_sim.node.realtime import POLL_PERIOD, Realtime
from rodless_sim.node.simulation_interfaces import offer_standard_services
from rodless_sim.node.time_keeper import TimeKeeper
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.state import State
from rodless_sim.rig import Rig
from rodless_sim.timing import nanoseconds

# The share of late periods above which they are a fault: an ordinary machine is late now and then.
TOLERATED_OVERRUNS = 0.01

# What the fault of late periods is called.
OVERRUNS = "overruns"


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
        self._counts = FaultCounts()
        self._commands = self.node.create_subscription(
            Float64, VALVE_VOLTAGE, self._take_command, QUEUE_DEPTH
        )
        self._commanders: dict[bytes, str] = {}
        self._time = self._make_time_keeper(self._parameters.values)
        self._pace, self._pace_news = self._make_pace_meter(self._parameters.values)
        self._last_pace = self._pace.report()
        self._announced: tuple[object, ...] = ()
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
        self._clock = ClockPublishers(
            self.node,
            lambda topic: OnDemand(publisher(Clock, topic), messages.clock, self._outbox),
            bool(self._parameters.values["time.publish_clock"]),
        )
        # Whose recorders the run waits for. Whoever lists topics need not know the valve's state.
        self._awaited = [*self._pressures.values(), *self._clock.awaited]
        self._on_demand = [*self._awaited, self._valve_state, *self._clock.others]
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
        self.node.create_timer(PERIOD, self._report, clock=steady_clock())

    def _ready(self) -> bool:
        """Whether everybody listens whom the run must not start without."""
        recorders = int(self._parameters.values.number("time.recorders"))
        lockstep = self._parameters.values.text("time.mode") == "lockstep"
        # In real time without recorders, too: this polls whom the first sample goes to.
        listening = all_listen(self._joint_states.get_subscription_count, self._awaited, recorders)
        # Last: whoever has subscribed to these before the samples has them from sample 0 on.
        self._valve_state.poll()
        self._clock.poll()
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
        self._clock.poll()
        self._time.poll()
        if self._time.paused:
            # A paused simulation shows that it lives, and what time it is to whoever joins.
            self._clock.publish(self._engine.rig.nanoseconds)
        if self._engine.failure != self._failure:
            self._failure = self._engine.failure
            if self._failure is not None:
                self.node.get_logger().error(self._failure)
        self._pace.observe(self._engine.rig.nanoseconds, self._time.running)
        self._announce()

    def _announce(self) -> None:
        """Report at once what the controller must know of: pauses, and whether samples are due.

        A new subscriber of the samples is told too.
        """
        state = (self._time.paused, self._time.running, self._joint_states.get_subscription_count())
        if state != self._announced:
            self._announced = state
            self._publish_diagnostics()

    def _configure(self, values: RigParameters) -> None:
        self._engine.configure(values)
        self._pressure_variance = pressure_variance(values)

    def _take_command(self, message: Float64) -> None:
        self._time.receive(message.data)

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = self._time.reset()
        self._counts.clear(self._faults())
        return response

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._time.pause(request.data)
        self._announce()
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
        self._clock.publish(time)
        for field, frame in self._frames.items():
            value = getattr(measurement, field)
            self._pressures[field].publish(value, self._pressure_variance, frame, time)
        self._valve_state.publish(state.voltage, time, self._spool)
        area = self._engine.rig.plant.cylinder.piston_area
        message = messages.joint_state(measurement, state.velocity, area, self._joint)
        self._outbox.send(self._joint_states, message)

    def _faults(self) -> dict[str, int]:
        """Return how often each fault has happened since the start."""
        command = self._engine.command
        return {
            "commands lost": command.timeouts,
            "commands not finite": command.not_finite,
            "commands clamped": command.clamped,
            OVERRUNS: self._time.overruns,
            LOST: self._outbox.lost,
        }

    def _report(self) -> None:
        self._last_pace = self._take_pace()
        self._clock.check()
        self._publish_diagnostics()

    def _publish_diagnostics(self) -> None:
        values = self._parameters.values
        faults = self._counts.update(self._faults())
        pace = self._last_pace
        level, message = self._judge()
        flow = self._engine.rig.free_air_flow * 6e4
        self._diagnostics.publish(
            diagnostic(
                self.node,
                messages.stamp(self._engine.rig.nanoseconds),
                level,
                message,
                {
                    MODE: values.text("time.mode"),
                    PRESET: preset_text(values),
                    "paused": self._time.paused,
                    TARGET_RATE: f"{self._target_rate:g}",
                    ACTUAL_RATE: f"{pace.speed_factor / values.number('time.period'):.3f}",
                    "speed factor": f"{pace.speed_factor:.3f}",
                    "lag (s)": f"{pace.lag:.3f}",
                    "commands received": self._engine.command.received,
                    **faults,
                    "free-air supply flow (L/min)": f"{flow:.2f}",
                },
                cylinder_name(values),
            )
        )

    @property
    def _target_rate(self) -> float:
        """Samples due per wall-clock s; 0 where none is, as in lock-step."""
        values = self._parameters.values
        if values.text("time.mode") == "lockstep" or not self._time.running:
            return 0.0
        return values.number("time.speed") / values.number("time.period")

    def _take_pace(self) -> Pace:
        pace = self._pace.report()
        news = self._pace_news.hear(pace)
        if news is not None and self._pace_news.behind:
            self.node.get_logger().warning(news)
        elif news is not None:
            self.node.get_logger().info(news)
        return pace

    def _judge(self) -> tuple[bytes, str]:
        """Level and message: an error now, a warning for now or for faults of late, or all well."""
        # Nothing that a plant at its end lacks is a fault.
        ended = self._engine.ended and self._engine.failure is None
        if self._time.problem is not None and not ended:
            return ERROR, self._time.problem
        state = "ended" if ended else "paused" if self._time.paused else None
        warnings = [self._clock.problem] if self._clock.problem else []
        if self._pace_news.behind and state is None:
            warnings.append("plant time falls behind")
        lately = self._faults_lately()
        if lately:
            warnings.append(lately_text(lately))
        if state is not None or warnings:
            return (WARN if warnings else OK), "; ".join([*([state] if state else []), *warnings])
        if not self._engine.command.received:
            return OK, "waiting for commands, valve closed"
        return OK, "running"

    def _faults_lately(self) -> list[str]:
        lately = self._counts.lately()
        number = self._parameters.values.number
        periods = WINDOW * number("time.speed") / number("time.period")
        if lately.get(OVERRUNS, 0) <= TOLERATED_OVERRUNS * periods:
            lately.pop(OVERRUNS, None)
        return list(lately)


def cylinder_name(values: RigParameters) -> str:
    """Bore and stroke, as makers name cylinders."""
    bore, stroke = (values.number(f"cylinder.{name}") for name in ("bore", "stroke"))
    return f"cylinder {bore * 1e3:g}-{stroke * 1e3:g} mm"


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
