# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether one node commands the valve, or several."""

from rclpy.node import Node

from rodless_base.ros.namesakes import KILLED
from rodless_base.ros.publish import nodes


class Rivals:
    """Nodes that publish commands beside each other."""

    def __init__(self, node: Node, topic: str) -> None:
        """Look on ``topic``, by its full name."""
        self._node = node
        self._topic = topic
        self._was_there = False
        self.problem: str | None = None

    def check(self) -> None:
        """Look anew; a :attr:`problem` is logged once. To be called with each report.

        It must be there twice to begin with: the name of a node that has just come is not known at
        once. A node that was started again is not its own rival.
        """
        found = rivals_text(publishers_of(self._node, self._topic))
        if found is not None and self._was_there:
            if self.problem is None:
                self._node.get_logger().warning(found)
            self.problem = found
        elif found is None:
            self.problem = None
        self._was_there = found is not None

    @property
    def everybody(self) -> str:
        """The nodes that publish commands, by their full names; "nobody" where none does."""
        found = set(nodes(self._node.get_publishers_info_by_topic(self._topic)).values())
        return ", ".join(sorted(found)) or "nobody"


def publishers_of(node: Node, topic: str) -> set[str]:
    """Return the nodes that publish on ``topic``, where there is more than one publisher."""
    if node.count_publishers(topic) <= 1:
        return set()
    return set(nodes(node.get_publishers_info_by_topic(topic)).values())


def rivals_text(names: set[str]) -> str | None:
    """Say that several nodes command, and the way out; None where it is not several."""
    if len(names) <= 1:
        return None
    return (
        f"{len(names)} nodes publish on valve/voltage ({', '.join(sorted(names))}), the valve "
        f"follows whichever came last: stop all but one {KILLED}"
    )
