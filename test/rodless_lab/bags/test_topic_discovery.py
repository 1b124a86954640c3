# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which of the topics in the graph are recorded."""

from collections.abc import Sequence
from types import SimpleNamespace

from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_lab.bags.ros.topic_discovery import TopicDiscovery

NUMBER = "std_msgs/msg/Float64"


class Graph:
    """The part of a node that is looked at: topics with their types and publishing nodes.

    Nodes of ``listeners`` subscribe to a topic of each type.
    """

    def __init__(
        self, listeners: Sequence[str] = (), **topics: tuple[list[str], list[str]]
    ) -> None:
        self._topics = {f"/{name.replace('__', '/')}": topic for name, topic in topics.items()}
        self._listeners = listeners
        self.warnings: list[str] = []

    def get_name(self) -> str:
        """Name of the looking node."""
        return "recorder"

    def get_namespace(self) -> str:
        """All nodes here are in the root namespace."""
        return "/"

    def get_logger(self) -> SimpleNamespace:
        """Logger that keeps what it is told."""
        return SimpleNamespace(warning=self.warnings.append)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        """All topics."""
        return [(name, types) for name, (types, _) in self._topics.items()]

    def get_publishers_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        """Publishers by their node's name, of each type."""
        return self._ends(topic, self._topics[topic][1])

    def get_subscriptions_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        """Subscriptions likewise."""
        return self._ends(topic, self._listeners)

    def _ends(self, topic: str, nodes: Sequence[str]) -> list[SimpleNamespace]:
        qos = QoSProfile(depth=1)
        return [
            SimpleNamespace(node_name=node, node_namespace="/", topic_type=kind, qos_profile=qos)
            for node in nodes
            for kind in self._topics[topic][0]
        ]


def names(graph: Graph, wanted: Sequence[str], known: tuple[str, ...] = ()) -> list[str]:
    return [offer.topic for offer in TopicDiscovery(graph, wanted).new_offers(known)]


GRAPH = {
    "a": ([NUMBER], ["plant", "controller"]),
    "b": ([NUMBER], ["plant"]),
    "_hidden": ([NUMBER], ["plant"]),
    "own": ([NUMBER], ["recorder"]),
    "only_subscribed": ([NUMBER], []),
}


def test_every_topic_that_somebody_else_publishes_is_taken() -> None:
    """Without a list: all but hidden ones, the recorder's own, and those nobody publishes."""
    assert names(Graph(**GRAPH), []) == ["/a", "/b"]
    assert names(Graph(**GRAPH), [], known=("/a",)) == ["/b"]


def test_only_what_is_asked_for_is_taken() -> None:
    """With a list: those on it, hidden or not, in the order of the list."""
    assert names(Graph(**GRAPH), ["/b", "/_hidden", "/absent"]) == ["/b", "/_hidden"]
    assert names(Graph(**GRAPH), ["/_hidden", "/absent", "/b"]) == ["/_hidden", "/b"]


def test_an_offer_says_how_to_subscribe() -> None:
    """The class of the message and one profile for each publisher."""
    (offer,) = TopicDiscovery(Graph(a=GRAPH["a"]), []).new_offers(())
    assert (offer.type_name, offer.message_type, len(offer.profiles)) == (NUMBER, Float64, 2)


def test_topics_that_cannot_be_recorded_are_named_once() -> None:
    """Two types on one topic, and types that are not installed, are warned of, not taken."""
    graph = Graph(
        torn=([NUMBER, "std_msgs/msg/String"], ["plant"]),
        foreign=(["somebodys_msgs/msg/Thing"], ["plant"]),
        newer=(["std_msgs/msg/NotYetThere"], ["plant"]),
        good=([NUMBER], ["plant"]),
    )
    discovery = TopicDiscovery(graph, [])
    for _ in range(3):
        assert [offer.topic for offer in discovery.new_offers(())] == ["/good"]
    assert graph.warnings == [
        "/torn is not recorded: it has several types: std_msgs/msg/Float64, std_msgs/msg/String",
        "/foreign is not recorded: its type somebodys_msgs/msg/Thing is not installed",
        "/newer is not recorded: its type std_msgs/msg/NotYetThere is not installed",
    ]


def test_what_is_sent_in_passing_is_listened_to_before() -> None:
    """Set-points, commands and trajectories that somebody else waits for; not other topics."""
    topics = {"setpoint": ([NUMBER], []), "left__setpoint": ([NUMBER], []), "free": ([NUMBER], [])}
    graph = Graph(["controller"], **topics)
    offers = TopicDiscovery(graph, []).new_offers(())
    assert [(offer.topic, offer.type_name, offer.profiles) for offer in offers] == [
        ("/setpoint", NUMBER, []),
        ("/left/setpoint", NUMBER, []),
    ]
    assert names(graph, ["/left/setpoint"]) == ["/left/setpoint"]
    assert names(Graph(["recorder"], **topics), []) == []
    assert names(Graph(**topics), []) == []
    unclear = Graph(
        ["controller"],
        a__setpoint=([NUMBER, "std_msgs/msg/String"], []),
        b__setpoint=(["somebodys_msgs/msg/Thing"], []),
    )
    assert names(unclear, []) == unclear.warnings == []


def test_what_is_expected_comes_again_with_its_first_publisher() -> None:
    """Then with what that offers."""
    expected = ["/setpoint"]
    waiting = Graph(["controller"], setpoint=([NUMBER], []))
    assert TopicDiscovery(waiting, []).new_offers((), expected) == []
    published = Graph(["controller"], setpoint=([NUMBER], ["move"]))
    discovery = TopicDiscovery(published, [])
    (offer,) = discovery.new_offers((), expected)
    assert len(offer.profiles) == len(discovery.offered("/setpoint")) == 1
