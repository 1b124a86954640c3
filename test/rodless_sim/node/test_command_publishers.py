# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who commands the valve is known, and asked for no oftener than needed."""

from types import SimpleNamespace

from rodless_sim.node.command_publishers import ASKING_PERIOD, CommandPublishers


class Graph:
    """What a node says of the publishers ``there``, by their identity; it counts the questions."""

    def __init__(self) -> None:
        self.there = {b"1": "controller"}
        self.asked = 0

    def count_publishers(self, _topic: str) -> int:
        """As of rclpy's node."""
        return len(self.there)

    def get_publishers_info_by_topic(self, _topic: str) -> list[SimpleNamespace]:
        """As of rclpy's node."""
        self.asked += 1
        return [
            SimpleNamespace(endpoint_gid=gid, node_namespace="/", node_name=name)
            for gid, name in self.there.items()
        ]


def test_a_publisher_in_place_of_another_is_seen_within_a_second() -> None:
    """Their number has not changed."""
    graph, clock = Graph(), [0.0]
    commanders = CommandPublishers(graph, "/valve/voltage", lambda: clock[0])  # type: ignore[arg-type]
    assert commanders() == {b"1": "/controller"}
    graph.there = {b"2": "mine"}
    clock[0] += 1.01 * ASKING_PERIOD
    assert commanders() == {b"2": "/mine"}


def test_nobody_is_asked_between_unless_their_number_changes_or_a_name_is_lacking() -> None:
    """Asking at each of the plant's looks would cost its time."""
    graph = Graph()
    commanders = CommandPublishers(graph, "/valve/voltage", lambda: 0.0)  # type: ignore[arg-type]
    for _ in range(9):
        commanders()
    assert graph.asked == 1
    graph.there[b"2"] = "_NODE_NAME_UNKNOWN_"
    commanders()
    graph.there[b"2"] = "mine"
    assert commanders() == {b"1": "/controller", b"2": "/mine"}
    commanders()
    assert graph.asked == 3
