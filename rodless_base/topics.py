"""Names of the rig's topics; queues and stamps are in :mod:`rodless_base.ros.topics`."""

JOINT_STATES = "joint_states"
VALVE_VOLTAGE = "valve/voltage"
SETPOINT = "setpoint"

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

# What a bag of the rig holds.
RIG_TOPICS = (JOINT_STATES, *PRESSURES.values(), VALVE_VOLTAGE, SETPOINT)
