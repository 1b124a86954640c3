"""The test's own ROS node: it listens, commands and asks, in a context of its own."""

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import UnsupportedOperation
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.ros.message_info import Info, with_info
from rodless_base.ros.topics import JOINT_STATES, QUEUE_DEPTH, VALVE_VOLTAGE, stamp_nanoseconds
from rodless_lab.session.samples import TERMS, Recording, Stamped, Unstamped

# Messages that may wait while a test computes: 100 s at 1 kHz.
LISTENING_DEPTH = 100_000

# One wait for messages, in wall-clock s; processes and timeout are looked at as often.
SPIN_SECONDS = 0.05

_environment_lock = threading.Lock()


class Observer:
    """A node named ``test`` in one domain, and what it has heard.

    It runs only inside :meth:`spin`, so whatever it is asked between two calls stands still.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        """Join the domain of ``environment``; nothing is listened to yet."""
        self._context = Context()
        with _patched(environment):
            self._context.init(
                args=[], initialize_logging=False, domain_id=int(environment["ROS_DOMAIN_ID"])
            )
            self.node = Node(
                "test",
                context=self._context,
                use_global_arguments=False,
                enable_rosout=False,
                start_parameter_services=False,
            )
        self._executor = _make_executor(self._context)
        self._executor.add_node(self.node)
        self.recording = Recording()
        self.diagnostics: dict[str, dict[str, str]] = {}
        self._clients: dict[tuple[type, str], Any] = {}
        self._parameter_clients: dict[str, AsyncParameterClient] = {}
        self._setpoint = self.node.create_publisher(Float64, "setpoint", 10)

    def close(self) -> None:
        """Leave the domain."""
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        # The executor holds on to the context, and the context to its place in the domain.
        self._executor.shutdown()
        self._context.try_shutdown()

    def spin(self) -> None:
        """Take what has come, or wait a moment for something to come."""
        self._executor.spin_once(SPIN_SECONDS)

    def listen_to_answers(self, topic: str) -> Callable[[], bool]:
        """Record what the controller publishes on ``topic``; return whether it is heard."""
        answers = self._listen_to(topic, self.recording.answers)
        if topic == VALVE_VOLTAGE:
            self.recording.voltage = self.recording.answers
        else:
            self._listen_to(VALVE_VOLTAGE, self.recording.voltage)
        return lambda: bool(answers.get_publisher_count())

    def listen_to_the_rest(self, telemetry: bool) -> Callable[[], bool]:
        """Record plant and telemetry; return whether all of it is heard.

        The order matters: nodes learn of subscriptions in the order they are made in, and the
        plant starts with the last of its own.
        """
        terms = TERMS if telemetry else ()
        heard = [self._listen_to(f"controller/{t}", self.recording.terms[t]) for t in terms]
        self._subscribe(DiagnosticArray, "/diagnostics", self._take_diagnostics)
        for topic, frame in zip(
            self.recording.pressures, ("chamber_a", "chamber_b", "supply"), strict=True
        ):
            heard.append(self._subscribe(FluidPressure, f"{frame}/pressure", _taker(topic.put)))
        # The plant also waits for a listener to /clock.
        self._subscribe(Clock, "/clock", _ignore, raw=True)
        heard.append(self._subscribe(JointState, JOINT_STATES, _taker(self.recording.joint.put)))
        return lambda: all(subscription.get_publisher_count() for subscription in heard)

    def stand_in_for_a_controller(self) -> None:
        """Be the further subscriber of ``joint_states`` that the plant waits for."""
        self._subscribe(JointState, JOINT_STATES, _ignore, raw=True)

    def commander(self) -> Publisher:
        """Return a publisher of valve voltages."""
        return self.node.create_publisher(Float64, VALVE_VOLTAGE, QUEUE_DEPTH)

    def _listen_to(self, topic: str, messages: list[Unstamped]) -> Subscription:
        def take(message: Float64, info: Info) -> None:
            messages.append(Unstamped(info["source_timestamp"], message.data))

        return self._subscribe(Float64, topic, with_info(take))

    def _subscribe(
        self, kind: type, topic: str, take: Callable[..., None], raw: bool = False
    ) -> Subscription:
        return self.node.create_subscription(kind, topic, take, LISTENING_DEPTH, raw=raw)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            name = status.name.lstrip("/")
            self.diagnostics[name] = {"message": status.message, **values}

    @property
    def setpoint_listeners(self) -> int:
        """Number of nodes that take set-points."""
        return int(self._setpoint.get_subscription_count())

    def send_setpoint(self, position: float) -> None:
        """Publish a set-point (m)."""
        self._setpoint.publish(Float64(data=float(position)))

    def client(self, kind: type, service: str) -> Any:
        """Return the client of a service."""
        if (kind, service) not in self._clients:
            self._clients[kind, service] = self.node.create_client(kind, service)
        return self._clients[kind, service]

    def parameter_client(self, node: str) -> AsyncParameterClient:
        """Return a client of the parameter services of ``node``."""
        if node not in self._parameter_clients:
            self._parameter_clients[node] = AsyncParameterClient(self.node, node)
        return self._parameter_clients[node]


def ros_parameters(values: Mapping[str, object]) -> list[Parameter]:
    """Return values by name in ROS's form."""
    return [
        Parameter(name, value=list(value) if isinstance(value, tuple) else value)
        for name, value in values.items()
    ]


def python_values(values: list[Any]) -> list[object]:
    """Return parameter values from ROS's form."""
    return [parameter_value_to_python(value) for value in values]


@contextmanager
def _patched(environment: Mapping[str, str]) -> Iterator[None]:
    """Show ``environment`` to the ROS libraries, which read no other one, for a moment."""
    with _environment_lock:
        before = {name: os.environ.get(name) for name in environment}
        os.environ.update(environment)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


def _make_executor(context: Context) -> Executor:
    """Return the executor that keeps up with 1 kHz on a small machine, where there is one."""
    try:
        from rclpy.experimental import EventsExecutor  # noqa: PLC0415  absent before jazzy

        return EventsExecutor(context=context)
    except (ImportError, UnsupportedOperation):
        # It wants the file descriptor of stderr, which pytest with --capture=sys has hidden.
        return SingleThreadedExecutor(context=context)


def _ignore(_message: bytes) -> None:
    """Take a message for nothing."""


def _taker(put: Callable[[Stamped], None]) -> Callable[..., None]:
    def take(message: Any, info: Info) -> None:
        stamp = stamp_nanoseconds(message.header.stamp)
        put(Stamped(info["source_timestamp"], stamp, _content(message)))

    return with_info(take)


def _content(message: Any) -> tuple[float, ...]:
    if isinstance(message, FluidPressure):
        return (message.fluid_pressure,)
    return (message.position[0], message.velocity[0], message.effort[0])
