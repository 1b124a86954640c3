# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Names of the rig's topics; queues and stamps are in :mod:`rodless_base.ros.topics`."""

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"
VALVE_STATE = "valve/state"
FAULTS = "faults"
SETPOINT = "setpoint"
JOINT_COMMANDS = "joint_commands"

# Plant time: where ROS nodes look for theirs, and of one rig, the same topic without a namespace.
ROS_CLOCK = "/clock"
RIG_CLOCK = "clock"

# Where each node of ROS tells of its parameters.
PARAMETER_EVENTS = "/parameter_events"

# Of the controller, as seen from beside it.
REFERENCE = "controller/reference"
JOINT_TRAJECTORY = "controller/joint_trajectory"

# What somebody sends who comes for it and goes again.
SENT_IN_PASSING = (SETPOINT, JOINT_COMMANDS, JOINT_TRAJECTORY)

# By field of Measurement, in the order they are published in, before joint_states.
PRESSURES = {
    "pressure_a": "chamber_a/pressure",
    "pressure_b": "chamber_b/pressure",
    "supply_pressure": "supply/pressure",
}

# The frame of each: the place that its topic names.
PRESSURE_FRAMES = {field: topic.partition("/")[0] for field, topic in PRESSURES.items()}

# What a plant publishes whose chambers have temperatures, by field of its state; in °C.
TEMPERATURES = {
    "temperature_a": "chamber_a/temperature",
    "temperature_b": "chamber_b/temperature",
}

# Before the name of a topic: its last message, some 50 times a second, for whoever only looks on.
# Hidden, as ROS has it: neither `ros2 topic list` nor `ros2 bag record --all` knows them.
THROTTLED = "_throttled/"

# What the plant publishes where it is asked to: what is true, and the voltages of the instruments.
TRUTH = "truth/"
RAW_VOLTAGES = "raw/voltages"
FURTHER_TOPICS = (
    RAW_VOLTAGES,
    f"{TRUTH}{JOINT_STATES}",
    *(f"{TRUTH}{topic}" for topic in PRESSURES.values()),
)

# What not every rig publishes.
OPTIONAL_TOPICS = (*TEMPERATURES.values(), *FURTHER_TOPICS)

# What a bag of the rig holds. A plant waits for recorders of the other topics, not for one of the
# faults or the valve's state: subscribed to first, they are heard by then.
RIG_TOPICS = (FAULTS, VALVE_STATE, JOINT_STATES, *PRESSURES.values(), VALVE_VOLTAGE, SETPOINT)
