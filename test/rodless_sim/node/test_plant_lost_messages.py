"""What a stopped subscriber has missed shows in the plant's diagnostics."""

import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context

from rodless_base.ros import publish
from rodless_base.ros.process import make_executor, spin
from rodless_base.start import Stop
from rodless_lab.session.observer import Observer
from rodless_sim.node import plant_node

LOST = "messages lost to a stopped subscriber"


@pytest.fixture
def context(domain: dict[str, str]) -> Iterator[Context]:  # noqa: ARG001  sets the environment
    """Return a context of the test's own."""
    own = Context()
    rclpy.init(context=own)
    yield own
    rclpy.try_shutdown(context=own)


def test_lost_messages_are_a_fault(
    observer: Observer, context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are counted, of all topics, and the warning stays."""
    monkeypatch.setattr(publish, "QUEUE_DEPTH", 0)
    monkeypatch.setattr(publish, "_is_published", lambda *_: False)
    plant = plant_node.PlantNode(context=context)
    executor = make_executor(context)
    executor.add_node(plant.node)
    stop = cast(Stop, SimpleNamespace(requested=False))
    spinning = threading.Thread(target=spin, args=(executor, stop), daemon=True)
    spinning.start()
    try:
        observer.wait(lambda: plant._publishers.outbox.lost > 10, "messages")
        before = plant._publishers.outbox.lost
        status = observer.diagnostic("/plant", fresh=True)
        assert before <= observer.counter("/plant", LOST) <= plant._publishers.outbox.lost
        assert status.level == DiagnosticStatus.WARN
        assert LOST in status.message
    finally:
        stop.requested = True
        spinning.join(10.0)
        plant.close()
