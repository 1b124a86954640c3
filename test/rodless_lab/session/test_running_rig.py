# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A node that is known but silent, and one that is only elsewhere, are told apart."""

from collections.abc import Iterator
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from quiet_stop import Quiet
from rclpy.node import Node

from rodless_base.ros.diagnostics import NAMESAKES, diagnostics_publisher
from rodless_lab.session import running_rig
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.running_rig import SILENT, RigError, RunningRig


@pytest.fixture(autouse=True)
def silent_plant(observer: Observer) -> Iterator[None]:
    """Run a node of the plant's name in /here that publishes nothing."""
    node = Node("plant", namespace="here", context=observer.context, use_global_arguments=False)
    yield
    node.destroy_node()


def test_a_silent_node_is_said_to_be_there() -> None:
    """It needs no other namespace: its own is not offered."""
    with RunningRig("here", Quiet()) as rig:
        rig.wait_for_node("plant", 30.0)
        assert rig.unreported("plant", 2.0) == (
            "the plant is there but has published nothing on /diagnostics within 2 s"
        )
        assert "--namespace" in rig.unreported("controller", 2.0)
        assert "the plant is there, so it was not started, compiles still, has" in rig.missing(
            "controller", 2.0
        )
        assert "there is one in" not in rig.missing("plant", 2.0)


def test_a_node_elsewhere_is_offered() -> None:
    """By the namespace to choose."""
    with RunningRig("/there/", Quiet()) as rig:
        assert rig.namespace == "/there"
        assert rig.wait_for(lambda: "there is one in /here:" in rig.unreported("plant", 2.0), 30.0)


def test_a_node_that_reports_no_more_is_silent(observer: Observer) -> None:
    """What it said last is not taken for its state: it was killed, or is frozen."""
    publisher = diagnostics_publisher(observer.node)
    said = DiagnosticStatus(level=DiagnosticStatus.WARN, name="/here/plant", message="paused")
    with RunningRig("here", Quiet()) as rig:
        assert rig.is_silent("plant")
        assert rig.wait_for(publisher.get_subscription_count, 30.0)
        publisher.publish(DiagnosticArray(status=[said]))
        assert rig.wait_for(lambda: rig.diagnostic("plant"), 30.0)
        assert rig.state_of("plant") == "paused"
        assert rig.obstacles() == ["plant: paused", f"controller: {SILENT['controller']}"]
        assert rig.wait_for(lambda: rig.is_silent("plant"), 30.0)
        assert rig.state_of("plant") == SILENT["plant"]
        assert rig.obstacles()[0] == f"plant: {SILENT['plant']}"
    observer.node.destroy_publisher(publisher)


@pytest.mark.parametrize("count", ["many", "", "-3", "2.7", "1_0", "1e300", "９", "9" * 50])
def test_a_count_of_namesakes_that_is_none_is_not_believed(observer: Observer, count: str) -> None:
    """Whatever a node writes there, the rig is found."""
    publisher = diagnostics_publisher(observer.node)
    values = [KeyValue(key=NAMESAKES, value=count)]
    said = DiagnosticStatus(name="/here/plant", message="running", values=values)
    with RunningRig("here", Quiet()) as rig:
        rig.wait_for_node("plant", 30.0)
        assert rig.wait_for(publisher.get_subscription_count, 30.0)
        publisher.publish(DiagnosticArray(status=[said]))
        assert rig.wait_for(lambda: rig.diagnostic("plant"), 30.0)
        assert rig.namesakes("plant") is None
    observer.node.destroy_publisher(publisher)


def test_two_nodes_of_one_name_are_refused(observer: Observer) -> None:
    """With the way out; a node of another name or namespace is none."""
    with RunningRig("here", Quiet()) as rig:
        rig.wait_for_node("plant", 30.0)
        rig.check_alone()
        options = {"context": observer.context, "use_global_arguments": False}
        twin = Node("plant", namespace="here", **options)
        elsewhere = Node("plant", namespace="there", **options)
        try:
            assert rig.wait_for(lambda: rig.namesakes("plant"), 30.0)
            text = "2 nodes named plant in namespace /here of ROS domain .*: stop all but one"
            with pytest.raises(RigError, match=text):
                rig.check_alone()
            assert rig.namesakes("controller") is None
        finally:
            twin.destroy_node()
            elsewhere.destroy_node()


def test_nodes_that_report_their_namesakes_are_believed(
    observer: Observer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both have said that they are alone: nobody is waited for. One that is not alone is refused.

    Of one node alone nothing follows: the other may have a namesake.
    """
    monkeypatch.setattr(running_rig, "DISCOVERY", 600.0)
    publisher = diagnostics_publisher(observer.node)

    def report(node: str, count: int) -> None:
        values = [KeyValue(key="nodes of this name", value=str(count))]
        status = DiagnosticStatus(name=f"/here/{node}", values=values)
        said = DiagnosticArray(status=[status])
        rig.observer.forget_diagnostic(node)

        def heard() -> bool:
            # Until the rig's own subscription is known here, what is published is lost.
            publisher.publish(said)
            last = rig.diagnostic(node)
            return last is not None and last.values == {"nodes of this name": str(count)}

        assert rig.wait_for(heard, 30.0)

    with RunningRig("here", Quiet()) as rig:
        assert rig.wait_for(publisher.get_subscription_count, 30.0)
        report("plant", 1)
        assert not rig._namesakes_are_known()
        report("controller", 1)
        rig.check_alone()
        report("plant", 2)
        with pytest.raises(RigError, match="2 nodes named plant in namespace /here"):
            rig.check_alone()
    observer.node.destroy_publisher(publisher)


@pytest.mark.ros
def test_a_plant_of_which_nothing_arrives_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """No rig is started beside it, and nobody is told to start one; one whose name is known is."""
    names = ["_NODE_NAME_UNKNOWN_"]
    publisher = SimpleNamespace(node_namespace="/", endpoint_gid=[0])

    def publishers(_node: Node, topic: str) -> list[SimpleNamespace]:
        assert topic == "/there/joint_states"
        return [SimpleNamespace(node_name=name, **vars(publisher)) for name in names]

    monkeypatch.setattr(Node, "get_publishers_info_by_topic", publishers)
    monkeypatch.setattr(running_rig, "DISCOVERY", 0.1)
    monkeypatch.setattr(running_rig, "NAME_TIMEOUT", 0.1)
    # Others of this file have killed nodes, which their domain knows for a while.
    with own_domain() as own:
        for name, value in own.items():
            monkeypatch.setenv(name, value)
        with RunningRig("there", Quiet()) as rig:
            with pytest.raises(RigError, match=r"^a plant runs already .* of which nothing arr"):
                rig.check_free(["plant"])
            assert rig.missing("plant", 1.0).endswith("with FASTDDS_BUILTIN_TRANSPORTS=UDPv4")
            names[:] = ["plant"]
            rig.check_free(["plant"])
            assert "start a rig with" in rig.missing("plant", 1.0)
