# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Listens to a rig for a session, in the order that its nodes need to start together."""

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.constants import CARRIAGE
from rodless_base.frames import joint_among
from rodless_base.ros.joint import carriage_position
from rodless_base.ros.message_info import Info, take_waiting
from rodless_base.ros.topics import stamp_nanoseconds
from rodless_base.topics import JOINT_STATES, PRESSURES, VALVE_VOLTAGE
from rodless_lab.session.lag import LagWatch
from rodless_lab.session.observer import Observer
from rodless_lab.session.samples import Received, Stamped, Unstamped


class Receiver:
    """What an observer has received of plant and controller."""

    def __init__(self, observer: Observer) -> None:
        """Listen to nothing yet."""
        self._observer = observer
        self.received = Received()
        self.lag = LagWatch()
        self._subscriptions: list[Subscription] = []

    def listen_to_answers(self, topic: str) -> Callable[[], bool]:
        """Take what the controller publishes on ``topic``; return whether it is matched."""
        answers = self._listen_to(topic, self.received.answers)
        if topic == VALVE_VOLTAGE:
            self.received.voltage = self.received.answers
        else:
            self._listen_to(VALVE_VOLTAGE, self.received.voltage)
        return lambda: bool(answers.get_publisher_count())

    def listen_to_the_rest(self, terms: Sequence[str]) -> dict[str, Callable[[], int]]:
        """Take the plant and these terms of the controller; return what is matched, by topic.

        The order matters: nodes learn of subscriptions in the order they are made in, and the
        plant starts with the last of its own.
        """
        heard = {}
        for term in terms:
            messages = self.received.terms.setdefault(term, [])
            heard[f"controller/{term}"] = self._listen_to(f"controller/{term}", messages)
        _ = self._observer.diagnostics  # subscribes
        for topic, received in zip(PRESSURES.values(), self.received.pressures, strict=True):
            heard[topic] = self._take(FluidPressure, topic, received.put)
        # The plant also waits for a listener to /clock.
        self._subscribe(Clock, "/clock", _ignore, raw=True)
        heard[JOINT_STATES] = self._take(JointState, JOINT_STATES, self.received.joint.put)
        return {topic: subscription.get_publisher_count for topic, subscription in heard.items()}

    def take_waiting(self, until: int) -> None:
        """Take what has come up to what was sent at ``until`` (ns, wall clock)."""
        for subscription in self._subscriptions:
            take_waiting(subscription, until)

    def stand_in_for_a_controller(self) -> None:
        """Be the further subscriber of ``joint_states`` that the plant waits for."""
        self._subscribe(JointState, JOINT_STATES, _ignore, raw=True)

    def _listen_to(self, topic: str, messages: list[Unstamped]) -> Subscription:
        def take(message: Float64, info: Info) -> None:
            messages.append(Unstamped(info["source_timestamp"], message.data))

        return self._subscribe(Float64, topic, take, info=True)

    def _take(self, kind: type, topic: str, put: Callable[[Stamped], None]) -> Subscription:
        def take(message: Any, info: Info) -> None:
            if kind is JointState and not _is_whole(message):
                return
            if kind is JointState:
                self.lag.take(info["source_timestamp"])
            stamp = stamp_nanoseconds(message.header.stamp)
            put(Stamped(info["source_timestamp"], stamp, _content(message)))

        return self._subscribe(kind, topic, take, info=True)

    def _subscribe(
        self, kind: type, topic: str, take: Callable[..., None], **options: bool
    ) -> Subscription:
        subscription = self._observer.subscribe(kind, topic, take, **options)
        self._subscriptions.append(subscription)
        return subscription


def _ignore(_message: bytes) -> None:
    """Take a message for nothing."""


def _is_whole(message: JointState) -> bool:
    """Whether it has all that a plant says of its carriage: others may publish there too."""
    count = len(message.name)
    whole = len(message.velocity) == len(message.effort) == count
    return whole and carriage_position(message) is not None


def _content(message: Any) -> tuple[float, ...]:
    if isinstance(message, FluidPressure):
        return (message.fluid_pressure,)
    place = message.name.index(joint_among(CARRIAGE, message.name))
    return (message.position[place], message.velocity[place], message.effort[place])
