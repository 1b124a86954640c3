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

from collections.abc import Sequence

from rclpy.node import Node

from rodless_base.one_line import listed
from rodless_base.ros.publish import UNKNOWN, nodes

WAY_OUT = (
    "probably from a process of another account, which shares no memory with this one; start all "
    "of them with FASTDDS_BUILTIN_TRANSPORTS=UDPv4"
)


def has_unheard_publisher(observer: Node, topic: str) -> bool:
    """Whether a node publishes ``topic`` whose name has not arrived, which takes a moment."""
    return UNKNOWN in nodes(observer.get_publishers_info_by_topic(topic)).values()


def has_only_unheard_publishers(observer: Node, topic: str) -> bool:
    """Whether ``topic`` is published, and all who do are such nodes."""
    found = nodes(observer.get_publishers_info_by_topic(topic)).values()
    return bool(found) and set(found) == {UNKNOWN}


def unheard_text(topics: Sequence[str]) -> str:
    """Say so of ``topics``, and the way out."""
    return f"{listed(topics)}: published, but nothing arrives, {WAY_OUT}"
