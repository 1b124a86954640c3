# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the plant's instruments read as ROS messages; pure functions.

Each returns what makes messages of one layout, as :mod:`rodless_base.ros.cdr` has them.
"""

from collections.abc import Callable, Sequence

from rodless_base.constants import CARRIAGE, NANOSECONDS_PER_SECOND, SPOOL
from rodless_base.measurement import Measurement
from rodless_base.ros.cdr import Field, Layout
from rodless_sim.physics.valve import spool_displacement

# Uncompiled: compiling it would hold up the first sample that somebody records.
_displacement = getattr(spool_displacement, "py_func", spool_displacement)

ZERO_CELSIUS = 273.15  # K

_CLOCK = Layout(Field.STAMP)


def clock(nanoseconds: int) -> bytes:
    """Plant time (ns) as a rosgraph_msgs/Clock."""
    return _CLOCK.pack(*divmod(nanoseconds, NANOSECONDS_PER_SECOND))


def joint_states(joint: str = CARRIAGE, *others: str) -> Callable[..., bytes]:
    """Return what makes a sensor_msgs/JointState of a measurement, velocity and piston area.

    Position (m), velocity (m/s) and pneumatic force (N) of the carriage, as ``joint``. The force is
    A (P_a - P_b) of the pressures read. The velocity is the true one: nothing on the rig measures
    it. For each of the joints ``others`` a true position and velocity follow, and it has the same
    force.
    """
    count = 1 + len(others)
    numbers: tuple[Field | int, ...] = (count, *(Field.NUMBER for _ in range(count)))
    layout = Layout(Field.STAMP, "", count, joint, *others, *numbers, *numbers, *numbers)

    def pack(measurement: Measurement, velocity: float, piston_area: float, *true: float) -> bytes:
        force = piston_area * (measurement.pressure_a - measurement.pressure_b)
        stamp = divmod(measurement.stamp, NANOSECONDS_PER_SECOND)
        places, speeds = (measurement.position, *true[::2]), (velocity, *true[1::2])
        return layout.pack(*stamp, *places, *speeds, *(force for _ in places))

    return pack


def valve_states(joint: str = SPOOL) -> Callable[[float, float, int], bytes]:
    """Return what makes a sensor_msgs/JointState of the spool, a voltage (V) and plant time (ns).

    The true displacement of the spool (m) at a sample, eq. (24) of the voltage that would hold it
    there, and the command up to it. That stands in ``effort``: it is what drives the joint.
    """
    layout = Layout(Field.STAMP, "", 1, joint, 1, Field.NUMBER, 0, 1, Field.NUMBER)

    def pack(spool: float, voltage: float, nanoseconds: int) -> bytes:
        stamp = divmod(nanoseconds, NANOSECONDS_PER_SECOND)
        return layout.pack(*stamp, _displacement(spool), voltage)

    return pack


def voltages(channels: Sequence[str]) -> Callable[[Sequence[float], int], bytes]:
    """Return what makes a sensor_msgs/JointState of voltages by channel and plant time (ns).

    No message of ROS's own has a stamp and voltages; as in ``valve/state`` they are in ``effort``.
    """
    count = len(channels)
    layout = Layout(
        Field.STAMP, "", count, *channels, 0, 0, count, *(Field.NUMBER for _ in channels)
    )

    def pack(values: Sequence[float], nanoseconds: int) -> bytes:
        return layout.pack(*divmod(nanoseconds, NANOSECONDS_PER_SECOND), *values)

    return pack


def temperatures(frame: str) -> Callable[[float, int], bytes]:
    """Return what makes a sensor_msgs/Temperature of a temperature (K) and plant time (ns).

    The message has °C, by its definition. The variance is 0, unknown: nothing measures it.
    """
    layout = Layout(Field.STAMP, frame, Field.NUMBER, Field.NUMBER)

    def pack(value: float, nanoseconds: int) -> bytes:
        stamp = divmod(nanoseconds, NANOSECONDS_PER_SECOND)
        return layout.pack(*stamp, value - ZERO_CELSIUS, 0.0)

    return pack


def pressures(frame: str) -> Callable[[float, float, int], bytes]:
    """Return what makes a sensor_msgs/FluidPressure of pressure, variance and plant time (ns).

    The pressure is absolute, in Pa, its variance in Pa²; 0 is what the message defines as unknown.
    """
    layout = Layout(Field.STAMP, frame, Field.NUMBER, Field.NUMBER)

    def pack(value: float, variance: float, nanoseconds: int) -> bytes:
        stamp = divmod(nanoseconds, NANOSECONDS_PER_SECOND)
        return layout.pack(*stamp, value, variance)

    return pack
