# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Publishers that are seen and never heard: those of another account on this machine.

Fast DDS finds them over the network, and then sends through shared memory, which is of one account:
nothing arrives, the names of their nodes included.
"""

from collections import Counter
from collections.abc import Iterable

from rclpy.node import Node

from rodless_base.ros.publish import UNKNOWN, nodes

WAY_OUT = (
    "probably from a process of another account, which shares no memory with this one; start all "
    "of them with FASTDDS_BUILTIN_TRANSPORTS=UDPv4"
)

# How often (s, wall clock) they are looked for, and in how many looks one after the other a topic
# must have been silent: names of nodes take a moment. Fewer have to do where there is no time left.
LOOK_PERIOD = 1.0
LOOKS = 5
LOOKS_AT_THE_END = 2


def has_unheard_publisher(observer: Node, topic: str) -> bool:
    """Whether a node publishes ``topic`` whose name has not arrived, which takes a moment."""
    return UNKNOWN in nodes(observer.get_publishers_info_by_topic(topic)).values()


class UnheardTopics:
    """Finds them: to be looked for by :meth:`look`, once in ``LOOK_PERIOD``."""

    def __init__(self, node: Node) -> None:
        """Know of none."""
        self._node = node
        self._looks: Counter[str] = Counter()
        self.found: list[str] = []

    def look(self, silent: Iterable[str], enough: int = LOOKS) -> list[str]:
        """Return those of the ``silent`` topics that have become known as unheard of."""
        self._looks = Counter(
            {
                topic: self._looks[topic] + 1
                for topic in silent
                if has_unheard_publisher(self._node, topic)
            }
        )
        new = [
            topic
            for topic, looks in self._looks.items()
            if looks >= enough and topic not in self.found
        ]
        self.found += new
        return new
