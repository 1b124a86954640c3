# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The controller node's subscriptions: positions, and pressures of the same stamp where wanted."""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.measurement import Measurement
from rodless_base.ros.message_info import Info, with_info
from rodless_base.ros.readings import PositionReader, PressureReader, Reading
from rodless_base.ros.topics import QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, PRESSURES
from rodless_control.stamp_synchronizer import StampSynchronizer


class Inputs:
    """Subscriptions that end in one call of ``take`` per complete measurement."""

    def __init__(
        self, node: Node, pressures: bool, joint: Callable[[], str], take: Callable[..., None]
    ) -> None:
        """Prepare; ``joint`` tells the joint's name.

        ``take`` gets a measurement, and the information of the message that completed it.
        """
        self._node = node
        self._joint = joint
        self._take = take
        self._pressures = PRESSURES if pressures else {}
        self._synchronizer = StampSynchronizer(["position", *self._pressures], QUEUE_DEPTH)
        self._position_reader = PositionReader()
        self.without_joint = 0
        self.subscribed = False

    @property
    def incomplete(self) -> int:
        """Samples dropped because a message of theirs never came."""
        return self._synchronizer.incomplete

    def subscribe(self) -> None:
        """Subscribe, to positions last: a plant that starts with them has then seen the others."""
        self.subscribed = True
        for field, topic in self._pressures.items():
            self._node.create_subscription(
                FluidPressure, topic, self._pressure_taker(field), QUEUE_DEPTH, raw=True
            )
        self._node.create_subscription(
            JointState, JOINT_STATES, with_info(self._take_joint), QUEUE_DEPTH, raw=True
        )

    def _pressure_taker(self, field: str) -> Callable[..., None]:
        reader = PressureReader()

        def take(message: bytes, info: Info) -> None:
            reading = reader.read(message)
            if reading is not None:  # else the sample stays incomplete, and is counted as that
                self._put(field, reading, info)

        return with_info(take)

    def _take_joint(self, message: bytes, info: Info) -> None:
        """Take the carriage's position; a message without it counts as no sample at all."""
        position = self._position_reader.read(message, self._joint())
        if position is None:
            self.without_joint += 1
        elif self._pressures:
            self._put("position", position, info)
        else:
            self._take(Measurement(*position), info)

    def _put(self, field: str, reading: Reading, info: Info) -> None:
        measurement: Measurement | None = self._synchronizer.put(field, *reading)
        if measurement is not None:
            self._take(measurement, info)
