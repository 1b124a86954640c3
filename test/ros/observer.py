"""A node of the test's own: it listens, commands and asks, and never waits without a bound."""

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.publisher import Publisher
from rclpy.task import Future

# For whatever must come, so that a test fails instead of hanging, in wall-clock seconds.
TIMEOUT = 60.0

# How often a service is called within that time before it counts as silent.
ATTEMPTS = 6

# One wait for messages, in wall-clock seconds; the graph and processes are looked at as often.
SPIN_SECONDS = 0.05

# Messages a test on a busy machine may fall behind before it loses any.
QUEUE_DEPTH = 10_000


def make_executor(context: Context) -> Executor:
    """Return the executor that keeps up with 1 kHz on a small machine, where there is one."""
    try:
        from rclpy.experimental import EventsExecutor  # noqa: PLC0415  absent before jazzy
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def nanoseconds(stamp: Time) -> int:
    """Return a ROS time as an integer."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec


class Observer:
    """A node in a context of its own; callbacks run while the test waits for something."""

    def __init__(self, environment: Mapping[str, str], namespace: str = "") -> None:
        """Join the domain of ``environment``; relative names stand below ``namespace``."""
        self.context = Context()
        self.context.init(args=[], domain_id=int(environment["ROS_DOMAIN_ID"]))
        self.node = Node(
            "observer", context=self.context, namespace=namespace, use_global_arguments=False
        )
        self._executor = make_executor(self.context)
        self._executor.add_node(self.node)
        self._clients: dict[tuple[type, str], Any] = {}
        self._parameter_clients: dict[str, AsyncParameterClient] = {}
        self._diagnostics: list[DiagnosticArray] | None = None

    def close(self) -> None:
        """Leave the domain."""
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        # It holds on to the context, and the context to its place in the domain, which another
        # test may have next.
        self._executor.shutdown()
        self.context.try_shutdown()

    def until(self, condition: Callable[[], object], what: str, timeout: float = TIMEOUT) -> None:
        """Take messages until ``condition`` holds; fail naming ``what`` if it never does."""
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f"waited {timeout:g} s in vain for {what}"
            self._executor.spin_once(SPIN_SECONDS)

    def result(self, future: Future, what: str) -> Any:
        """Wait for ``future`` and return its result."""
        self.until(future.done, what)
        return future.result()

    def record(self, kind: type, topic: str) -> list[Any]:
        """Return a list that grows by every message on ``topic``; wait until one can come."""
        messages: list[Any] = []
        heard = self.node.create_subscription(kind, topic, messages.append, QUEUE_DEPTH)
        self.until(lambda: self.node.count_publishers(heard.topic_name), f"a publisher of {topic}")
        return messages

    def publisher(self, kind: type, topic: str) -> Publisher:
        """Return a publisher on ``topic`` that somebody hears."""
        publisher = self.node.create_publisher(kind, topic, QUEUE_DEPTH)
        self.until(publisher.get_subscription_count, f"a subscriber of {topic}")
        return publisher

    def more(self, messages: list[Any], count: int, timeout: float = TIMEOUT) -> list[Any]:
        """Wait for ``count`` further messages in a recorded list and return them."""
        start = len(messages)
        self.until(
            lambda: len(messages) >= start + count,
            f"{count} messages, of which {len(messages) - start} came",
            timeout,
        )
        return messages[start : start + count]

    def call(self, kind: type, service: str, **fields: object) -> Any:
        """Call a service and return its response.

        An answer is lost where the server has not found this client yet; the call is made again.
        """
        if (kind, service) not in self._clients:
            self._clients[kind, service] = self.node.create_client(kind, service)
        client = self._clients[kind, service]
        self.until(client.service_is_ready, f"service {service}")
        for _ in range(ATTEMPTS):
            future = client.call_async(kind.Request(**fields))
            deadline = time.monotonic() + TIMEOUT / ATTEMPTS
            while not future.done() and time.monotonic() < deadline:
                self._executor.spin_once(SPIN_SECONDS)
            if future.done():
                return future.result()
        raise AssertionError(f"waited {TIMEOUT:g} s in vain for an answer of {service}")

    def parameters(self, node: str) -> AsyncParameterClient:
        """Return a client of the parameter services of ``node``."""
        if node not in self._parameter_clients:
            self._parameter_clients[node] = AsyncParameterClient(self.node, node)
        client = self._parameter_clients[node]
        self.until(client.services_are_ready, f"the parameter services of {node}")
        return client

    def get(self, node: str, names: Iterable[str]) -> dict[str, object]:
        """Return values of parameters by name."""
        wanted = list(names)
        response = self.result(self.parameters(node).get_parameters(wanted), "parameters")
        values = [parameter_value_to_python(value) for value in response.values]
        return dict(zip(wanted, values, strict=True))

    def set(self, node: str, values: Mapping[str, object]) -> list[Any]:
        """Set parameters one by one; return the result of each."""
        future = self.parameters(node).set_parameters(_ros(values))
        return list(self.result(future, f"{node} to answer").results)

    def set_together(self, node: str, values: Mapping[str, object]) -> Any:
        """Set parameters as one change; return its result."""
        future = self.parameters(node).set_parameters_atomically(_ros(values))
        return self.result(future, f"{node} to answer").result

    def diagnostic(self, node: str, fresh: bool = False) -> DiagnosticStatus:
        """Return what the node of full name ``node`` last said of itself on /diagnostics.

        With ``fresh`` wait for it to say so again.
        """
        if self._diagnostics is None:
            self._diagnostics = self.record(DiagnosticArray, "/diagnostics")
        start = len(self._diagnostics) if fresh else 0
        self.until(lambda: self._said_by(node, start), f"a diagnostic of {node}")
        return self._said_by(node, start)[-1]

    def _said_by(self, node: str, start: int) -> list[DiagnosticStatus]:
        messages = (self._diagnostics or [])[start:]
        return [status for message in messages for status in message.status if status.name == node]

    def count(self, node: str, key: str, fresh: bool = False) -> float:
        """Return a number from the last (or a ``fresh``) diagnostic of ``node``."""
        return float({pair.key: pair.value for pair in self.diagnostic(node, fresh).values}[key])


def _ros(values: Mapping[str, object]) -> list[Parameter]:
    return [Parameter(name, value=value) for name, value in values.items()]
