# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who publishes plant time where: `/clock` belongs to one publisher, `clock` to each rig."""

from collections.abc import Callable

from rclpy.node import Node

from rodless_base.ros.publish import OnDemand
from rodless_base.topics import RIG_CLOCK, ROS_CLOCK

# Checks in a row that find nobody on /clock before that is said: discovery may take 3 s.
UNHEARD_CHECKS = 5


class ClockPublishers:
    """Plant time on ``/clock``, where it may, and in a namespace on a topic of the rig's own.

    Nodes remapped from ``/clock`` to ``clock`` then live on their own rig's time, however many
    rigs there are. Two publishers on ``/clock`` would let time jump to and fro for everybody else;
    that is a :attr:`problem`.
    """

    def __init__(
        self, node: Node, publisher: Callable[[str], OnDemand], on_ros_clock: bool
    ) -> None:
        """Make them by ``publisher(topic)``; ``on_ros_clock``: on ``/clock`` too."""
        self._node = node
        self._ros_clock = node.resolve_topic_name(ROS_CLOCK)
        self._rig_clock = node.resolve_topic_name(RIG_CLOCK)
        topics = {self._ros_clock: on_ros_clock, self._rig_clock: on_ros_clock}
        if self._rig_clock != self._ros_clock:
            topics[self._rig_clock] = True
        self._publishers = {topic: publisher(topic) for topic, wanted in topics.items() if wanted}
        self._said: str | None = None
        self._unheard = 0
        self.problem: str | None = None

    @property
    def awaited(self) -> list[OnDemand]:
        """Those that recorders are waited for on; a rig's own clock need not be recorded."""
        return [one for topic, one in self._publishers.items() if topic == self._ros_clock]

    @property
    def others(self) -> list[OnDemand]:
        """Those that nobody waits for."""
        return [one for topic, one in self._publishers.items() if topic != self._ros_clock]

    def publish(self, nanoseconds: int) -> None:
        """Publish plant time (ns)."""
        for one in self._publishers.values():
            one.publish(nanoseconds)

    def check(self) -> None:
        """Look for other publishers on ``/clock``, and for those who wait for one in vain.

        To be called once a second; what is found is logged once.
        """
        self.problem = self._conflict()
        found = self.problem or self._nobody()
        if found is not None and found != self._said:
            self._node.get_logger().warning(found)
        self._said = found

    def _conflict(self) -> str | None:
        count = int(self._node.count_publishers(self._ros_clock))
        if self._ros_clock not in self._publishers or count < 2:
            return None
        return (
            f"{count} publishers on {self._ros_clock}, time jumps for who listens: set "
            "time.publish_clock to false (publish_clock:=false, rodless rig --no-clock) on all "
            "rigs but one"
        )

    def _nobody(self) -> str | None:
        waiting = self._node.count_subscribers(self._ros_clock)
        in_vain = waiting and not self._node.count_publishers(self._ros_clock)
        self._unheard = self._unheard + 1 if in_vain else 0
        if self._unheard < UNHEARD_CHECKS:
            return None
        remapping = (
            f", or remap {self._ros_clock} to {self._rig_clock} in the nodes of this rig"
            if self._rig_clock in self._publishers
            else ""
        )
        return (
            f"nodes wait for {self._ros_clock} and nobody publishes it: set time.publish_clock to "
            f"true (publish_clock:=true) on one rig{remapping}"
        )
