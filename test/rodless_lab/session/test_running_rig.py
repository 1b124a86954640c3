"""A node that is known but silent, and one that is only elsewhere, are told apart."""

from collections.abc import Iterator

import pytest
from quiet_stop import Quiet
from rclpy.node import Node

from rodless_lab.session.observer import Observer
from rodless_lab.session.running_rig import RunningRig


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
        assert "there is one in" not in rig.missing("plant", 2.0)


def test_a_node_elsewhere_is_offered() -> None:
    """By the namespace to choose."""
    with RunningRig("/there/", Quiet()) as rig:
        assert rig.namespace == "/there"
        assert rig.wait_for(lambda: "there is one in /here:" in rig.unreported("plant", 2.0), 30.0)
