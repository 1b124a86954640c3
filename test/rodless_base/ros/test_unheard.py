# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Publishers whose node's name does not arrive, as those of another account."""

from functools import partial
from types import SimpleNamespace
from typing import Any

from rodless_base.ros.lasting_topics import DURATION, DURATION_AT_THE_END, LastingTopics
from rodless_base.ros.unheard import has_only_unheard_publishers, has_unheard_publisher


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
    now = [0.0]
    unheard = LastingTopics(
        partial(has_unheard_publisher, graph),  # type: ignore[arg-type]
        lambda: now[0],
    )
    looks = {}
    while now[0] < 3.0 * DURATION:
        if now[0] == DURATION - 1.0:
            graph.names["/late"] = ["plant"]
        looks[now[0]] = unheard.look(["/late", "/lost", "/known"])
        now[0] += 1.0
    assert [when for when, found in looks.items() if found] == [DURATION]
    assert looks[DURATION] == unheard.found == ["/lost"]


def test_where_no_time_is_left_less_has_to_do() -> None:
    """A recording that is stopped early says so as well, once, but not of a name just come."""
    now = [0.0]
    unheard = LastingTopics(lambda _: True, lambda: now[0])
    assert unheard.look(["/lost"], DURATION_AT_THE_END) == []
    now[0] += 0.5 * DURATION_AT_THE_END
    assert unheard.look(["/lost"], DURATION_AT_THE_END) == []
    now[0] += 0.5 * DURATION_AT_THE_END
    assert unheard.look(["/lost"], DURATION_AT_THE_END) == ["/lost"]
    now[0] += 2.0 * DURATION
    assert unheard.look(["/lost"]) == []


def test_of_several_publishers_all_must_be_unheard_where_nothing_can_be_heard_yet() -> None:
    """One of a known node may be the one that is waited for."""
    unknown = "_NODE_NAME_UNKNOWN_"
    graph: Any = Graph({"/both": ["plant", unknown], "/lost": [unknown, unknown], "/none": []})
    found = {topic: has_only_unheard_publishers(graph, topic) for topic in graph.names}
    assert found == {"/both": False, "/lost": True, "/none": False}
