# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The observer against nodes of the test's own: what it waits for, asks, and is refused."""

import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from rodless_lab.session import observer as module
from rodless_lab.session.errors import (
    HarnessError,
    NotYetError,
    RefusedError,
    WaitTimeoutError,
)
from rodless_lab.session.observer import Observer


@pytest.fixture
def node(observer: Observer) -> Iterator[Node]:
    """Return a node below /there that the observer spins: it serves, and has two parameters."""
    node = Node("server", namespace="there", context=observer.context, use_global_arguments=False)
    node.declare_parameter("gain", 1.0)
    node.declare_parameter("list", [1.0, 2.0])
    observer.add_node(node)
    yield node
    observer.remove_node(node)
    node.destroy_node()


def test_a_wait_returns_what_it_found_or_says_what_it_waited_for(observer: Observer) -> None:
    """The value of the condition comes back; otherwise it takes the time given."""
    values = iter([0, 0, 7])
    assert observer.wait(lambda: next(values), "a number") == 7
    start = time.monotonic()
    with pytest.raises(WaitTimeoutError, match=r"timed out after 0\.2 s waiting for the moon"):
        observer.wait(lambda: False, "the moon", 0.2)
    assert 0.2 <= time.monotonic() - start < 10.0


@pytest.mark.parametrize("timeout", [float("nan"), "a minute", True])
def test_a_timeout_that_is_no_time_is_refused(observer: Observer, timeout: float) -> None:
    """Before anything is asked or waited for; one of NaN would never end."""
    asked: list[int] = []

    def ask() -> None:
        asked.append(1)

    with pytest.raises(ValueError, match=r"^timeout: .* refused, must be a number of s$"):
        observer.wait(ask, "nothing", timeout)
    with pytest.raises(ValueError, match=r"^timeout: .* refused, must be a number of s$"):
        observer.result(ask, "nothing", timeout)
    assert not asked


def test_what_waits_already_cannot_wait_again(observer: Observer, node: Node) -> None:
    """Neither from a callback nor in another thread: the line says so, and the first waits on."""
    said: list[str] = []

    def wait_too() -> None:
        with pytest.raises(HarnessError, match=r"^messages are waited for already: ") as refusal:
            observer.wait(lambda: False, "nothing")
        said.append(str(refusal.value))

    def wait_in_both() -> None:
        thread = threading.Thread(target=wait_too)
        thread.start()
        thread.join()
        wait_too()

    timer = node.create_timer(0.01, wait_in_both)
    observer.wait(lambda: len(said) >= 4, "two callbacks, each with a thread")
    node.destroy_timer(timer)
    assert "\n" not in said[0]


def test_an_interrupt_that_the_library_loses_is_one(
    observer: Observer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the moment in which a callback is called; other errors stay what they are."""
    lost = "Unable to convert call argument '0' to Python object (#define ...)"
    for text, kind in ((lost, KeyboardInterrupt), ("another", RuntimeError)):

        def fail(_timeout: float, text: str = text) -> None:
            raise RuntimeError(text)

        monkeypatch.setattr(observer, "_executor", SimpleNamespace(spin_once=fail))
        with pytest.raises(kind):
            observer.spin()
    monkeypatch.undo()
    observer.spin(0.0)


@pytest.mark.parametrize(
    ("value", "line"),
    [
        (2**70, "gain: 1180591620717411303424 refused, ROS has whole numbers of 64 bits"),
        (-(2**63) - 1, "gain: -9223372036854775809 refused"),
        ([1, 2**63], "gain: 9223372036854775808 refused"),
        ("\ud800", "gain: .* refused, it has half a character"),
        (["a", "\ud800"], "gain: .* refused, it has half a character"),
    ],
)
def test_what_no_message_holds_is_no_value(
    observer: Observer, node: Node, value: object, line: str
) -> None:
    """Refused by name and value before anything is sent."""
    with pytest.raises(TypeError, match=line):
        observer.set_parameters("there/server", {"gain": value})
    assert node.get_parameter("gain").value == 1.0


def test_a_check_ends_a_wait(domain: dict[str, str]) -> None:
    """What the function raises that is called in every wait comes out of it."""
    calls: list[None] = []

    def check() -> None:
        calls.append(None)
        if len(calls) == 3:
            raise LookupError("enough")

    with Observer(domain, check=check) as observer, pytest.raises(LookupError, match="enough"):
        observer.wait(lambda: False, "nothing")


def compute(seconds: float) -> None:
    """Take as long as a check that computes does."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        pass


def test_what_a_slow_check_holds_up_counts_as_in_time(domain: dict[str, str]) -> None:
    """What has come by the end of the check is looked at before the wait gives up."""
    done: list[None] = []

    def check() -> None:
        compute(0.2)
        done.append(None)

    with Observer(domain, check=check) as observer:
        assert observer.wait(lambda: len(done), "the check", 0.1) == 1
        with pytest.raises(WaitTimeoutError, match=r"after 0\.1 s waiting for the moon"):
            observer.wait(lambda: False, "the moon", 0.1)


def test_a_change_that_comes_later_is_asked_for_again_beside_a_slow_check(
    domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long the check takes, within the time for the change."""
    monkeypatch.setattr(module, "ASK_AGAIN_SECONDS", 0.05)
    asked: list[None] = []

    def change() -> int:
        asked.append(None)
        if len(asked) < 3:
            raise NotYetError("not yet")
        return len(asked)

    with Observer(domain, check=lambda: compute(0.2)) as observer:
        assert observer.once_ready(change, 60.0) == 3


def test_messages_come_with_their_times_and_raw_where_asked(observer: Observer) -> None:
    """The same message as an object, as bytes, and with the time it was sent at."""
    publisher = observer.publisher(Float64, "number", subscribers=0)
    seen: list[object] = []
    observer.subscribe(Float64, "number", seen.append, raw=True)
    observer.subscribe(Float64, "number", lambda m, info: seen.append((m, info)), info=True)
    plain = observer.collect(Float64, "number")
    observer.wait(lambda: publisher.get_subscription_count() == 3, "three subscribers")
    before = time.time_ns()
    publisher.publish(Float64(data=2.5))
    observer.wait(lambda: len(seen) == 2 and plain, "all three")
    (raw,) = [one for one in seen if isinstance(one, bytes)]
    ((message, info),) = [one for one in seen if isinstance(one, tuple)]
    assert len(raw) == 4 + 8
    assert message.data == plain[0].data == 2.5
    assert before <= info["source_timestamp"] <= time.time_ns()


def test_relative_names_stand_below_the_namespace(
    domain: dict[str, str], observer: Observer, node: Node
) -> None:
    """An observer in /there finds the node's service and parameters by their short names."""
    service = node.create_service(Trigger, "~/ring", ringing)
    with Observer(domain, "there", check=lambda: observer.spin(0.0)) as below:
        assert below.call(Trigger, "server/ring").message == "rung"
        assert below.get_parameters("server", ["gain"]) == {"gain": 1.0}
    node.destroy_service(service)


def ringing(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
    """Answer a call."""
    response.message = "rung"
    return response


@pytest.fixture
def requests(node: Node, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[None]]:
    """Return a list of what a service has answered, by numbers; answers are soon taken for lost."""
    monkeypatch.setattr(module, "ANSWER_SECONDS", 0.2)
    requests: list[None] = []

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        requests.append(None)
        response.message = f"answer {len(requests)}"
        return response

    service = node.create_service(Trigger, "~/ring", answer)
    yield requests
    node.destroy_service(service)


@pytest.mark.usefixtures("requests")
def test_a_call_whose_answer_is_lost_is_made_again(observer: Observer) -> None:
    """The first request meets silence; the second is answered, and its answer is the result."""
    client = observer.node.create_client(Trigger, "/there/server/ring")
    observer.wait(client.service_is_ready, "the service")
    lost = [observer.node.create_client(Trigger, "/nobody").call_async(Trigger.Request())]
    response = observer.result(
        lambda: lost.pop() if lost else client.call_async(Trigger.Request()), "an answer"
    )
    assert response.message == "answer 1"
    assert observer.call(Trigger, "/there/server/ring").message == "answer 2"


def test_what_would_be_done_twice_is_asked_for_once(
    observer: Observer, node: Node, requests: list[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A server that answers late has done it once; one that stays silent is judged by its work."""
    observer.remove_node(node)
    looks: list[None] = []

    def go_on() -> bool:
        looks.append(None)
        if len(looks) == 3:
            observer.add_node(node)
        return False

    assert observer.call_once(Trigger, "/there/server/ring", go_on).message == "answer 1"
    observer.spin()
    assert len(requests) == 1

    observer.remove_node(node)
    assert observer.call_once(Trigger, "/there/server/ring", lambda: True) is None
    monkeypatch.setattr(observer, "_timeout", 0.5)
    with pytest.raises(WaitTimeoutError, match="which may have done what it was asked to"):
        observer.call_once(Trigger, "/there/server/ring")
    observer.add_node(node)


def test_a_service_that_is_not_there_is_named(domain: dict[str, str]) -> None:
    """The error of a call says which service was waited for."""
    with Observer(domain, timeout=0.2) as hasty:
        with pytest.raises(WaitTimeoutError, match="the service /nobody/ring"):
            hasty.call(Trigger, "/nobody/ring")
        with pytest.raises(WaitTimeoutError, match="the parameter services of /nobody"):
            hasty.get_parameters("/nobody", ["gain"])


def test_parameters_change_together_or_not_at_all(observer: Observer, node: Node) -> None:
    """Values come back by name; a refusal raises the node's own words and changes nothing."""

    def check(parameters: list[object]) -> SetParametersResult:
        bad = any(p.name == "gain" and p.value < 0.0 for p in parameters)
        return SetParametersResult(successful=not bad, reason="gain: must not be negative")

    node.add_on_set_parameters_callback(check)
    observer.set_parameters("/there/server", {"gain": 3.0, "list": (4.0, 5.0)})
    found = observer.get_parameters("/there/server", ["list", "gain"])
    assert list(found) == ["list", "gain"]
    assert (list(found["list"]), found["gain"]) == ([4.0, 5.0], 3.0)
    with pytest.raises(RefusedError, match="gain: must not be negative"):
        observer.set_parameters("/there/server", {"list": (0.0,), "gain": -1.0})
    assert list(observer.get_parameters("/there/server", ["list"])["list"]) == [4.0, 5.0]


def test_a_parameter_that_the_node_does_not_have_is_named(observer: Observer, node: Node) -> None:
    """Not an error of lengths, and not a value for the others."""
    assert node.has_parameter("gain")
    with pytest.raises(RefusedError, match=r"^gian: no such parameter on /there/server$"):
        observer.get_parameters("/there/server", ["gain", "gian"])


def test_a_change_that_is_not_answered_ends_after_the_time_given(
    domain: dict[str, str], node: Node
) -> None:
    """Not after the observer's own: the node is there, but nobody spins it."""
    with Observer(domain, timeout=60.0) as asking:
        client = asking.parameter_client("/there/server", 30.0)
        assert client.services_are_ready()
        start = time.monotonic()
        with pytest.raises(WaitTimeoutError, match=r"after 0\.3 s waiting for /there/server"):
            asking.set_parameters("/there/server", {"gain": 5.0}, 0.3)
        assert time.monotonic() - start < 20.0
    assert node.get_parameter("gain").value != 5.0


def test_diagnostics_are_kept_by_full_name(observer: Observer, node: Node) -> None:
    """The last of each node, with its level and values."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def publish(name: str, level: bytes, count: int) -> None:
        values = [KeyValue(key="count", value=str(count))]
        status = DiagnosticStatus(name=name, level=level, message="so so", values=values)
        publisher.publish(DiagnosticArray(status=[status]))

    assert observer.diagnostics == {}
    observer.wait(publisher.get_subscription_count, "the observer to listen")
    publish("/there/server", DiagnosticStatus.WARN, 1)
    publish("/other", DiagnosticStatus.OK, 2)
    found = observer.diagnostic("/there/server")
    assert found[:3] == (DiagnosticStatus.WARN, "so so", {"count": "1"})
    assert observer.counter("/other", "count") == 2.0
    with pytest.raises(HarnessError, match=r"^/other counts no 'cuont'; did you mean 'count'$"):
        observer.counter("/other", "cuont")


def test_a_fresh_diagnostic_comes_after_it_was_asked_for(observer: Observer, node: Node) -> None:
    """What waits to be read is none, however much of it there is: it was said before."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def publish(count: int) -> None:
        values = [KeyValue(key="count", value=str(count))]
        publisher.publish(DiagnosticArray(status=[DiagnosticStatus(name="/late", values=values)]))

    assert "/late" not in observer.diagnostics
    observer.wait(publisher.get_subscription_count, "the observer to listen")
    publish(1)
    assert observer.counter("/late", "count") == 1.0
    for count in (2, 3, 4):
        publish(count)
    # They are in the reader's queue, and have not been taken.
    assert publisher.wait_for_all_acked(Duration(seconds=30))
    # Timers run while the observer waits.
    later = iter(range(100, 100_000))
    timer = node.create_timer(0.01, lambda: publish(next(later)))
    assert observer.counter("/late", "count", fresh=True) >= 100.0
    node.destroy_timer(timer)
    assert observer.counter("/late", "count", fresh=False) >= 100.0


def test_a_node_that_says_nothing_is_named(domain: dict[str, str]) -> None:
    """Waiting for a diagnostic ends with the full name of the node."""
    with (
        Observer(domain, "there", timeout=0.2) as hasty,
        pytest.raises(WaitTimeoutError, match="a diagnostic of /there/silent"),
    ):
        hasty.diagnostic("silent")


def test_a_check_cannot_wait(domain: dict[str, str]) -> None:
    """It is called in every wait: it would be called again and again."""
    with (
        Observer(domain, check=lambda: observer.wait(lambda: False, "nothing")) as observer,
        pytest.raises(HarnessError, match="none of its callbacks, laws and checks can wait"),
    ):
        observer.wait(lambda: False, "anything")


@pytest.mark.parametrize("end", [Observer.close, lambda observer: observer.context.try_shutdown()])
def test_what_comes_after_the_end_is_refused(
    domain: dict[str, str], end: Callable[[Observer], object]
) -> None:
    """In words, also a second time: no exception of rclpy without any."""
    observer = Observer(domain)
    end(observer)
    for use in (
        lambda: observer.wait(lambda: False, "anything"),
        lambda: observer.collect(Float64, "setpoint"),
        lambda: observer.publisher(Float64, "setpoint"),
        lambda: observer.call(Trigger, "plant/reset"),
        lambda: observer.get_parameters("plant", ["supply.pressure"]),
        lambda: observer.counter("plant", "commands clamped"),
        lambda: observer.counter("plant", "commands clamped"),
    ):
        with pytest.raises(HarnessError, match="the observer was closed, or its context shut down"):
            use()
    if end is not Observer.close:
        observer.close()
