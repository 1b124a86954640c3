# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Publishers whose node's name does not arrive, as those of another account."""

from types import SimpleNamespace
from typing import Any

from rodless_base.ros.lasting_topics import LOOKS, LOOKS_AT_THE_END
from rodless_base.ros.unheard import unheard_topics


class Graph:
    """What a node knows of publishers: the names of their nodes, by topic."""

    def __init__(self, names: dict[str, list[str]]) -> None:
        """Begin with those."""
        self.names = names

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        """Return endpoints as rclpy does, each with a name that may be unknown."""
        return [
            SimpleNamespace(node_name=name, node_namespace="/", endpoint_gid=[number])
            for number, name in enumerate(self.names[topic])
        ]


def test_a_topic_is_unheard_where_a_name_does_not_come_for_a_while() -> None:
    """Not at once, since names take a moment; once; and not where the names are known."""
    unknown = "_NODE_NAME_UNKNOWN_"
    graph = Graph({"/late": [unknown], "/lost": ["plant", unknown], "/known": ["plant"]})
    unheard = unheard_topics(graph)  # type: ignore[arg-type]
    looks = []
    for look in range(3 * LOOKS):
        if look == LOOKS - 1:
            graph.names["/late"] = ["plant"]
        looks.append(unheard.look(["/late", "/lost", "/known"]))
    assert [place for place, found in enumerate(looks) if found] == [LOOKS - 1]
    assert looks[LOOKS - 1] == unheard.found == ["/lost"]


def test_where_no_time_is_left_fewer_looks_have_to_do() -> None:
    """A recording that is stopped early says so as well, once, but not of a name a look old."""
    unheard = unheard_topics(Graph({"/lost": ["_NODE_NAME_UNKNOWN_"]}))  # type: ignore[arg-type]
    assert unheard.look(["/lost"], LOOKS_AT_THE_END) == []
    assert unheard.look(["/lost"], LOOKS_AT_THE_END) == ["/lost"]
    assert [unheard.look(["/lost"]) for _ in range(LOOKS)] == [[]] * LOOKS
