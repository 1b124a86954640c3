# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Nothing that a callback raises, or a message that cannot be read, ends a node."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rcl_interfaces.msg import Parameter, ParameterValue, SetParametersResult
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from rodless_base.ros import guarded_node
from rodless_base.ros.diagnostics import Diagnostics, steady_clock
from rodless_base.ros.guarded_node import CALLBACK_ERRORS, GuardedNode
from rodless_base.ros.in_process import DirectDelivery, DirectNode, _deliveries
from rodless_base.ros.message_info import delivered_now
from rodless_base.ros.process import make_executor, spin
from rodless_base.start import Stop
from rodless_sim import RigParameters

TIMEOUT = 60.0


class Requested:
    """A Stop that handles no signals."""

    requested = False


@dataclass
class Running:
    """A node, and the executor it is in."""

    node: DirectNode
    executor: Executor
    stop: Stop

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Spin until it holds."""
        end = time.monotonic() + TIMEOUT

        def look() -> None:
            self.stop.requested = bool(condition()) or time.monotonic() > end

        self.stop.requested = False
        timer = self.node.create_timer(0.005, look, clock=steady_clock())
        spin(self.executor, self.stop, [self.node])
        self.node.destroy_timer(timer)
        assert condition(), what

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """Give a request to a service as the executor does; return the answer."""
        (service,) = (one for one in self.node.services if one.srv_name == name)
        return service.callback(request, kind.Response())


@pytest.fixture(params=[make_executor, SingleThreadedExecutor])
def running(request: pytest.FixtureRequest, domain: dict[str, str]) -> Iterator[Running]:
    """Return a node in each kind of executor."""
    context = Context()
    context.init(domain_id=int(domain["ROS_DOMAIN_ID"]))
    node = DirectNode("guarded", context=context, use_global_arguments=False)
    executor = request.param(context=context)
    executor.add_node(node)
    try:
        yield Running(node, executor, cast(Stop, Requested()))
    finally:
        executor.remove_node(node)
        node.destroy_node()
        context.try_shutdown()


def fail(*_arguments: object) -> None:
    """Break off in code of the project's own."""
    RigParameters().number("no such parameter")


UNKNOWN_TYPES = pytest.mark.parametrize("kind", [10, 99, 255])


@UNKNOWN_TYPES
def test_a_parameter_of_an_unknown_type_is_refused(running: Running, kind: int) -> None:
    """Whoever asked is told; each of the others in the request is done, as with a bad value.

    The node's state is not in doubt, and the next request is served.
    """
    node, unsafe = running.node, []
    node.make_safe = unsafe.append
    node.declare_parameter("gain", 1.0)
    fine = Parameter(name="gain", value=ParameterValue(type=3, double_value=2.0))
    unknown = Parameter(name="gain", value=ParameterValue(type=kind))
    several = SetParameters.Request(parameters=[fine, unknown, fine])
    results = running.call(SetParameters, "guarded/set_parameters", several).results
    assert [result.successful for result in results] == [True, False, True]
    assert results[1].reason == f"gain: type {kind} refused, ParameterType has 0 to 9"
    whole = SetParametersAtomically.Request(parameters=[unknown])
    result = running.call(
        SetParametersAtomically, "guarded/set_parameters_atomically", whole
    ).result
    assert result == results[1]
    read = GetParameters.Request(names=["gain"])
    (value,) = running.call(GetParameters, "guarded/get_parameters", read).values
    assert value.double_value == 2.0
    assert node.callback_errors == 2
    assert unsafe == []


def test_a_change_that_fails_keeps_what_comes_after_it_back(running: Running) -> None:
    """One error, one time made safe: a node in doubt takes no more of the request."""
    node, unsafe = running.node, []
    node.make_safe = unsafe.append
    node.declare_parameter("gain", 1.0)

    def judge(parameters: list[Any]) -> SetParametersResult:
        if parameters[0].value == 3.0:
            fail()
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(judge)
    request = SetParameters.Request(
        parameters=[
            Parameter(name="gain", value=ParameterValue(type=kind, double_value=value))
            for kind, value in ((3, 2.0), (99, 0.0), (3, 3.0), (3, 4.0))
        ]
    )
    results = running.call(SetParameters, "guarded/set_parameters", request).results
    assert [result.successful for result in results] == [True, False, False, False]
    assert "no such parameter" in results[2].reason
    assert results[3] == results[2]
    assert node.get_parameter("gain").value == 2.0
    assert node.callback_errors == 2
    assert len(unsafe) == 1


def test_a_callback_that_fails_loses_no_other_message(running: Running) -> None:
    """Of messages that came together each is handed over, the one after the failure at once."""
    node, heard, unsafe = running.node, [], []
    node.make_safe = unsafe.append

    def take(message: Float64) -> None:
        heard.append(message.data)
        if message.data in (0.0, 3.0):
            fail()

    publisher = node.create_publisher(Float64, "numbers", 10)
    node.create_subscription(Float64, "numbers", take, 10)
    running.until(publisher.get_subscription_count, "the subscription")
    for number in range(6):
        publisher.publish(Float64(data=float(number)))
    running.until(lambda: len(heard) == 6, "all messages")
    assert heard == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert node.callback_errors == 2
    assert len(unsafe) == 2
    assert unsafe[0].startswith("error in a callback: KeyError: ")
    assert "no such parameter" in unsafe[0]


def test_delivery_inside_the_process_is_guarded_too(running: Running) -> None:
    """A subscription that gets its messages directly."""
    node, heard = running.node, []
    delivery = DirectDelivery()
    _deliveries[node.context] = delivery

    def take(message: Float64) -> None:
        heard.append(message.data)
        fail()

    publisher = node.create_publisher(Float64, "direct", 10)
    node.create_subscription(Float64, "direct", take, 10)
    delivery.attach(running.executor, running.stop)
    for number in range(3):
        publisher.readers[0].put(Float64(data=float(number)), delivered_now(number))
    running.until(lambda: len(heard) == 3, "all messages")
    assert node.callback_errors == 3


def test_a_timer_and_a_service_that_fail_go_on(
    running: Running, capfd: pytest.CaptureFixture[str]
) -> None:
    """The service answers with the failure each time; the log is not flooded."""
    node = running.node
    node.create_timer(0.01, fail, clock=steady_clock())
    node.create_service(Trigger, "try", fail)
    running.until(lambda: node.callback_errors >= 5, "five failures of the timer")
    for _ in range(2):
        answer = running.call(Trigger, "try", Trigger.Request())
        assert not answer.success
        assert "no such parameter" in answer.message
    assert capfd.readouterr().err.count("error in a callback") == 1


def test_a_service_of_the_simulation_that_fails_says_so() -> None:
    """Its result was good before it began, as simulation_interfaces have it."""
    result = SimpleNamespace(result=1, error_message="", RESULT_OPERATION_FAILED=4)
    response = guarded_node._failed_answer("no more", None, SimpleNamespace(result=result))
    assert (response.result.result, response.result.error_message) == (4, "no more")


def test_a_message_that_cannot_be_read_is_left_out(running: Running) -> None:
    """One that ends too early, or is no text: the node goes on, and reads the next."""
    node, heard = running.node, []
    texts = node.create_publisher(String, "texts", 10)
    node.create_subscription(String, "texts", lambda message: heard.append(message.data), 10)
    running.until(texts.get_subscription_count, "the subscription")
    header = b"\x00\x01\x00\x00"
    texts.publish(header + b"\xff\xff\xff\xff")
    texts.publish(header + b"\x04\x00\x00\x00\xff\xfe\xfd\x00")
    texts.publish(String(data="well"))
    running.until(lambda: "well" in heard, "the good message")


def test_keyboard_interrupt_asks_the_process_to_stop(running: Running) -> None:
    """Raised by whatever is called, it ends the spinning as a signal does, without an error."""

    def interrupt() -> None:
        raise KeyboardInterrupt

    timer = running.node.create_timer(0.01, interrupt, clock=steady_clock())
    spin(running.executor, running.stop, [running.node])
    assert running.stop.requested
    assert running.node.callback_errors == 0
    timer.cancel()


def test_errors_are_faults_of_the_diagnostics(running: Running) -> None:
    """Counted beside the node's own faults, until they are cleared."""
    diagnostics = Diagnostics(running.node, lambda: {"of its own": 2})
    running.node.take_error(ValueError("of the test's own"))
    assert diagnostics.count() == {"of its own": 2, CALLBACK_ERRORS: 1}
    assert diagnostics.lately() == {"of its own": 2, CALLBACK_ERRORS: 1}
    diagnostics.clear()
    assert diagnostics.count() == {"of its own": 0, CALLBACK_ERRORS: 0}


def test_without_a_node_to_tell_nothing_is_hidden() -> None:
    """An error that nobody would hear of comes out of the spinning."""

    class Failing:
        """An executor of which something comes out."""

        def spin_until_future_complete(self, *_arguments: object) -> None:
            """Fail."""
            raise ValueError("of the test's own")

    with pytest.raises(ValueError, match="of the test's own"):
        spin(cast(Executor, Failing()), cast(Stop, Requested()))
    assert issubclass(DirectNode, GuardedNode)
