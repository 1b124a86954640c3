# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Deliver messages inside one process directly, as rclcpp's intra-process communication does.

Publishers and subscriptions stay on the middleware, for everybody else; it must be told to leave
out those of the same process, or each message would come twice (Fast DDS: the property
``fastdds.ignore_local_endpoints``).
"""

from collections import deque
from collections.abc import Callable
from time import monotonic
from typing import Any
from weakref import WeakKeyDictionary

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSCompatibility, qos_check_compatible
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.subscription import Subscription
from std_msgs.msg import Float64

from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.message_info import Info, delivered_now, wants_info
from rodless_base.start import Stop

# How long (s) messages are delivered before timers and services have their turn: in lock-step each
# delivery brings the next message.
TURN = 1e-3

# How long (s) a count of the listeners in other processes holds while messages go out: asking costs
# a tenth of a lock-step period. Whoever asks for it, as for a start that loses nothing, renews it;
# who has matched without that may miss what is sent in this time.
KNOWN = 1e-3

_deliveries: "WeakKeyDictionary[Context, DirectDelivery]" = WeakKeyDictionary()


class DirectPublisher(Publisher):  # type: ignore[misc]
    """A publisher that hands its messages to subscriptions in the same process.

    They get the message itself, not a copy: neither side may change it afterwards. A subscription
    to raw messages gets it serialised; one that is given so is deserialised for the others.
    """

    readers: "tuple[Reader, ...]" = ()
    _sequence = 0
    # Until when (s, monotonic) it is known how many listen in other processes; and how many.
    _known = (0.0, 0)
    _kept: "deque[object] | None" = None

    def keep(self) -> None:
        """Keep messages for later readers where the durability says so."""
        if self.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept = deque(maxlen=self.qos_profile.depth)

    def add(self, reader: "Reader") -> None:
        """Publish to ``reader`` from now on, and what has been kept for such as it."""
        self.readers += (reader,)
        durability = reader.subscription.qos_profile.durability
        if self._kept is not None and durability == DurabilityPolicy.TRANSIENT_LOCAL:
            for message in self._kept:
                self._put(message, (reader,))

    def publish(self, msg: object) -> None:
        """Publish to whoever listens; raises RCLError, and then nobody has the message."""
        if self._kept is not None or not self.readers or self._others_listen():
            super().publish(msg)
        if self._kept is not None:
            self._kept.append(msg)
        if self.readers:
            self._sequence += 1
            self._put(msg, self.readers)

    def _others_listen(self) -> bool:
        if monotonic() > self._known[0]:
            self.get_subscription_count()
        return self._known[1] > 0

    def _put(self, msg: object, readers: "tuple[Reader, ...]") -> None:
        info = delivered_now(self._sequence)
        data = msg if isinstance(msg, bytes) else None
        message = None if isinstance(msg, bytes) else msg
        for reader in readers:
            if reader.raw:
                data = serialize_message(message) if data is None else data
                reader.put(data, info)
            else:
                message = deserialize_message(data, self.msg_type) if message is None else message
                reader.put(message, info)

    def get_subscription_count(self) -> int:
        """Return the number of subscriptions, those in the same process included."""
        until = monotonic() + KNOWN
        others = int(super().get_subscription_count())
        # Another thread may have asked in the meantime, and know better.
        if until >= self._known[0]:
            self._known = until, others
        return others + len(self.readers)


class Reader:
    """The queue of a subscription, as long as its quality of service says."""

    def __init__(
        self,
        subscription: Subscription,
        callback: Callable[[Any], None],
        ready: Callable[["Reader"], None],
    ) -> None:
        """Give what is put to ``callback`` in the turn for which ``ready`` asks."""
        self.subscription = subscription
        self.raw = bool(subscription.raw)
        self._callback = callback
        self._wants_info = wants_info(callback)
        self._ready = ready
        profile = subscription.qos_profile
        keeps_all = profile.history == HistoryPolicy.KEEP_ALL
        self._messages: deque[object] = deque(maxlen=None if keeps_all else profile.depth)

    def matches(self, publisher: DirectPublisher) -> bool:
        """Whether topic, type and quality of service fit."""
        own = self.subscription
        fits, _ = qos_check_compatible(publisher.qos_profile, own.qos_profile)
        return (
            publisher.topic_name == own.topic_name
            and publisher.msg_type is own.msg_type
            and fits != QoSCompatibility.ERROR
        )

    def put(self, message: object, info: Info) -> None:
        """Take a message; the oldest is lost where there is no room."""
        self._messages.append((message, info) if self._wants_info else message)
        self._ready(self)

    def deliver(self) -> bool:
        """Call back with the oldest message, if it has not been lost; return whether it was there.

        A callback that wants information takes both as one pair, see
        :func:`~rodless_base.ros.message_info.with_info`.
        """
        if not self._messages:
            return False
        self._callback(self._messages.popleft())
        return True


class DirectDelivery:
    """Connects publishers and subscriptions of one context, in the order of the messages.

    Callbacks run in the executor, wherever a message was published.
    """

    def __init__(self) -> None:
        """Connect nothing yet."""
        self._executor: Executor | None = None
        self._stop: Stop | None = None
        self._publishers: list[DirectPublisher] = []
        self._readers: list[Reader] = []
        # One entry for each message.
        self._ready: deque[Reader] = deque()
        self._has_a_turn = False

    def attach(self, executor: Executor, stop: Stop | None = None) -> None:
        """Deliver in the turns that ``executor`` gives, until ``stop``.

        Without an end to the messages of a lock-step run, the executor would not end its spinning.
        """
        self._executor = executor
        self._stop = stop
        if self._ready:
            self._ask_for_a_turn()

    def add_publisher(self, publisher: DirectPublisher) -> None:
        """Connect a publisher."""
        self._publishers.append(publisher)
        publisher.keep()
        publisher.readers = tuple(one for one in self._readers if one.matches(publisher))

    def add_subscription(self, subscription: Subscription, callback: Callable[[Any], None]) -> None:
        """Connect a subscription."""
        reader = Reader(subscription, callback, self._is_ready)
        self._readers.append(reader)
        for publisher in self._publishers:
            if reader.matches(publisher):
                publisher.add(reader)

    def count_publishers(self, subscription: Subscription) -> int:
        """Return how many publishers a subscription is connected with."""
        found = [one for one in self._readers if one.subscription is subscription]
        return sum(one in publisher.readers for one in found for publisher in self._publishers)

    def deliver_waiting(self, subscription: Subscription) -> None:
        """Call back with all that waits for a subscription, in whatever thread this is called."""
        for reader in self._readers:
            while reader.subscription is subscription and reader.deliver():
                pass

    def remove(self, subscription: Subscription) -> None:
        """Disconnect a subscription."""
        self._readers = [one for one in self._readers if one.subscription is not subscription]
        for publisher in self._publishers:
            publisher.readers = tuple(one for one in publisher.readers if one in self._readers)

    def remove_publisher(self, publisher: Publisher) -> None:
        """Connect a publisher with nobody any more."""
        self._publishers = [one for one in self._publishers if one is not publisher]

    def _is_ready(self, reader: Reader) -> None:
        self._ready.append(reader)
        if not self._has_a_turn:
            self._ask_for_a_turn()

    def _ask_for_a_turn(self) -> None:
        stopped = self._stop is not None and self._stop.requested
        if self._executor is not None and not stopped:
            self._has_a_turn = True
            self._executor.create_task(self._deliver)

    def _deliver(self) -> None:
        end = monotonic() + TURN
        try:
            while self._ready and monotonic() < end:
                self._ready.popleft().deliver()
        finally:
            # In this order: what another thread puts in between must not be left lying.
            self._has_a_turn = False
            if self._ready:
                self._ask_for_a_turn()


class DirectNode(GuardedNode):
    """A node whose publishers and subscriptions use the delivery of its context, if any."""

    def create_publisher(self, *arguments: Any, **options: Any) -> Publisher:
        """As rclpy's."""
        delivery = _deliveries.get(self.context)
        if delivery is None:
            return super().create_publisher(*arguments, **options)
        publisher = super().create_publisher(
            *arguments, **{"publisher_class": DirectPublisher, **options}
        )
        delivery.add_publisher(publisher)
        return publisher

    def create_subscription(self, *arguments: Any, **options: Any) -> Subscription:
        """As rclpy's."""
        subscription = super().create_subscription(*arguments, **options)
        delivery = _deliveries.get(self.context)
        if delivery is not None:
            delivery.add_subscription(subscription, subscription.callback)
        return subscription

    def count_matched(self, subscription: Subscription) -> int:
        """Return how many publishers a subscription has, those in the same process included."""
        delivery = _deliveries.get(self.context)
        direct = 0 if delivery is None else delivery.count_publishers(subscription)
        return int(subscription.get_publisher_count()) + direct

    def deliver_waiting(self, subscription: Subscription) -> None:
        """Call back with all that publishers in the same process have sent already."""
        delivery = _deliveries.get(self.context)
        if delivery is not None:
            delivery.deliver_waiting(subscription)

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """As rclpy's."""
        delivery = _deliveries.get(self.context)
        if delivery is not None:
            delivery.remove_publisher(publisher)
        return bool(super().destroy_publisher(publisher))

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """As rclpy's."""
        delivery = _deliveries.get(self.context)
        if delivery is not None:
            delivery.remove(subscription)
        return bool(super().destroy_subscription(subscription))


def deliver_directly(context: Context) -> DirectDelivery | None:
    """Let the nodes made in ``context`` from now on deliver to each other directly.

    Returns None where the middleware delivers inside the process and cannot be kept from it.
    """
    if _middleware_delivers(context):
        return None
    return _deliveries.setdefault(context, DirectDelivery())


def _middleware_delivers(context: Context) -> bool:
    """Try it out on a hidden topic: endpoints of one process are matched at once."""
    node = Node("_probe", context=context, enable_rosout=False, start_parameter_services=False)
    try:
        publisher = node.create_publisher(Float64, "~/_probe", 1)
        node.create_subscription(Float64, "~/_probe", lambda _: None, 1)
        return bool(publisher.get_subscription_count())
    finally:
        node.destroy_node()
