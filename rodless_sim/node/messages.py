"""What the plant's instruments read as ROS messages; pure functions."""

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from rodless_base.ros.topics import NANOSECONDS
from rodless_sim.rig import State

JOINT = "carriage"


def stamp(nanoseconds: int) -> Time:
    """Plant time (ns) as a ROS time."""
    return Time(sec=nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


def clock(nanoseconds: int) -> Clock:
    """Plant time (ns) as a clock message."""
    return Clock(clock=stamp(nanoseconds))


def joint_state(state: State, nanoseconds: int) -> JointState:
    """Position (m), velocity (m/s) and pneumatic force (N) of the carriage."""
    return JointState(
        header=Header(stamp=stamp(nanoseconds)),
        name=[JOINT],
        position=[state.position],
        velocity=[state.velocity],
        effort=[state.force],
    )


def pressure(value: float, variance: float, frame: str, nanoseconds: int) -> FluidPressure:
    """Absolute pressure in Pa and its variance in Pa²; 0 is what the message defines as unknown."""
    header = Header(stamp=stamp(nanoseconds), frame_id=frame)
    return FluidPressure(header=header, fluid_pressure=value, variance=variance)
