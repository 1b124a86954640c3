"""What the plant's instruments read as ROS messages; pure functions."""

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from rodless_base.constants import CARRIAGE, NANOSECONDS_PER_SECOND
from rodless_base.measurement import Measurement
from rodless_base.topics import PRESSURES

# The frame of each pressure, by field of Measurement: the place that its topic names.
PRESSURE_FRAMES = {field: topic.partition("/")[0] for field, topic in PRESSURES.items()}


def stamp(nanoseconds: int) -> Time:
    """Plant time (ns) as a ROS time."""
    return Time(
        sec=nanoseconds // NANOSECONDS_PER_SECOND, nanosec=nanoseconds % NANOSECONDS_PER_SECOND
    )


def clock(nanoseconds: int) -> Clock:
    """Plant time (ns) as a clock message."""
    return Clock(clock=stamp(nanoseconds))


def joint_state(
    measurement: Measurement, velocity: float, piston_area: float, joint: str = CARRIAGE
) -> JointState:
    """Position (m), velocity (m/s) and pneumatic force (N) of the carriage, as ``joint``.

    The force is A (P_a - P_b) of the pressures read. The velocity is the true one: nothing on the
    rig measures it.
    """
    force = piston_area * (measurement.pressure_a - measurement.pressure_b)
    return JointState(
        header=Header(stamp=stamp(measurement.stamp)),
        name=[joint],
        position=[measurement.position],
        velocity=[velocity],
        effort=[force],
    )


def pressure(value: float, variance: float, frame: str, nanoseconds: int) -> FluidPressure:
    """Absolute pressure in Pa and its variance in Pa²; 0 is what the message defines as unknown."""
    header = Header(stamp=stamp(nanoseconds), frame_id=frame)
    return FluidPressure(header=header, fluid_pressure=value, variance=variance)
