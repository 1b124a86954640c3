# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Publish in order, and only what somebody reads: a message costs as much to build as to send."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import Any, Generic, TypeVar

from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from rodless_base.ros.profiles import asks_at_once
from rodless_base.ros.topics import QUEUE_DEPTH

# How long (wall-clock s) the nodes of a process that ends wait for their readers, all in all: they
# promise to end within 2 s, and a stopped reader may hold them up for some of that before.
END_TIMEOUT = 0.5

NOT_RECEIVED = (
    "ended before its readers had confirmed everything; unless they were killed, what they lack is "
    "lost: a recorder that is behind is to be ended first"
)

# What /diagnostics calls messages that an Outbox had no room for.
LOST = "messages lost to a stopped subscriber"

# A node that the middleware has seen the publisher of, and not the name: see unheard.py.
UNKNOWN = "(a node whose name is not known, perhaps of another account)"

Value = TypeVar("Value")


class Outbox:
    """Sends the messages of one or several publishers in the order in which they are given.

    A reader that has stopped reading holds a lossless publisher back. Its message, and all after
    it, wait here until :meth:`flush` gets them through: when the reader reads on, or when the
    middleware has given it up (20 s, by default, after it was stopped or killed). Beyond
    ``QUEUE_DEPTH`` the oldest is lost.
    """

    def __init__(self, node: Node) -> None:
        """Nothing waits; ``node`` knows who reads."""
        self._node = node
        self._waiting: deque[tuple[Publisher, object]] = deque()
        self.lost = 0

    def send(self, publisher: Publisher, message: object) -> None:
        """Publish, or keep the message until :meth:`flush`."""
        if not self._waiting and _is_published(publisher, message):
            return
        self._waiting.append((publisher, message))
        if len(self._waiting) > QUEUE_DEPTH:
            self._waiting.popleft()
            self.lost += 1

    def flush(self, deadline: float = math.inf) -> bool:
        """Try to publish what waits, to ``deadline`` (s, monotonic); return whether none is left.

        One is tried however late it is. It is to be called now and then: publishing blocks for a
        moment where a reader is stopped, and where it is slow for each message.
        """
        while self._waiting and _is_published(*self._waiting[0]):
            self._waiting.popleft()
            if monotonic() >= deadline:
                break
        return not self._waiting

    @property
    def is_empty(self) -> bool:
        """Whether no message waits."""
        return not self._waiting

    def clear(self) -> bool:
        """Forget what waits, which does not count as lost; return whether anything did.

        What a publisher is to have ready for whoever comes later waits on: nobody says it again.
        """
        before = len(self._waiting)
        self._waiting = deque(one for one in self._waiting if _is_latched(one[0]))
        return len(self._waiting) < before

    def forget(self, publisher: Publisher) -> None:
        """Leave out what waits for one publisher, which ends."""
        self._waiting = deque(one for one in self._waiting if one[0] is not publisher)

    @property
    def obstacle(self) -> str | None:
        """Say whom the messages wait for, if any do."""
        if not self._waiting:
            return None
        topic = self._waiting[0][0].topic_name
        readers = sorted(set(nodes(self._node.get_subscriptions_info_by_topic(topic)).values()))
        return f"a subscriber of {topic} has stopped reading ({' or '.join(readers)})"


def nodes(endpoints: Sequence[TopicEndpointInfo]) -> dict[bytes, str]:
    """Return the full name of each endpoint's node, by what identifies the endpoint."""
    return {bytes(end.endpoint_gid): _full_name(end) for end in endpoints}


def _is_latched(publisher: Publisher) -> bool:
    return bool(publisher.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _full_name(endpoint: TopicEndpointInfo) -> str:
    name: str = endpoint.node_name
    return UNKNOWN if "UNKNOWN" in name else f"{endpoint.node_namespace.rstrip('/')}/{name}"


def _is_published(publisher: Publisher, message: object) -> bool:
    try:
        publisher.publish(message)
    except rclpy_implementation.RCLError:
        return False
    return True


def wait_for_readers(outbox: Outbox, publishers: Iterable[Publisher], deadline: float) -> bool:
    """Give the readers of ``publishers`` time, to ``deadline`` (s, monotonic), for what they lack.

    A publisher that ends takes with it what waits for a reader, such as a recorder that is behind.
    Returns whether they have all, as far as that is known: readers confirm it when they are asked,
    which may be seconds later with settings of Fast DDS that are not ours.
    """
    while not (received := outbox.flush(deadline)) and monotonic() < deadline:
        pass  # each try in vain blocks for a moment
    for publisher in publishers:
        received &= _is_received(publisher, deadline - monotonic()) or not asks_at_once()
    return received


def _is_received(publisher: Publisher, timeout: float) -> bool:
    try:
        return bool(publisher.wait_for_all_acked(Duration(seconds=max(timeout, 1e-3))))
    except rclpy_implementation.RCLError:
        return False


class OnDemand:
    """A publisher that builds and sends messages while it has subscribers.

    Their number is looked up in :meth:`poll` only, which its owner calls now and then: asking
    every time costs as much as what it saves.
    """

    def __init__(self, publisher: Publisher, message: Callable[..., Any], outbox: Outbox) -> None:
        """Send through ``outbox`` what ``message`` makes of the values to publish."""
        self._publisher = publisher
        self._message = message
        self._outbox = outbox
        self.subscribers = 0

    def poll(self) -> int:
        """Look up and return the number of subscribers."""
        self.subscribers = int(self._publisher.get_subscription_count())
        return self.subscribers

    @property
    def publisher(self) -> Publisher:
        """What it sends with."""
        return self._publisher

    def close(self, node: Node) -> None:
        """End the publisher, which is ``node``'s, and forget what waits for it."""
        self._outbox.forget(self._publisher)
        node.destroy_publisher(self._publisher)

    def publish(self, *values: object) -> None:
        """Send the message of ``values`` to the subscribers of the last poll, if any."""
        if self.subscribers:
            self._outbox.send(self._publisher, self._message(*values))


class Throttled(Generic[Value]):
    """The last of something, for whoever only looks on: once for each poll, and for newcomers."""

    def __init__(self, outbox: Outbox) -> None:
        """Nothing has come yet; what is due is sent through ``outbox``, where only it counts."""
        self.last: Value | None = None
        self._outbox = outbox
        # What has been sent, and to how many.
        self._sent: Value | None = None
        self._listeners = 0

    def due(self, publishers: Iterable[OnDemand]) -> Value | None:
        """Poll; return the last where those who look on do not have it all.

        Whoever comes in a pause is shown where the rig stands.
        """
        # Read once: another thread may bring the next.
        last, before = self.last, self._listeners
        self._listeners = sum(one.poll() for one in publishers)
        if last is None or (last is self._sent and self._listeners <= before):
            return None
        self._sent = last
        self._outbox.clear()
        return last
