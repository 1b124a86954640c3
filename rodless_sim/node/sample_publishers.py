# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The topics of the plant's samples: who hears them, and what is sent on them."""

from functools import partial

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.constants import SPOOL
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.publish import OnDemand, Outbox
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, PRESSURE_FRAMES, PRESSURES, VALVE_STATE
from rodless_sim.node import messages
from rodless_sim.node.clock_publishers import ClockPublishers
from rodless_sim.node.fault_publisher import FaultPublisher
from rodless_sim.node.further_publishers import FurtherPublishers, joints
from rodless_sim.node.ready import all_listen
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.state import State, piston_of


class SamplePublishers:
    """Publishers of plant time, pressures, the valve's state and, last of each sample, the joint.

    All but the joint's are built and sent only while somebody listens.
    """

    def __init__(self, node: Node, values: RigParameters) -> None:
        """Make them; real time waits for nobody, lock-step loses nothing."""
        lockstep = values.in_lockstep
        publisher = partial(
            node.create_publisher, qos_profile=LOSSLESS if lockstep else QUEUE_DEPTH
        )
        # One for all: the messages of a sample keep their order, whatever holds one back.
        self.outbox = Outbox(node)
        self._joint_states = publisher(JointState, JOINT_STATES)
        self._faults = FaultPublisher(node, self.outbox)
        pressures = {
            field: OnDemand(
                publisher(FluidPressure, topic),
                messages.pressures(prefixed(values, PRESSURE_FRAMES[field])),
                self.outbox,
            )
            for field, topic in PRESSURES.items()
        }
        self._valve_state = OnDemand(
            publisher(JointState, VALVE_STATE),
            messages.valve_states(prefixed(values, SPOOL)),
            self.outbox,
        )
        self.clock = ClockPublishers(
            node,
            lambda topic: OnDemand(publisher(Clock, topic), messages.clock, self.outbox),
            bool(values["time.publish_clock"]),
        )
        self._joint_message = messages.joint_states(*joints(values))
        self._pressures = list(pressures.items())
        # Whose recorders the run waits for. Whoever lists topics need not know the valve's state.
        self._awaited = [*pressures.values(), *self.clock.awaited]
        self._further = FurtherPublishers(
            lambda kind, topic, pack: OnDemand(publisher(kind, topic), pack, self.outbox), values
        )
        self._others = [*self._further.publishers, self._valve_state, *self.clock.others]
        self._take(values)

    def _take(self, values: RigParameters) -> None:
        self._further.configure(values)
        self._piston_area = piston_area(values)
        self._variances = {field: pressure_variance(values, field) for field in PRESSURES}

    def configure(self, values: RigParameters, nanoseconds: int) -> None:
        """Publish with these parameters from a plant time (ns) on; topics do not change."""
        self._faults.publish(values, nanoseconds)
        self._take(values)

    @property
    def topic(self) -> str:
        """The full name of the topic that ends each sample."""
        return str(self._joint_states.topic_name)

    def listeners(self) -> int:
        """Count the subscribers of that topic."""
        return int(self._joint_states.get_subscription_count())

    def poll(self) -> None:
        """Look up the subscribers of all other topics."""
        for publisher in (*self._awaited, *self._others):
            publisher.poll()

    def all_listen(self, recorders: int) -> bool:
        """Poll; return whether so many recorders hear everything, and one more the samples."""
        listening = all_listen(self.listeners, self._awaited, recorders)
        # Last: whoever has subscribed to these before the samples has them from sample 0 on.
        for publisher in self._others:
            publisher.poll()
        return listening

    def publish(self, measurement: Measurement, state: State, true: Measurement) -> None:
        """Publish a sample: what the instruments read, and what only the true state has."""
        time = measurement.stamp
        self.clock.publish(time)
        self._further.publish(measurement, state, true)
        for field, publisher in self._pressures:
            publisher.publish(getattr(measurement, field), self._variances[field], time)
        self._valve_state.publish(state.spool_voltage, state.voltage, time)
        message = self._joint_message(
            measurement, state.velocity, self._piston_area, *piston_of(state)
        )
        self.outbox.send(self._joint_states, message)


def pressure_variance(values: RigParameters, field: str) -> float:
    """Variance in Pa² of what differs from reading to reading; 0 for ideal instruments."""
    return values.number("sensors.pressure_noise") ** 2 + values.number(f"fault.{field}.noise") ** 2
