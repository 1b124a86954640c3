# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""References as messages: set-points, streams of commands, and whole trajectories."""

import math
from collections.abc import Callable

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.one_line import listed
from rodless_base.parameters import ParameterError
from rodless_base.ros.topics import stamp_nanoseconds
from rodless_base.topics import JOINT_COMMANDS, SETPOINT
from rodless_control.setpoint import SetpointFollower
from rodless_control.trajectory import Waypoint

TRAJECTORY = "~/joint_trajectory"

# What could be said of every message, at the rate of a control loop, is said once in this time (s).
# Diagnostics count all that is refused.
LOG_PERIOD = 1.0


class ReferenceInputs:
    """Subscriptions to ``setpoint``, ``joint_commands`` and ``~/joint_trajectory``.

    What is wrong is counted in ``refused``, said in one line, once a second at most, and changes
    nothing.
    """

    def __init__(
        self,
        node: Node,
        setpoints: SetpointFollower,
        joint: Callable[[], str],
        obstacle: Callable[[], str | None],
    ) -> None:
        """Subscribe for ``setpoints``; ``joint`` tells the name of the joint that is controlled.

        ``obstacle`` says why the controller does not control until it is enabled anew, if so.
        """
        self._logger = node.get_logger()
        self._setpoints = setpoints
        self._joint = joint
        self._obstacle = obstacle
        self.refused = 0
        setpoint = node.create_subscription(Float64, SETPOINT, self._take_setpoint, 10)
        self.setpoint_topic = str(setpoint.topic_name)
        node.create_subscription(JointState, JOINT_COMMANDS, self._take_command, 10)
        node.create_subscription(JointTrajectory, TRAJECTORY, self._take_trajectory, 10)

    def _take_setpoint(self, message: Float64) -> None:
        try:
            self._check_enabled("set-point")
            self._setpoints.receive(message.data)
        except ParameterError as error:
            self.refused += 1
            self._logger.warning(str(error), throttle_duration_sec=LOG_PERIOD)

    def _take_command(self, message: JointState) -> None:
        try:
            command = position_and_velocity(message, self._joint())
            if command is not None:
                self._check_enabled("command")
                self._setpoints.receive_command(*command)
        except ParameterError as error:
            self.refused += 1
            self._logger.warning(str(error), throttle_duration_sec=LOG_PERIOD)

    def _take_trajectory(self, message: JointTrajectory) -> None:
        try:
            self._check_enabled("trajectory")
            points = waypoints(message, self._joint())
            stamp = stamp_nanoseconds(message.header.stamp)
            start = stamp / NANOSECONDS_PER_SECOND if stamp else None
            self._setpoints.receive_trajectory(points, start)
        except ParameterError as error:
            self.refused += 1
            self._logger.warning(str(error), throttle_duration_sec=LOG_PERIOD)
        else:
            when = "now" if start is None else f"{start:g} s"
            self._logger.info(
                f"trajectory: {len(points)} points, from {when} on, {points[-1].time:g} s long",
                throttle_duration_sec=LOG_PERIOD,
            )

    def _check_enabled(self, what: str) -> None:
        """Raise ParameterError for what would be forgotten as the controller is switched on."""
        obstacle = self._obstacle()
        if obstacle is not None:
            raise ParameterError(f"{what}: ignored, {obstacle}; ~/enable it first")


def position_and_velocity(message: JointState, joint: str) -> tuple[float, float] | None:
    """Return position (m) and velocity (m/s) commanded to ``joint``; without a velocity it is 0.

    None where the position is NaN: what ros2_control sends for an interface that no controller
    has claimed. Raises ParameterError for a message that does not command the joint's position.
    """
    names = list(message.name)
    if joint not in names:
        raise ParameterError(
            f"command: refused, it names the joints {listed(names) or '(none)'}, not {joint}"
        )
    if names.count(joint) > 1:
        raise ParameterError(f"command: refused, it names {joint} {names.count(joint)} times")
    place = names.index(joint)
    for field, needed in (("position", True), ("velocity", False)):
        count = len(getattr(message, field))
        if count != len(names) and (needed or count):
            raise ParameterError(
                f"command: refused, {count} values of {field} for {len(names)} joints"
            )
    position = float(message.position[place])
    if math.isnan(position):
        return None
    velocity = float(message.velocity[place]) if message.velocity else 0.0
    return position, (0.0 if math.isnan(velocity) else velocity)


def waypoints(message: JointTrajectory, joint: str) -> tuple[Waypoint, ...]:
    """Return the points of a trajectory of ``joint`` alone, times in s from its start.

    Raises ParameterError for other joints, and for points without a position or with an effort.
    """
    names = list(message.joint_names)
    if names != [joint]:
        raise ParameterError(
            f"trajectory: refused, it is for the joints {listed(names) or '(none)'}, "
            f"this controller has {joint}"
        )
    return tuple(_waypoint(point, number) for number, point in enumerate(message.points, 1))


def _waypoint(point: JointTrajectoryPoint, number: int) -> Waypoint:
    found = {
        name: list(getattr(point, name))
        for name in ("positions", "velocities", "accelerations", "effort")
    }
    for name, values in found.items():
        if len(values) > 1 or (name == "positions" and not values) or (name == "effort" and values):
            wanted = {"positions": "1", "effort": "none"}.get(name, "1 or none")
            raise ParameterError(
                f"trajectory: refused, point {number}: {len(values)} {name}, must be {wanted}"
            )
    return Waypoint(
        _seconds(point.time_from_start),
        found["positions"][0],
        *(found[name][0] if found[name] else None for name in ("velocities", "accelerations")),
    )


def _seconds(duration: Duration) -> float:
    return float(duration.sec + duration.nanosec / NANOSECONDS_PER_SECOND)
