# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A ROS node that listens, commands and asks, in a context of its own."""

import math
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterValue
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from rclpy.task import Future

from rodless_base.closing import Closing
from rodless_base.one_line import has_half_character, shown
from rodless_base.parameters import LARGEST_INTEGER, SMALLEST_INTEGER
from rodless_base.real_number import is_number
from rodless_base.ros.message_info import take_waiting, with_info
from rodless_base.ros.parameters import is_not_yet
from rodless_base.ros.process import make_executor
from rodless_base.ros.topics import QUEUE_DEPTH, stamp_nanoseconds
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.domain import domain_to_join, full_namespace
from rodless_lab.session.errors import (
    HarnessError,
    NotYetError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.network import make_room_for_nodes
from rodless_lab.session.opening_process import OpeningProcess
from rodless_lab.session.parameter_value import is_no_value, without_numpy

Found = TypeVar("Found")

# Default bound of every wait, in wall-clock s.
TIMEOUT = 60.0

# Messages that may wait while the program computes: 100 s at 1 kHz.
LISTENING_DEPTH = 100_000

# Longest wait for messages in one spin, in wall-clock s; conditions and timeouts are checked as
# often.
SPIN_SECONDS = 0.05

# After this time (wall-clock s), or half the timeout, an answer counts as lost, and the call is
# made again: a server that has not found the client yet cannot answer it.
ANSWER_SECONDS = 10.0

# How often a node is asked again that takes a change only later, wall-clock s.
ASK_AGAIN_SECONDS = 0.5

# What pybind11 makes of a Ctrl-C that comes while it calls a callback.
INTERRUPTED_CALL = "Unable to convert call argument"

BUSY = (
    "messages are waited for already: one thread at a time can use a session, and none of its "
    "callbacks, laws and checks can wait; give another thread a session of its own, or take turns"
)
SHUT_DOWN = "the observer was closed, or its context shut down: no message can come any more"

_environment_lock = threading.Lock()


class Observer(Closing):
    """A node in one domain; callbacks run inside :meth:`spin` and the methods that wait.

    Relative names of topics, services and nodes stand below ``namespace``. Every wait is bounded
    and raises :class:`WaitTimeoutError`.
    """

    def __init__(
        self,
        environment: Mapping[str, str] | None = None,
        namespace: str = "",
        timeout: float = TIMEOUT,
        check: Callable[[], object] = lambda: None,
    ) -> None:
        """Join the domain of ``environment``, by default that of this process.

        ``timeout`` bounds each wait (wall-clock s) that is not given another one. ``check`` is
        called before each spin of a wait; what it raises ends the wait. Raises HarnessError for a
        domain or a namespace that ROS does not have, and where shared memory is full.
        """
        full = full_namespace(namespace)
        self._timeout = timeout
        self._check = check
        self.context = Context()
        with _patched(environment or {}):
            make_room_for_nodes()
            self.context.init(args=[], initialize_logging=False, domain_id=domain_to_join())
            self.node = Node(
                "observer",
                context=self.context,
                namespace=full,
                use_global_arguments=False,
                enable_rosout=False,
                start_parameter_services=False,
            )
        self._executor = make_executor(self.context)
        self._executor.add_node(self.node)
        self._opening = OpeningProcess()
        self._spinning = threading.Lock()
        self._checking = False
        self._clients: dict[tuple[type, str], Any] = {}
        self._parameter_clients: dict[str, AsyncParameterClient] = {}
        self._diagnostics: dict[str, Diagnostic] | None = None

    @property
    def is_checking(self) -> bool:
        """Whether this is called from within a wait, which there is one of at a time."""
        return self._checking

    def close(self) -> None:
        """Leave the domain."""
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        # The executor holds on to the context, and the context to its place in the domain.
        self._executor.shutdown()
        self.context.try_shutdown()

    def add_node(self, node: Node) -> None:
        """Spin another node of the same :attr:`context` as well."""
        self._executor.add_node(node)

    def remove_node(self, node: Node) -> None:
        """Spin that node no longer."""
        self._executor.remove_node(node)

    # Waiting

    def spin(self, timeout: float = SPIN_SECONDS) -> None:
        """Run the callbacks of what has come, or wait up to ``timeout`` s for something to come.

        Raises HarnessError while that runs already, in another thread or from a callback, and in a
        process forked from this.
        """
        self._opening.check()
        if not self._spinning.acquire(blocking=False):
            raise HarnessError(BUSY)
        try:
            self._executor.spin_once(timeout)
        except ExternalShutdownException as error:
            raise HarnessError(SHUT_DOWN) from error
        except RuntimeError as error:
            if not str(error).startswith(INTERRUPTED_CALL):
                raise
            raise KeyboardInterrupt from error
        finally:
            self._spinning.release()

    def wait(
        self, condition: Callable[[], Found], what: str, timeout: float | None = None
    ) -> Found:
        """Spin until ``condition()`` is true, and return what it returned.

        ``what`` completes the error "timed out … waiting for …". Raises ValueError for a timeout
        that is no number of s; an infinite one waits for ever.
        """
        limit = self._limit(timeout)
        deadline = time.monotonic() + limit
        while True:
            # Before the condition is asked: what a slow check has held up counts as in time.
            is_late = time.monotonic() > deadline
            if found := condition():
                return found
            self._run_check()
            if is_late:
                raise WaitTimeoutError(f"timed out after {limit:g} s waiting for {what}")
            self.spin()

    def _limit(self, timeout: float | None) -> float:
        """Return how long to wait, in s; raises ValueError for what is no time."""
        if timeout is None:
            return self._timeout
        if not is_number(timeout) or math.isnan(timeout):
            raise ValueError(f"timeout: {shown(timeout)} refused, must be a number of s")
        return timeout

    def _run_check(self) -> None:
        """Call the check, which cannot wait itself: it would be called again."""
        if self._checking:
            raise HarnessError(BUSY)
        self._checking = True
        try:
            self._check()
        finally:
            self._checking = False

    def _check_open(self) -> None:
        if not self.context.ok():
            raise HarnessError(SHUT_DOWN)

    def result(self, ask: Callable[[], Future], what: str, timeout: float | None = None) -> Any:
        """Return the result of the future that ``ask`` returns; ask again if the answer is lost."""
        lost = self._answer_seconds(timeout)
        futures = [ask()]
        asked = time.monotonic()

        def answered() -> Future | None:
            nonlocal asked
            if time.monotonic() > asked + lost:
                futures.append(ask())
                asked = time.monotonic()
            return next((future for future in futures if future.done()), None)

        future = self.wait(answered, what, timeout)
        assert future is not None
        return future.result()

    # Topics

    def subscribe(
        self,
        kind: type,
        topic: str,
        callback: Callable[..., None],
        *,
        raw: bool = False,
        info: bool = False,
        depth: int = LISTENING_DEPTH,
    ) -> Subscription:
        """Call ``callback(message)`` for each message on ``topic``.

        ``raw``: the message as bytes; ``info``: ``callback(message, info)``, see
        :mod:`rodless_base.ros.message_info`.
        """
        self._check_open()
        receive = with_info(callback) if info else callback
        return self.node.create_subscription(kind, topic, receive, depth, raw=raw)

    def collect(self, kind: type, topic: str) -> list[Any]:
        """Return a list that grows by every message on ``topic``; wait until one can come."""
        messages: list[Any] = []
        subscription = self.subscribe(kind, topic, messages.append)
        self.wait(subscription.get_publisher_count, f"a publisher of {topic}")
        return messages

    def more(self, messages: list[Any], count: int, timeout: float | None = None) -> list[Any]:
        """Wait for ``count`` further messages in a list of :meth:`collect` and return them."""
        start = len(messages)
        self.wait(lambda: len(messages) >= start + count, f"{count} more messages", timeout)
        return messages[start : start + count]

    def publisher(self, kind: type, topic: str, subscribers: int = 1) -> Publisher:
        """Return a publisher on ``topic`` once it has that many subscribers."""
        self._check_open()
        publisher = self.node.create_publisher(kind, topic, QUEUE_DEPTH)
        self.wait(
            lambda: publisher.get_subscription_count() >= subscribers, f"a subscriber of {topic}"
        )
        return publisher

    # Services and parameters

    def call(self, kind: Any, service: str, /, **fields: object) -> Any:
        """Call a service and return its response; repeated if the answer is lost.

        Only for what may be done twice; for the rest there is :meth:`call_once`.
        """
        client, request = self._client(kind, service), kind.Request(**fields)
        return self.result(lambda: client.call_async(request), f"an answer of {service}")

    def call_once(self, kind: Any, service: str, has_worked: Callable[[], object] = bool) -> Any:
        """Call a service that would do its work twice if it were asked again; return its response.

        None where no answer comes within ``ANSWER_SECONDS`` and ``has_worked()`` says that it has
        been done. Raises WaitTimeoutError where that is open.
        """
        answer = self._client(kind, service).call_async(kind.Request())
        lost = time.monotonic() + self._answer_seconds(None)
        self.wait(
            lambda: answer.done() or (time.monotonic() > lost and has_worked()),
            f"an answer of {service}, which may have done what it was asked to",
        )
        return answer.result() if answer.done() else None

    def _client(self, kind: Any, service: str) -> Any:
        """Return the client of a service once that is there."""
        self._check_open()
        if (kind, service) not in self._clients:
            self._clients[kind, service] = self.node.create_client(kind, service)
        client = self._clients[kind, service]
        self.wait(client.service_is_ready, f"the service {service}")
        return client

    def _answer_seconds(self, timeout: float | None) -> float:
        """After how many s without an answer it is taken to be lost."""
        return min(ANSWER_SECONDS, self._limit(timeout) / 2.0)

    def parameter_client(self, node: str, timeout: float | None = None) -> AsyncParameterClient:
        """Return a client of the parameter services of ``node`` once they are there."""
        self._check_open()
        if node not in self._parameter_clients:
            self._parameter_clients[node] = AsyncParameterClient(self.node, node)
        client = self._parameter_clients[node]
        try:
            self.wait(client.services_are_ready, f"the parameter services of {node}", timeout)
        except WaitTimeoutError as error:
            own = self.node.get_fully_qualified_name()
            here = sorted({*self.node.get_fully_qualified_node_names()} - {own})
            raise WaitTimeoutError(f"{error}; nodes here: {', '.join(here) or 'none'}") from error
        return client

    def parameter_names(self, node: str) -> list[str]:
        """Return the names of a node's parameters."""
        client = self.parameter_client(node)
        answer = self.result(client.list_parameters, f"the parameters of {node}")
        return list(answer.result.names)

    def get_parameters(self, node: str, names: Sequence[str]) -> dict[str, object]:
        """Return the values of a node's parameters by name.

        Raises :class:`RefusedError` with the names of those that the node does not have.
        """
        client = self.parameter_client(node)
        values = self.result(
            lambda: client.get_parameters(list(names)), f"the parameters of {node}"
        ).values
        if len(values) < len(names):
            # Of all names together, a node that lacks one answers none.
            has = self.parameter_names(node)
            unknown = [name for name in names if name not in has] or names
            raise RefusedError(f"{', '.join(unknown)}: no such parameter on {node}")
        return {name: python_value(value) for name, value in zip(names, values, strict=True)}

    def set_parameters(
        self, node: str, values: Mapping[str, object], timeout: float | None = None
    ) -> None:
        """Set parameters of a node as one change.

        Raises :class:`RefusedError` with the node's reason, and then nothing has changed, its
        :class:`NotYetError` where asking again will do, and :class:`WaitTimeoutError` where no
        answer comes: whether it has changed is unknown then.
        """
        client = self.parameter_client(node, timeout)
        parameters = [ros_parameter(name, value) for name, value in values.items()]
        if not parameters:
            return
        result = self.result(
            lambda: client.set_parameters_atomically(parameters),
            f"{node} to take parameters",
            timeout,
        ).result
        if not result.successful:
            refusal = NotYetError if is_not_yet(result.reason) else RefusedError
            raise refusal(result.reason)

    def once_ready(
        self,
        change: Callable[[], Found],
        timeout: float,
        tell: Callable[[], object] = lambda: None,
    ) -> Found:
        """Return what ``change()`` returns, asking again as long as a node takes it only later.

        ``tell`` is called once if that takes a while. Raises :class:`WaitTimeoutError` where it
        takes longer than ``timeout`` s.
        """
        begun = time.monotonic()
        told = False
        while True:
            try:
                return change()
            except NotYetError as error:
                if time.monotonic() > begun + timeout:
                    raise WaitTimeoutError(f"timed out after {timeout:g} s: {error}") from error
            if not told:
                tell()
                told = True
            self._pause(ASK_AGAIN_SECONDS)

    def _pause(self, seconds: float) -> None:
        """Run callbacks for a while."""
        until = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() >= until, "that to pass", math.inf)

    # Diagnostics

    @property
    def diagnostics(self) -> dict[str, Diagnostic]:
        """What has come on ``/diagnostics`` since this was first asked for, by full node name."""
        if self._diagnostics is None:
            self._reports = self.subscribe(DiagnosticArray, "/diagnostics", self._take_diagnostics)
            self._diagnostics = {}
        return self._diagnostics

    def diagnostic(self, node: str, fresh: bool = False) -> Diagnostic:
        """Return the last diagnostic of ``node``; wait for the first, or with ``fresh`` the next.

        Nodes publish one a second.
        """
        self._check_open()
        name = self.node.resolve_topic_name(node)
        if fresh:
            self.forget_diagnostic(name)
        self.wait(lambda: name in self.diagnostics, f"a diagnostic of {name}")
        return self.diagnostics[name]

    def forget_diagnostic(self, node: str) -> None:
        """Forget what ``node`` has said, and what of it has come but waits to be looked at."""
        self.take_waiting_diagnostics()
        self.diagnostics.pop(self.node.resolve_topic_name(node), None)

    def take_waiting_diagnostics(self) -> None:
        """Take what has come on ``/diagnostics`` without running any other callback."""
        _ = self.diagnostics  # subscribes
        take_waiting(self._reports)

    def counter(self, node: str, name: str, fresh: bool = False) -> float:
        """Return a number from :meth:`diagnostic`; raises HarnessError for what is none."""
        return self.diagnostic(node, fresh).number(name, node)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        stamp = stamp_nanoseconds(message.header.stamp)
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            self.diagnostics[status.name] = Diagnostic(
                status.level, status.message, values, time.monotonic(), stamp
            )


def ros_parameter(name: object, value: object) -> Parameter:
    """Return a parameter as rclpy has it; raises TypeError for what no parameter can be."""
    if not isinstance(name, str):
        raise TypeError(f"{shown(name)} refused, must be the name of a parameter")
    value = without_numpy(value)
    for one in value if isinstance(value, list) else [value]:
        _check_fits(name, one)
    try:
        return Parameter(name, value=value)
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(is_no_value(name, value)) from error


def _check_fits(name: str, value: object) -> None:
    """Raise TypeError for a number or a text that no message can hold."""
    if isinstance(value, int) and not SMALLEST_INTEGER <= value <= LARGEST_INTEGER:
        raise TypeError(f"{name}: {shown(value)} refused, ROS has whole numbers of 64 bits")
    if isinstance(value, str) and has_half_character(value):
        raise TypeError(f"{name}: {shown(value)} refused, it has half a character")


def python_value(value: ParameterValue) -> object:
    """Return what a message holds; None where nothing is set, or its type is none of ROS's."""
    try:
        return parameter_value_to_python(value)
    except RuntimeError:
        return None


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
