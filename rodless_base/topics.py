"""Names of the rig's topics; queues and stamps are in :mod:`rodless_base.ros.topics`."""

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"
VALVE_STATE = "valve/state"
SETPOINT = "setpoint"
JOINT_COMMANDS = "joint_commands"

# Plant time: where ROS nodes look for theirs, and of one rig, the same topic without a namespace.
ROS_CLOCK = "/clock"
RIG_CLOCK = "clock"

# Of the controller, as seen from beside it.
REFERENCE = "controller/reference"

# By field of Measurement, in the order they are published in, before joint_states.
PRESSURES = {
    "pressure_a": "chamber_a/pressure",
    "pressure_b": "chamber_b/pressure",
    "supply_pressure": "supply/pressure",
}

# What a bag of the rig holds. A plant waits for recorders of the other topics, not for one of the
# valve's state: subscribed to first, that is heard by then.
RIG_TOPICS = (VALVE_STATE, JOINT_STATES, *PRESSURES.values(), VALVE_VOLTAGE, SETPOINT)
