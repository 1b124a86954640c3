# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Quality of service: what publishers offer, as a bag records it, and what to ask them for."""

from collections.abc import Mapping, Sequence

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from rodless_base.constants import NANOSECONDS_PER_SECOND

# What is offered where nothing is said of it, by rclpy as by `ros2 topic pub`.
USUAL_OFFER = QoSProfile(depth=10)

# Messages of a topic that wait while the disk is busy: ten seconds at 1 kHz.
DEPTH = 10_000


def recorded_profile(offered: QoSProfile) -> Mapping[str, object]:
    """Return an offered profile in the words and order of rosbag2."""
    return {
        "history": offered.history.name.lower(),
        "depth": offered.depth,
        "reliability": offered.reliability.name.lower(),
        "durability": offered.durability.name.lower(),
        "deadline": _duration(offered.deadline),
        "lifespan": _duration(offered.lifespan),
        "liveliness": offered.liveliness.name.lower(),
        "liveliness_lease_duration": _duration(offered.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": offered.avoid_ros_namespace_conventions,
    }


def _duration(duration: Duration) -> Mapping[str, int]:
    seconds, nanoseconds = divmod(duration.nanoseconds, NANOSECONDS_PER_SECOND)
    return {"sec": seconds, "nsec": nanoseconds}


def matching_profile(offers: Sequence[QoSProfile]) -> QoSProfile:
    """Return the strictest profile that matches all of ``offers``, with a queue that drops nothing.

    Latched messages come only when every publisher latches, and none is lost on the way only
    when every publisher is reliable; asking for more would shut one of them out.
    """
    reliable = all(offer.reliability == ReliabilityPolicy.RELIABLE for offer in offers)
    latched = all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
    return QoSProfile(
        # A lock-step plant waits for a recorder whose queue is full; one that dropped messages
        # would not hold it back.
        history=HistoryPolicy.KEEP_ALL if reliable else HistoryPolicy.KEEP_LAST,
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
