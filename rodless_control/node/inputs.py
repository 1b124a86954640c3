# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The controller node's subscriptions: positions, and pressures of the same stamp where wanted."""

from collections.abc import Callable

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.measurement import Measurement
from rodless_base.one_line import described
from rodless_base.parameters import ParameterError
from rodless_base.ros.message_info import Info, with_info
from rodless_base.ros.readings import PositionReader, PressureReader, Reading
from rodless_base.ros.topics import QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, PRESSURES
from rodless_control.stamp_synchronizer import StampSynchronizer


class Inputs:
    """Subscriptions that end in one call of ``take`` per complete measurement."""

    def __init__(
        self,
        node: Node,
        pressures: bool,
        joint: Callable[[], str],
        take: Callable[..., None],
    ) -> None:
        """Prepare; ``joint`` tells the joint's name.

        ``take`` gets a measurement, and the information of the message that completed it.
        """
        self._node = node
        self._joint = joint
        self._take = take
        self._pressures: dict[str, Subscription | None] = {}
        self._position_reader = PositionReader()
        self._incomplete = 0
        self.without_joint = 0
        self.subscribed = False
        self._expect(pressures)

    def _expect(self, pressures: bool) -> None:
        self._pressures = dict.fromkeys(PRESSURES if pressures else ())
        self._synchronizer = StampSynchronizer(["position", *self._pressures], QUEUE_DEPTH)

    @property
    def incomplete(self) -> int:
        """Samples dropped because a message of theirs never came."""
        return self._incomplete + self._synchronizer.incomplete

    def use_pressures(self, pressures: bool) -> None:
        """Complete measurements by pressures from now on, or by none.

        What was sent before it was subscribed to never comes: a lock-step plant, which waits for an
        answer, offers that sample again. Raises ParameterError where pressures cannot be subscribed
        to.
        """
        if pressures == bool(self._pressures):
            return
        self._incomplete = self.incomplete
        for subscription in filter(None, self._pressures.values()):
            self._node.destroy_subscription(subscription)
        self._expect(pressures)
        if self.subscribed:
            self._subscribe_to_pressures()

    def subscribe(self) -> None:
        """Subscribe, to positions last: a plant that starts with them has then seen the others."""
        self._subscribe_to_pressures()
        self._node.create_subscription(
            JointState, JOINT_STATES, with_info(self._take_joint), QUEUE_DEPTH, raw=True
        )
        self.subscribed = True

    def _subscribe_to_pressures(self) -> None:
        for field, subscription in self._pressures.items():
            if subscription is None:
                self._pressures[field] = self._subscription(PRESSURES[field], field)

    def _subscription(self, topic: str, field: str) -> Subscription:
        taker = self._pressure_taker(field)
        try:
            return self._node.create_subscription(
                FluidPressure, topic, taker, QUEUE_DEPTH, raw=True
            )
        except rclpy_implementation.RCLError as error:  # such as by a security policy
            raise ParameterError(f"{topic} cannot be subscribed to: {described(error)}") from error

    def _pressure_taker(self, field: str) -> Callable[..., None]:
        reader = PressureReader()

        def take(message: bytes, info: Info) -> None:
            reading = reader.read(message)
            # Without a reading the sample stays incomplete, and is counted as that. What was on its
            # way when pressures were given up is nobody's.
            if reading is not None and field in self._pressures:
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
