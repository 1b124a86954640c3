# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Nodes of one full name: two rigs that were given the same, or one that was started twice."""

from rclpy.node import Node

# What else a node that is in the way may be: DDS keeps those that ended without a word for so long.
KILLED = "(one that was killed is forgotten within 20 s)"


class Namesakes:
    """How many nodes have the full name of ``node``, itself included."""

    def __init__(self, node: Node) -> None:
        """Know of nobody else."""
        self._node = node
        self.count = 1
        self.problem: str | None = None

    def check(self) -> None:
        """Count them anew; a :attr:`problem` is logged once. To be called with each report."""
        before = self.problem
        name, namespace = self._node.get_name(), self._node.get_namespace()
        self.count = max(count_nodes(self._node, name, namespace), 1)
        domain = self._node.context.get_domain_id()
        self.problem = namesakes_text(self.count, name, namespace, domain)
        if self.problem is not None and before is None:
            self._node.get_logger().warning(self.problem)


def count_nodes(observer: Node, name: str, namespace: str) -> int:
    """Return how many nodes of a name ``observer`` knows in ``namespace``."""
    return int(observer.get_node_names_and_namespaces().count((name, namespace)))


def namesakes_text(count: int, name: str, namespace: str, domain: int) -> str | None:
    """Say that ``count`` nodes have one name, and the way out; None where it is not several."""
    if count <= 1:
        return None
    return (
        f"{count} nodes named {name} in namespace {namespace} of ROS domain {domain}: "
        f"stop all but one, or give each rig its own --namespace {KILLED}"
    )
