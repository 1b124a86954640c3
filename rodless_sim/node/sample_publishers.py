# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The topics of the plant's samples: who hears them, and what is sent on them."""

from collections.abc import Callable
from functools import partial

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from rodless_base.measurement import Measurement
from rodless_base.ros.publish import OnDemand, Outbox, wait_for_readers
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES
from rodless_sim.node import messages
from rodless_sim.node.clock_publishers import ClockPublishers
from rodless_sim.node.fault_publisher import FaultPublisher
from rodless_sim.node.further_publishers import FurtherPublishers, joints
from rodless_sim.node.reading_publishers import ReadingPublishers
from rodless_sim.node.ready import all_listen
from rodless_sim.node.throttled_samples import ThrottledSamples
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
        self._faults = FaultPublisher(node, self.outbox)

        def make(kind: type, topic: str, pack: Callable[..., bytes]) -> OnDemand:
            return OnDemand(publisher(kind, topic), pack, self.outbox)

        # Before the samples themselves: who finds those finds these.
        self._throttled = ThrottledSamples(node, values)
        self._joint_states = publisher(JointState, JOINT_STATES)
        self._readings = ReadingPublishers(make, values)
        self.clock = ClockPublishers(
            node,
            lambda topic: make(Clock, topic, messages.clock),
            bool(values["time.publish_clock"]),
        )
        self._joint_message = messages.joint_states(*joints(values))
        # Whose recorders the run waits for. Whoever lists topics need not know the valve's state.
        self._awaited = [*self._readings.pressures.values(), *self.clock.awaited]
        self._further = FurtherPublishers(make, values)
        self._others = [
            *self._further.publishers,
            self._readings.valve_state,
            *self.clock.others,
        ]
        self._take(values)

    def _take(self, values: RigParameters) -> None:
        for publishers in (self._further, self._readings, self._throttled):
            publishers.configure(values)
        self._piston_area = piston_area(values)

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
        """Look up the subscribers of all other topics; show the last sample to who looks on."""
        for publisher in (*self._awaited, *self._others):
            publisher.poll()
        self._throttled.poll()

    def all_listen(self, recorders: int) -> bool:
        """Poll; return whether so many recorders hear everything, and one more the samples."""
        listening = all_listen(self.listeners, self._awaited, recorders)
        # Last: whoever has subscribed to these before the samples has them from sample 0 on.
        for publisher in self._others:
            publisher.poll()
        return listening

    def wait_for_readers(self, deadline: float) -> bool:
        """Give whoever reads the samples time for what is on its way; return whether it has come.

        To be called before the node ends; ``deadline`` is in s, monotonic.
        """
        heard = [one.publisher for one in (*self._awaited, *self._others) if one.subscribers]
        return wait_for_readers(self.outbox, [*heard, self._joint_states], deadline)

    def publish(
        self, measurement: Measurement, state: State, truth: Callable[[], Measurement]
    ) -> None:
        """Publish a sample: what the instruments read, and what only the true state has."""
        self.clock.publish(measurement.stamp)
        self._further.publish(measurement, state, truth)
        self._readings.publish(measurement, state)
        self._throttled.take(measurement, state)
        message = self._joint_message(
            measurement, state.velocity, self._piston_area, *piston_of(state)
        )
        self.outbox.send(self._joint_states, message)
