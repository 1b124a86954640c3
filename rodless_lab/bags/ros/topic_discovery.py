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
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

from rodless_lab.bags.message_definition import message_class


class Offer(NamedTuple):
    """A topic that somebody publishes."""

    topic: str
    type_name: str
    message_type: type[Any]
    profiles: list[QoSProfile]


class TopicDiscovery:
    """Looks for the topics in ``wanted``, or for all that are not hidden if it is empty.

    Those there are come in the order of ``wanted``, so that whoever waits for a subscription to
    the last of them has found the others.

    Topics of the looking node itself do not count. A topic that cannot be recorded is named once
    in the log.
    """

    def __init__(self, node: Node, wanted: Sequence[str]) -> None:
        self._node = node
        self._wanted = wanted
        self._complained: set[str] = set()

    def new_offers(self, known: Collection[str]) -> list[Offer]:
        """Return the topics that can be recorded and are not among the ``known`` ones."""
        found = [
            self._offer(topic, types)
            for topic, types in self._node.get_topic_names_and_types()
            if topic not in known and self._is_wanted(topic)
        ]
        places = {topic: place for place, topic in enumerate(self._wanted)}
        offers = [offer for offer in found if offer is not None]
        return sorted(offers, key=lambda offer: places.get(offer.topic, 0))

    def _is_wanted(self, topic: str) -> bool:
        if self._wanted:
            return topic in self._wanted
        return not topic_or_service_is_hidden(topic)

    def _offer(self, topic: str, types: list[str]) -> Offer | None:
        profiles = [
            info.qos_profile
            for info in self._node.get_publishers_info_by_topic(topic)
            if (info.node_name, info.node_namespace)
            != (self._node.get_name(), self._node.get_namespace())
        ]
        if not profiles:
            return None
        if len(types) > 1:
            self._complain(topic, f"it has several types: {', '.join(types)}")
            return None
        try:
            return Offer(topic, types[0], message_class(types[0]), profiles)
        except (ImportError, AttributeError):
            self._complain(topic, f"its type {types[0]} is not installed")
            return None

    def _complain(self, topic: str, reason: str) -> None:
        if topic not in self._complained:
            self._complained.add(topic)
            self._node.get_logger().warning(f"{topic} is not recorded: {reason}")
