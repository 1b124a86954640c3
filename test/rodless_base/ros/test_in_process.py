# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Delivery inside one process: direct, once, in order, and as the quality of service says."""

import json
import subprocess
import sys
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.publisher import Publisher
from std_msgs.msg import Float64

from rodless_base.ros import in_process
from rodless_base.ros.in_process import deliver_directly

# In a process of its own: DDS reads its settings once, with the first node of a process.
SCRIPT = """
import json, threading, time
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.task import Future
from std_msgs.msg import Float64
from rodless_base.ros.in_process import DirectNode, deliver_directly
from rodless_base.ros.message_info import with_info
from rodless_base.ros.process import make_executor
from rodless_base.ros.topics import LATCHED, LOSSLESS
from rodless_base.ros.profiles import leave_out_own_endpoints

leave_out_own_endpoints()
rclpy.init()
context = rclpy.get_default_context()
delivery = deliver_directly(context)
here, there = DirectNode("here"), DirectNode("there", namespace="/elsewhere")
best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
heard, threads, facts = [], [], {}

def take(topic):
    def took(message):
        threads.append(threading.current_thread().name)
        heard.append((topic, message))
    return took

one = here.create_publisher(Float64, "/one", LOSSLESS)
two = here.create_publisher(Float64, "/two", 10)
loose = here.create_publisher(Float64, "/loose", best_effort)
first = there.create_subscription(Float64, "/one", take("one"), 1000)
there.create_subscription(Float64, "/two", take("two"), 2)
there.create_subscription(Float64, "/loose", take("loose"), 10)
facts["counted"] = [one.get_subscription_count(), two.get_subscription_count(),
                    loose.get_subscription_count()]

# Published by another thread before there is an executor; taken by the one that spins.
def publish():
    for k in range(5):
        one.publish(Float64(data=float(k)))
        two.publish(Float64(data=10.0 + k))
        loose.publish(Float64(data=20.0))
publisher = threading.Thread(target=publish, name="publisher")
publisher.start()
publisher.join()
executor = make_executor()
delivery.attach(executor)
for node in (here, there):
    executor.add_node(node)

def spin_until(done, what):
    end = time.monotonic() + 60.0
    while not done():
        assert time.monotonic() < end, what
        executor.spin_until_future_complete(Future(), 0.05)

spin_until(lambda: len(heard) >= 7, "seven messages")
facts["order"] = [(topic, message.data) for topic, message in heard]
facts["threads"] = sorted(set(threads))
heard.clear()
message = Float64(data=7.0)
one.publish(message)
spin_until(lambda: heard, "one message")
facts["the message itself"] = heard[0][1] is message
heard.clear()

# Somebody else: hears each once, and is heard once.
others = Context()
rclpy.init(context=others)
other = Node("other", context=others)
at_other = []
other.create_subscription(Float64, "/one", at_other.append, 10)
voice = other.create_publisher(Float64, "/one", 10)
listening = make_executor(others)
listening.add_node(other)
def matched():
    return one.get_subscription_count() == 2 and voice.get_subscription_count() == 1
spin_until(matched, "a match")
one.publish(Float64(data=1.0))
voice.publish(Float64(data=2.0))
def arrived():
    listening.spin_until_future_complete(Future(), 0.05)
    return len(heard) >= 2 and len(at_other) >= 1
spin_until(arrived, "messages there and back")
# A last one each way: had there been a second copy of one before, it would be here too.
one.publish(Float64(data=3.0))
voice.publish(Float64(data=4.0))
spin_until(lambda: arrived() and len(heard) >= 4 and len(at_other) >= 2, "the last messages")
facts["heard here"] = sorted(message.data for _, message in heard)
facts["heard there"] = sorted(message.data for message in at_other)

# As bytes, for who wants them so; bytes that are published are a message for the others.
raw, cooked, told = [], [], []
bytes_at = there.create_subscription(Float64, "/forms", raw.append, LOSSLESS, raw=True)
there.create_subscription(Float64, "/forms", cooked.append, 10)
there.create_subscription(Float64, "/forms", with_info(lambda _, info: told.append(info)), 10)
forms = here.create_publisher(Float64, "/forms", 10)
forms.publish(Float64(data=5.0))
forms.publish(serialize_message(Float64(data=6.0)))
spin_until(lambda: len(told) == 2, "both forms")
facts["raw"] = [deserialize_message(one, Float64).data for one in raw]
facts["cooked"] = [one.data for one in cooked]
facts["numbered"] = [one["publication_sequence_number"] for one in told]
facts["matched"] = [there.count_matched(bytes_at), there.count_matched(first)]
forms.publish(Float64(data=7.0))
there.deliver_waiting(bytes_at)
facts["taken out of turn"] = [deserialize_message(raw[-1], Float64).data, len(cooked)]
spin_until(lambda: len(told) == 3, "the others")
facts["no second time"] = len(raw)

# What is latched waits for readers that ask for it, here and elsewhere.
latched = here.create_publisher(Float64, "/latched", LATCHED)
for value in (8.0, 9.0):
    latched.publish(Float64(data=value))
late, fresh, far = [], [], []
there.create_subscription(Float64, "/latched", late.append, LATCHED)
there.create_subscription(Float64, "/latched", fresh.append, 10)
other.create_subscription(Float64, "/latched", far.append, LATCHED)
def is_far():
    listening.spin_until_future_complete(Future(), 0.05)
    return len(far) == 2 and len(late) == 2
spin_until(is_far, "what is latched")
latched.publish(Float64(data=10.0))
def is_new():
    listening.spin_until_future_complete(Future(), 0.05)
    return min(len(far), len(late)) == 3 and fresh
spin_until(is_new, "what comes after it")
facts["latched"] = [[one.data for one in found] for found in (late, far, fresh)]

there.destroy_subscription(first)
facts["without readers"] = one.get_subscription_count()

# What a callback raises is the node's to know, as with any message.
def fail(_):
    raise ZeroDivisionError
there.create_subscription(Float64, "/fails", fail, 10)
here.create_publisher(Float64, "/fails", 10).publish(Float64())
spin_until(lambda: there.callback_errors, "an error")
facts["errors"] = [here.callback_errors, there.callback_errors]
print(json.dumps(facts), flush=True)
for node in (here, there, other):
    node.destroy_node()
"""


@pytest.fixture(scope="module")
def facts(domain: dict[str, str]) -> Any:
    """What a process with two nodes, and another participant, has found."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=domain,
        capture_output=True,
        text=True,
        timeout=180.0,
        check=False,
    )
    assert done.stdout, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_messages_come_in_the_order_they_were_published_in(facts: Any) -> None:
    """Across topics; of the topic with room for two, the last two; from an incompatible one none.

    The oldest of the short queue are lost, so its last two come when theirs would have been due.
    """
    data = [tuple(one) for one in facts["order"]]
    assert [value for topic, value in data if topic == "one"] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert [value for topic, value in data if topic == "two"] == [13.0, 14.0]
    assert len(data) == 7


def test_only_what_fits_is_connected(facts: Any) -> None:
    """One reader each, and none for a reliable reader of a publisher that is not."""
    assert facts["counted"] == [1, 1, 0]


def test_callbacks_run_where_the_executor_spins(facts: Any) -> None:
    """Not in the thread that has published; and they get the message itself."""
    assert facts["threads"] == ["MainThread"]
    assert facts["the message itself"]


def test_everybody_else_is_served_by_the_middleware_and_nobody_twice(facts: Any) -> None:
    """A node beside the process hears it and is heard, each message once."""
    assert facts["heard here"] == [1.0, 2.0, 3.0, 4.0]
    assert facts["heard there"] == [1.0, 3.0]


def test_each_gets_the_message_in_the_form_it_has_asked_for(facts: Any) -> None:
    """Bytes or a message, however it was published, and numbered as the middleware does."""
    assert facts["raw"] == facts["cooked"] == [5.0, 6.0]
    assert facts["numbered"] == [1, 2]


def test_what_is_latched_waits_for_whoever_comes_later(facts: Any) -> None:
    """In this process and in another, each once; a reader that does not ask gets what is new."""
    assert facts["latched"] == [[8.0, 9.0, 10.0], [8.0, 9.0, 10.0], [10.0]]


def test_publishers_of_the_same_process_count_as_matched(facts: Any) -> None:
    """One here; of the topic that somebody else publishes too, both."""
    assert facts["matched"] == [1, 2]


def test_what_waits_for_a_subscription_can_be_taken_out_of_turn(facts: Any) -> None:
    """For this one only, and not once more when its turn comes."""
    assert facts["taken out of turn"] == [7.0, 2]
    assert facts["no second time"] == 3


def test_a_subscription_that_is_gone_gets_nothing(facts: Any) -> None:
    """The publisher counts the one outside the process alone."""
    assert facts["without readers"] == 1


def test_an_error_in_a_callback_is_not_swallowed(facts: Any) -> None:
    """The node that has the callback counts it, as with a message from outside."""
    assert facts["errors"] == [0, 1]


def test_where_the_middleware_delivers_by_itself_it_is_left_to_it(
    domain: dict[str, str],  # noqa: ARG001  sets the environment
) -> None:
    """With DDS as everybody has it, messages would come twice: nothing is delivered directly."""
    context = Context()
    rclpy.init(context=context)
    try:
        assert deliver_directly(context) is None
    finally:
        rclpy.try_shutdown(context=context)


class Heard:
    """A subscription in the same process that counts messages."""

    raw = False

    def __init__(self) -> None:
        self.count = 0

    def put(self, _message: object, _info: object) -> None:
        """Count it."""
        self.count += 1


class Middleware:
    """What a publisher asks of rclpy: how many listen elsewhere, and to send to them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.listeners = self.asked = self.sent = 0
        self.now = 100.0
        monkeypatch.setattr(Publisher, "get_subscription_count", lambda _: self._ask())
        monkeypatch.setattr(Publisher, "publish", lambda _, _message: self._send())
        monkeypatch.setattr(in_process, "monotonic", lambda: self.now)

    def _ask(self) -> int:
        self.asked += 1
        return self.listeners

    def _send(self) -> None:
        self.sent += 1


def test_who_listens_elsewhere_is_asked_once_a_millisecond(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A thousand messages at one moment are one question; a newcomer is heard of 1 ms later.

    Whoever asks for the number itself renews it: the next message goes out at once.
    """
    middleware, reader = Middleware(monkeypatch), Heard()
    publisher = in_process.DirectPublisher.__new__(in_process.DirectPublisher)
    publisher.readers = (reader,)  # type: ignore[assignment]
    for _ in range(1000):
        publisher.publish(Float64())
    assert (middleware.asked, middleware.sent, reader.count) == (1, 0, 1000)
    middleware.listeners = 2
    publisher.publish(Float64())
    assert middleware.sent == 0
    middleware.now += 1.1e-3
    publisher.publish(Float64())
    assert (middleware.asked, middleware.sent) == (2, 1)
    middleware.listeners = 0
    assert publisher.get_subscription_count() == 1
    publisher.publish(Float64())
    assert (middleware.asked, middleware.sent, reader.count) == (3, 1, 1003)


def test_an_older_answer_does_not_replace_a_newer_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread asks while nobody listens, and hears of it after another has learned of somebody."""
    middleware, reader = Middleware(monkeypatch), Heard()
    publisher = in_process.DirectPublisher.__new__(in_process.DirectPublisher)
    publisher.readers = (reader,)  # type: ignore[assignment]

    def slow(_: object) -> int:
        monkeypatch.setattr(Publisher, "get_subscription_count", lambda _: 1)
        middleware.now += 1e-4
        assert publisher.get_subscription_count() == 2
        return 0

    monkeypatch.setattr(Publisher, "get_subscription_count", slow)
    assert publisher.get_subscription_count() == 1
    publisher.publish(Float64())
    assert middleware.sent == 1
