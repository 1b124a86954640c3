# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session takes the carriage's columns by the joint's name, wherever it stands in the message."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.topics import JOINT_STATES, PRESSURES
from rodless_lab.session.receiver import Receiver
from rodless_lab.session.samples import Cursor, LostSampleError, Sample


class StandInObserver:
    """Keeps the callbacks of subscriptions."""

    diagnostics: object = None

    def __init__(self) -> None:
        self.callbacks: dict[str, Callable[..., None]] = {}

    def subscribe(
        self, _kind: type, topic: str, callback: Callable[..., None], **_options: bool
    ) -> SimpleNamespace:
        """As the observer does."""
        self.callbacks[topic] = callback
        return SimpleNamespace(get_publisher_count=lambda: topic != "controller/force")


def put(observer: StandInObserver, topic: str, message: Any) -> None:
    """Let a message come."""
    observer.callbacks[topic](message, {"source_timestamp": 5})


def test_the_carriage_is_found_by_its_name() -> None:
    """A second joint before it changes nothing, and a message without it is no sample."""
    observer = StandInObserver()
    receiver = Receiver(observer)
    receiver.listen_to_the_rest(())
    for topic, pressure in zip(PRESSURES.values(), (1.0, 2.0, 3.0), strict=True):
        put(observer, topic, FluidPressure(fluid_pressure=pressure))
    other = JointState(name=["gripper"], position=[9.0], velocity=[9.0], effort=[9.0])
    put(observer, JOINT_STATES, other)
    assert receiver.received.runs == 0
    both = JointState(
        name=["gripper", "carriage"], position=[9.0, 0.05], velocity=[9.0, 0.4], effort=[9.0, 7.0]
    )
    put(observer, JOINT_STATES, both)
    assert receiver.received.sample(0, 0) == Sample(0.0, 0.05, 0.4, 7.0, 1.0, 2.0, 3.0)


def test_a_message_of_somebody_else_makes_no_sample() -> None:
    """One that lacks numbers is left out; one with a stamp of its own tears the run: it is told."""
    observer = StandInObserver()
    receiver = Receiver(observer)  # type: ignore[arg-type]
    receiver.listen_to_the_rest(())
    for topic in PRESSURES.values():
        put(observer, topic, FluidPressure(fluid_pressure=4e5))
    put(observer, JOINT_STATES, JointState(name=["carriage"], position=[0.15]))
    assert receiver.received.runs == 0
    alien = JointState(name=["carriage"], position=[0.15], velocity=[0.0], effort=[0.0])
    alien.header.stamp.sec = 1000
    put(observer, JOINT_STATES, alien)
    with pytest.raises(LostSampleError, match="does somebody else publish on the plant's topics"):
        Cursor(receiver.received).next()


def test_what_is_matched_is_told_by_topic() -> None:
    """So that a wait can name the topic that does not come."""
    heard = Receiver(StandInObserver()).listen_to_the_rest(("reference", "force"))
    assert [topic for topic, matched in heard.items() if not matched()] == ["controller/force"]
    assert {"controller/reference", JOINT_STATES, *PRESSURES.values()} < set(heard)
