# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The file that makes `ros2 bag record` lose nothing: config/rosbag2/lossless.yaml."""

from pathlib import Path

import yaml
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.topics import (
    FURTHER_TOPICS,
    JOINT_STATES,
    PRESSURES,
    REFERENCE,
    ROS_CLOCK,
    VALVE_STATE,
    VALVE_VOLTAGE,
)
from rodless_control.laws import LAWS, law_class

PROFILES = yaml.safe_load(
    Path(__file__).parents[3].joinpath("config/rosbag2/lossless.yaml").read_text()
)


def test_it_names_what_is_sent_with_every_sample() -> None:
    """Time, measurements, truth, commands and the terms of each law: no more and no less."""
    relative = [JOINT_STATES, *PRESSURES.values(), VALVE_STATE, VALVE_VOLTAGE, *FURTHER_TOPICS]
    terms = {f"controller/{term}" for law in LAWS for term in law_class(law).TERMS}
    assert set(PROFILES) == {ROS_CLOCK, *(f"/{name}" for name in {*relative, REFERENCE, *terms})}


def test_its_queues_hold_everything_and_match_what_the_nodes_offer() -> None:
    """Read as ros2bag reads it: it drops nothing, in lock-step and in real time."""
    for name, profile in PROFILES.items():
        wanted = QoSProfile(
            history=HistoryPolicy.get_from_short_key(profile["history"]),
            reliability=ReliabilityPolicy.get_from_short_key(profile["reliability"]),
            durability=DurabilityPolicy.get_from_short_key(profile["durability"]),
        )
        assert wanted.history == HistoryPolicy.KEEP_ALL, name
        assert wanted.reliability == ReliabilityPolicy.RELIABLE, name
        for offered in (LOSSLESS, QoSProfile(depth=QUEUE_DEPTH)):
            compatible, reason = qos_check_compatible(offered, wanted)
            assert compatible != QoSCompatibility.ERROR, f"{name}: {reason}"
