# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages that a reader holds back are kept, in order, and none is forgotten."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.impl.implementation_singleton import rclpy_implementation
from std_msgs.msg import Float64

from rodless_base.ros import publish
from rodless_base.ros.publish import OnDemand, Outbox
from rodless_base.ros.topics import LATCHED, LOSSLESS


class Stopped:
    """A lossless publisher whose subscriber stops reading after some messages."""

    topic_name = "/samples"
    qos_profile = LOSSLESS

    def __init__(self, sent: list[tuple[str, float]], name: str, room: int) -> None:
        self.sent, self.name, self.room = sent, name, room

    def get_subscription_count(self) -> int:
        """One, which still is there."""
        return 1

    def publish(self, message: Float64) -> None:
        """Send, or fail as rclpy does where there is no room."""
        if self.room == 0:
            raise rclpy_implementation.RCLError("timeout")
        self.room -= 1
        self.sent.append((self.name, message.data))


class Bench:
    """Two publishers with one outbox, and the node that knows their readers."""

    def __init__(self, room: int) -> None:
        readers = [
            SimpleNamespace(node_name=name, node_namespace=space, endpoint_gid=[k])
            for k, (space, name) in enumerate([("/", "recorder"), ("/rig", "echo")])
        ]
        node: Any = SimpleNamespace(get_subscriptions_info_by_topic=lambda _: readers)
        self.outbox = Outbox(node)
        self.sent: list[tuple[str, float]] = []
        self.first: Any = Stopped(self.sent, "first", room)
        self.second: Any = Stopped(self.sent, "second", 1000)

    def send(self, *values: float) -> None:
        """Send each value by both, the first before the second."""
        for value in values:
            for publisher in (self.first, self.second):
                self.outbox.send(publisher, Float64(data=value))


def test_messages_wait_in_order_until_their_reader_reads_on() -> None:
    """Of both publishers, though only one is held back; however often it is tried in vain."""
    bench = Bench(room=1)
    bench.send(1.0, 2.0)
    expected = [("first", 1.0), ("second", 1.0), ("first", 2.0), ("second", 2.0)]
    assert bench.sent == expected[:2]
    assert not any(bench.outbox.flush() for _ in range(1000))
    assert bench.sent == expected[:2]
    bench.first.room = 1
    assert bench.outbox.flush()
    assert bench.sent == expected
    assert bench.outbox.lost == 0


def test_the_readers_that_may_hold_it_back_are_named() -> None:
    """With full names and the topic, as long as something waits."""
    bench = Bench(room=0)
    assert bench.outbox.obstacle is None
    bench.send(1.0)
    said = "a subscriber of /samples has stopped reading (/recorder or /rig/echo)"
    assert bench.outbox.obstacle == said
    assert bench.outbox.clear()
    assert bench.outbox.obstacle is None
    assert not bench.outbox.clear()
    assert bench.sent == []


def test_what_a_publisher_has_ready_for_whoever_comes_later_is_not_forgotten() -> None:
    """Nobody says it again: it waits on where the samples are withdrawn that wait with it."""
    bench = Bench(room=0)
    bench.second.qos_profile = LATCHED
    bench.send(1.0)
    assert bench.outbox.clear()
    assert not bench.outbox.clear()
    assert bench.outbox.flush()
    assert bench.sent == [("second", 1.0)]


def test_what_there_is_no_room_for_counts_as_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oldest goes first: a command is worth the more the newer it is."""
    monkeypatch.setattr(publish, "QUEUE_DEPTH", 4)
    bench = Bench(room=0)
    bench.send(1.0, 2.0, 3.0)
    assert bench.outbox.lost == 2
    bench.first.room = 1000
    assert bench.outbox.flush()
    assert [value for _, value in bench.sent] == [2.0, 2.0, 3.0, 3.0]


def test_messages_on_demand_are_built_for_subscribers_only() -> None:
    """Before the first poll there are none."""
    bench = Bench(room=1000)
    built: list[float] = []

    def build(value: float) -> Float64:
        built.append(value)
        return Float64(data=value)

    on_demand = OnDemand(bench.first, build, bench.outbox)
    on_demand.publish(0.0)
    assert (bench.sent, built) == ([], [])
    assert on_demand.poll() == 1
    on_demand.publish(1.0)
    assert bench.sent == [("first", 1.0)]


class Slow(Stopped):
    """One whose reader reads on so slowly that each message takes 62.5 ms to get out."""

    def __init__(self, sent: list[tuple[str, float]], clock: list[float]) -> None:
        super().__init__(sent, "slow", 1000)
        self.clock = clock
        self.waits: list[float] = []

    def publish(self, message: Float64) -> None:
        """Let time pass."""
        self.clock[0] += 0.0625
        super().publish(message)

    def wait_for_all_acked(self, timeout: Any) -> bool:
        """It takes longer than anybody waits."""
        self.waits.append(timeout.nanoseconds * 1e-9)
        return False


def test_a_node_that_ends_waits_for_a_slow_reader_to_its_deadline(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """However much waits: 12 messages of 62.5 ms in 0.75 s, and nothing is left for receipts."""
    clock, bench = [100.0], Bench(room=0)
    monkeypatch.setattr(publish, "monotonic", lambda: clock[0])
    monkeypatch.setattr(publish, "asks_at_once", lambda: True)
    slow: Any = Slow(bench.sent, clock)
    bench.outbox.send(bench.first, Float64(data=-1.0))
    for value in range(100):
        bench.outbox.send(slow, Float64(data=float(value)))
    bench.first.room = 1
    assert not publish.wait_for_readers(bench.outbox, [slow], clock[0] + 0.75)
    assert [value for _, value in bench.sent] == [-1.0, *range(12)]
    assert slow.waits == pytest.approx([1e-3])


def test_a_node_that_ends_late_tries_each_reader_once() -> None:
    """Of two in one process the first may use up the time; the reader of the other may be free."""
    bench = Bench(room=0)
    bench.send(1.0)
    bench.first.room = 1
    publish.wait_for_readers(bench.outbox, [], 0.0)
    assert bench.sent[0] == ("first", 1.0)


@pytest.mark.parametrize("asks", [True, False])
def test_what_no_reader_is_asked_for_is_not_called_lost(
    monkeypatch: pytest.MonkeyPatch, asks: bool
) -> None:
    """By default Fast DDS asks every 3 s: that nothing is confirmed by then says nothing."""
    clock, bench = [100.0], Bench(room=1)
    monkeypatch.setattr(publish, "asks_at_once", lambda: asks)
    silent: Any = Slow(bench.sent, clock)
    assert publish.wait_for_readers(bench.outbox, [silent], 1e9) == (not asks)


def test_readers_that_have_everything_are_not_waited_for() -> None:
    """What has waited goes out first; whether all is received is what is returned."""
    bench = Bench(room=0)
    bench.send(1.0)
    bench.first.room = 1
    for publisher in (bench.first, bench.second):
        publisher.wait_for_all_acked = lambda _: bench.sent == [("first", 1.0), ("second", 1.0)]
    assert publish.wait_for_readers(bench.outbox, [bench.first, bench.second], 1e9)
