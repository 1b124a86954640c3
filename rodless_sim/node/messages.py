"""What the plant's instruments read as ROS messages; pure functions."""

from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.constants import CARRIAGE, SPOOL
from rodless_base.measurement import Measurement
from rodless_base.ros.topics import set_stamp
from rodless_base.topics import PRESSURES
from rodless_sim.physics.valve import spool_displacement

# The frame of each pressure, by field of Measurement: the place that its topic names.
PRESSURE_FRAMES = {field: topic.partition("/")[0] for field, topic in PRESSURES.items()}

# Uncompiled: compiling it would hold up the first sample that somebody records.
_displacement = getattr(spool_displacement, "py_func", spool_displacement)


def clock(nanoseconds: int) -> Clock:
    """Plant time (ns) as a clock message."""
    message = Clock()
    set_stamp(message.clock, nanoseconds)
    return message


def joint_state(
    measurement: Measurement, velocity: float, piston_area: float, joint: str = CARRIAGE
) -> JointState:
    """Position (m), velocity (m/s) and pneumatic force (N) of the carriage, as ``joint``.

    The force is A (P_a - P_b) of the pressures read. The velocity is the true one: nothing on the
    rig measures it.
    """
    force = piston_area * (measurement.pressure_a - measurement.pressure_b)
    # Fields one by one: what is given to the constructor replaces a default made for nothing.
    message = JointState()
    set_stamp(message.header.stamp, measurement.stamp)
    message.name = [joint]
    message.position = [measurement.position]
    message.velocity = [velocity]
    message.effort = [force]
    return message


def valve_state(voltage: float, nanoseconds: int, joint: str = SPOOL) -> JointState:
    """What the valve held up to a sample: displacement of its spool (m), eq. (24), and voltage (V).

    The voltage stands in ``effort``: it is what drives the joint.
    """
    message = JointState()
    set_stamp(message.header.stamp, nanoseconds)
    message.name = [joint]
    message.position = [_displacement(voltage)]
    message.effort = [voltage]
    return message


def pressure(value: float, variance: float, frame: str, nanoseconds: int) -> FluidPressure:
    """Absolute pressure in Pa and its variance in Pa²; 0 is what the message defines as unknown."""
    message = FluidPressure(fluid_pressure=value, variance=variance)
    set_stamp(message.header.stamp, nanoseconds)
    message.header.frame_id = frame
    return message
