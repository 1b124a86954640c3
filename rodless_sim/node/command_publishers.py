# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who commands the valve."""

import math
import time
from collections.abc import Callable

from rclpy.node import Node

from rodless_base.ros.publish import UNKNOWN, nodes

# After how many s to ask again, though the count is what it was: one may have replaced another.
ASKING_PERIOD = 1.0


class CommandPublishers:
    """The publishers of commands, asked for as often as the plant polls."""

    def __init__(self, node: Node, topic: str, now: Callable[[], float] = time.monotonic) -> None:
        """Look on ``topic``, by its full name; ``now`` is a steady time in s."""
        self._node = node
        self._topic = topic
        self._now = now
        self._found: dict[bytes, str] = {}
        self._asked = -math.inf

    def __call__(self) -> dict[bytes, str]:
        """Return the nodes that publish commands, by what identifies the publisher."""
        # Counting costs a tenth of asking who they are.
        changed = self._node.count_publishers(self._topic) != len(self._found)
        late = self._now() - self._asked > ASKING_PERIOD
        if changed or late or UNKNOWN in self._found.values():
            self._found = nodes(self._node.get_publishers_info_by_topic(self._topic))
            self._asked = self._now()
        return self._found
