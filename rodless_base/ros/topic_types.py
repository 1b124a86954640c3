# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The types of the rig's topics, and which of them can have one name."""

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.parameters import ParameterError
from rodless_base.topics import (
    JOINT_COMMANDS,
    JOINT_STATES,
    PRESSURES,
    ROS_CLOCK,
    SETPOINT,
    VALVE_STATE,
    VALVE_VOLTAGE,
)

TYPES: dict[str, type] = {
    **dict.fromkeys((JOINT_STATES, VALVE_STATE, JOINT_COMMANDS), JointState),
    **dict.fromkeys(PRESSURES.values(), FluidPressure),
    **dict.fromkeys((VALVE_VOLTAGE, SETPOINT), Float64),
    ROS_CLOCK: Clock,
}

# States of different joints, which say whose they are.
TOGETHER = {JOINT_STATES, VALVE_STATE}


def check_topic_types(node: Node) -> None:
    """Raise ParameterError where topics are remapped to one name that must not be one.

    Of two types the middleware says so in many lines, and of a topic that is subscribed to late not
    at all. Of one type, what is said on one would be taken for the other.
    """
    known: dict[str, str] = {}
    for topic, kind in TYPES.items():
        name = node.resolve_topic_name(topic)
        other = known.setdefault(name, topic)
        if TYPES[other] is not kind:
            clash = f"with two types, {kind.__name__} and {TYPES[other].__name__}"
        elif other != topic and {other, topic} != TOGETHER:
            clash = "so that one is taken for the other"
        else:
            continue
        raise ParameterError(
            f"{topic} and {other} are one name, {name}, {clash}: remap one of them elsewhere"
        )
