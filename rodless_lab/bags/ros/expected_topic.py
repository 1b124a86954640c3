# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A topic that is listened to before anybody publishes it."""

from collections.abc import Callable

from rclpy.qos import QoSProfile

from rodless_base.ros.message_info import Info
from rodless_lab.bags.ros.qos import USUAL_OFFER, matching_profile
from rodless_lab.bags.ros.topic_discovery import Offer

# Messages that may come before a publisher has been seen: far more than one that latches keeps.
REMEMBERED = 1000


class ExpectedTopic:
    """How it is listened to meanwhile, and what has come so far.

    A publisher that wants another listener has one once it is seen. Where it latches, that one gets
    again what has come.
    """

    profile = matching_profile([USUAL_OFFER])

    def __init__(self, listened: Offer) -> None:
        """Expect what others listen to."""
        self._listened = listened
        self._taken: dict[tuple[int, int], None] = {}  # in the order of their coming

    def serves(self, offer: Offer, profile: QoSProfile) -> bool:
        """Whether it can stay for ``offer``, to which one with ``profile`` would listen.

        It does where something has come of another type: a bag has one for each topic.
        """
        if offer.type_name != self._listened.type_name:
            return bool(self._taken)
        return bool(profile == self.profile)

    def take(self, info: Info) -> None:
        """Take note of a message that has come."""
        if len(self._taken) == REMEMBERED:
            del self._taken[next(iter(self._taken))]
        self._taken[_identity(info)] = None

    def without_repeats(
        self, receive: Callable[[bytes, Info], None]
    ) -> Callable[[bytes, Info], None]:
        """Return ``receive`` for what has not come yet."""

        def receive_new(data: bytes, info: Info) -> None:
            if _identity(info) not in self._taken:
                receive(data, info)

        return receive_new


def _identity(info: Info) -> tuple[int, int]:
    """Return what two messages of a topic do not share: when they were sent, and which it was."""
    return info["source_timestamp"] or 0, info["publication_sequence_number"] or 0
