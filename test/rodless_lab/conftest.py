# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A small bag to read, damage and compare, and a DDS domain of one's own."""

from dataclasses import dataclass
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header

from rodless_lab.bags.metadata import BagTopic
from rodless_lab.bags.writer import BagWriter

PERIOD = 1_000_000
QOS = {
    "history": "keep_last",
    "depth": 7,
    "reliability": "best_effort",
    "durability": "transient_local",
    "deadline": {"sec": 9223372036, "nsec": 854775807},
    "lifespan": {"sec": 1, "nsec": 5},
    "liveliness": "automatic",
    "liveliness_lease_duration": {"sec": 9223372036, "nsec": 854775807},
    "avoid_ros_namespace_conventions": False,
}
TOPICS = (
    BagTopic("/joint_states", "sensor_msgs/msg/JointState", qos=(QOS, QOS)),
    BagTopic("/valve/voltage", "std_msgs/msg/Float64", qos=(QOS,)),
    BagTopic("/silent", "std_msgs/msg/Float64"),
)


@dataclass(frozen=True)
class SampleBag:
    """A bag and what was put into it: by topic, log time (ns) and payload of each message."""

    path: Path
    messages: dict[str, list[tuple[int, bytes]]]


def joint_state(k: int) -> bytes:
    """Sample ``k`` in CDR."""
    stamp = Time(sec=k * PERIOD // 10**9, nanosec=k * PERIOD % 10**9)
    return serialize_message(
        JointState(
            header=Header(stamp=stamp),
            name=["carriage"],
            position=[1e-6 * k],
            velocity=[0.5],
            effort=[0.0],
        )
    )


def write_sample_bag(path: Path, count: int = 300, flush_every: int = 50) -> SampleBag:
    """Write ``count`` samples and as many voltages."""
    messages: dict[str, list[tuple[int, bytes]]] = {topic.name: [] for topic in TOPICS}
    with BagWriter(path) as writer:
        for topic in TOPICS:
            writer.add_topic(topic)
        for k in range(count):
            for topic, data in (
                ("/joint_states", joint_state(k)),
                ("/valve/voltage", serialize_message(Float64(data=0.1 * k))),
            ):
                writer.write(topic, data, k * PERIOD, k * PERIOD + 3, k)
                messages[topic].append((k * PERIOD, data))
            if k % flush_every == 0:
                writer.flush()
    assert writer.failure is None
    return SampleBag(path, messages)


@pytest.fixture
def sample_bag(tmp_path: Path) -> SampleBag:
    """Return a bag of three topics, one of them silent."""
    return write_sample_bag(tmp_path / "sample")
