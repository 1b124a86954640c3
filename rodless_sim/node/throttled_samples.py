# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The last sample, some 50 times a second, for whoever only looks on.

A reader of every sample costs the plant at 1 kHz several per cent of a core; a few dozen samples a
second are all that a picture shows.
"""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import JointState

from rodless_base.measurement import Measurement
from rodless_base.ros.publish import OnDemand, Outbox, Throttled
from rodless_base.ros.topics import LAST_ONE
from rodless_base.topics import JOINT_STATES, THROTTLED
from rodless_sim.node import messages
from rodless_sim.node.further_publishers import joints
from rodless_sim.node.reading_publishers import ReadingPublishers
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.state import State, piston_of


class ThrottledSamples:
    """Publishers of what the plant publishes with each sample, its last values at each poll."""

    def __init__(self, node: Node, values: RigParameters) -> None:
        """Make them."""
        self._outbox = Outbox(node)

        def make(kind: type, topic: str, pack: Callable[..., bytes]) -> OnDemand:
            publisher = node.create_publisher(kind, THROTTLED + topic, LAST_ONE)
            return OnDemand(publisher, pack, self._outbox)

        self._readings = ReadingPublishers(make, values)
        self._joint = make(JointState, JOINT_STATES, messages.joint_states(*joints(values)))
        self._publishers = (*self._readings.publishers, self._joint)
        self._throttled = Throttled[tuple[Measurement, State]](self._outbox)
        self.configure(values)

    def configure(self, values: RigParameters) -> None:
        """Publish with these parameters from now on."""
        self._readings.configure(values)
        self._piston_area = piston_area(values)

    def take(self, measurement: Measurement, state: State) -> None:
        """Take a sample in place of the last."""
        self._throttled.last = measurement, state

    def poll(self) -> None:
        """Look up who looks on, and publish the last sample unless they have it."""
        due = self._throttled.due(self._publishers)
        if due is None:
            return
        measurement, state = due
        self._readings.publish(measurement, state)
        self._joint.publish(measurement, state.velocity, self._piston_area, *piston_of(state))
