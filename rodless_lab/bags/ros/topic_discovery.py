# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which topics there are to record, and how to subscribe to them."""

from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

from rodless_base.topics import SENT_IN_PASSING
from rodless_lab.bags.message_definition import message_class

IN_PASSING = tuple(f"/{topic}" for topic in SENT_IN_PASSING)


class Offer(NamedTuple):
    """A topic that somebody publishes, or one without ``profiles`` that somebody waits for."""

    topic: str
    type_name: str
    message_type: type[Any]
    profiles: list[QoSProfile]


class TopicDiscovery:
    """Looks for the topics in ``wanted``, or for all that are not hidden if it is empty.

    They are those that somebody publishes, and of ``SENT_IN_PASSING`` also those that somebody
    listens to: who sends these may have gone before the next look. They come in the order of
    ``wanted``, so that whoever waits for a subscription to the last of them has found the others.

    Topics of the looking node itself do not count. A topic that cannot be recorded is named once
    in the log.
    """

    def __init__(self, node: Node, wanted: Sequence[str]) -> None:
        self._node = node
        self._wanted = wanted
        self._complained: set[str] = set()

    def new_offers(self, known: Collection[str], expected: Collection[str] = ()) -> list[Offer]:
        """Return the topics that can be recorded and are not among the ``known`` ones.

        Those ``expected`` are returned only once somebody publishes them.
        """
        found = [
            self._offer(topic, topic in expected)
            for topic, _ in self._node.get_topic_names_and_types()
            if topic not in known and self._is_wanted(topic)
        ]
        places = {topic: place for place, topic in enumerate(self._wanted)}
        offers = [offer for offer in found if offer is not None]
        return sorted(offers, key=lambda offer: places.get(offer.topic, 0))

    def offered(self, topic: str) -> list[QoSProfile]:
        """Return what those offer who publish ``topic`` at this moment."""
        return [one.qos_profile for one in self._publishers(topic)]

    def _is_wanted(self, topic: str) -> bool:
        if self._wanted:
            return topic in self._wanted
        return not topic_or_service_is_hidden(topic)

    def _offer(self, topic: str, is_expected: bool) -> Offer | None:
        publishers = self._publishers(topic)
        if not publishers:
            return None if is_expected else self._awaited(topic)
        types = sorted({end.topic_type for end in publishers})
        if len(types) > 1:
            self._complain(topic, f"it has several types: {', '.join(types)}")
            return None
        try:
            kind = message_class(types[0])
        except (ImportError, AttributeError):
            self._complain(topic, f"its type {types[0]} is not installed")
            return None
        return Offer(topic, types[0], kind, [end.qos_profile for end in publishers])

    def _awaited(self, topic: str) -> Offer | None:
        """Return a topic that is sent in passing, if somebody listens to it, to one type."""
        if not topic.endswith(IN_PASSING):
            return None
        listeners = self._others(self._node.get_subscriptions_info_by_topic(topic))
        types = {end.topic_type for end in listeners}
        if len(types) != 1:
            return None
        (name,) = types
        try:
            return Offer(topic, name, message_class(name), [])
        except (ImportError, AttributeError):
            return None

    def _publishers(self, topic: str) -> list[TopicEndpointInfo]:
        return self._others(self._node.get_publishers_info_by_topic(topic))

    def _others(self, ends: Sequence[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
        own = (self._node.get_name(), self._node.get_namespace())
        return [end for end in ends if (end.node_name, end.node_namespace) != own]

    def _complain(self, topic: str, reason: str) -> None:
        if topic not in self._complained:
            self._complained.add(topic)
            self._node.get_logger().warning(f"{topic} is not recorded: {reason}")
