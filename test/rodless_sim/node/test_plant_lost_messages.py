# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a stopped subscriber has missed shows in the plant's diagnostics."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import cast

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.context import Context
from sensor_msgs.msg import JointState

from rodless_base.ros import publish
from rodless_base.ros.process import make_executor, spin
from rodless_base.ros.topics import stamp_nanoseconds
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


@contextmanager
def running_plant(context: Context) -> Iterator[plant_node.PlantNode]:
    """Run a plant in real time, in the test's own process."""
    plant = plant_node.PlantNode(context=context)
    executor = make_executor(context)
    executor.add_node(plant.node)
    stop = cast(Stop, SimpleNamespace(requested=False))
    spinning = threading.Thread(target=spin, args=(executor, stop), daemon=True)
    spinning.start()
    try:
        yield plant
    finally:
        stop.requested = True
        spinning.join(10.0)
        plant.close()


def test_lost_messages_are_a_fault(
    observer: Observer, context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are counted, of all topics, and the warning stays."""
    monkeypatch.setattr(publish, "QUEUE_DEPTH", 0)
    monkeypatch.setattr(publish, "_is_published", lambda *_: False)
    with running_plant(context) as plant:
        outbox = plant._publishers.outbox
        observer.wait(lambda: outbox.lost > 10, "messages")
        before = outbox.lost
        status = observer.diagnostic("/plant", fresh=True)
        assert before <= observer.counter("/plant", LOST) <= outbox.lost
        assert status.level == DiagnosticStatus.WARN
        assert LOST in status.message


def test_a_message_that_cannot_be_sent_does_not_silence_a_plant_in_real_time(
    observer: Observer, context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The middleware refuses ten messages; they and those after them come, in order, none lost."""
    real, refusals = publish._is_published, iter(range(10))
    samples: list[JointState] = []
    observer.subscribe(JointState, "/joint_states", samples.append)
    monkeypatch.setattr(
        publish, "_is_published", lambda *message: next(refusals, None) is None and real(*message)
    )
    with running_plant(context) as plant:
        observer.wait(lambda: len(samples) > 100, "samples")
        assert next(refusals, None) is None, "all refusals have happened"
        assert plant._publishers.outbox.lost == 0
    stamps = [stamp_nanoseconds(sample.header.stamp) for sample in samples]
    assert stamps == list(range(stamps[0], stamps[0] + 1_000_000 * len(stamps), 1_000_000))


def test_ticks_of_a_paused_plant_push_no_sample_out_of_what_waits(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While a reader has stopped reading none is added; before and after, time is shown."""
    plant = plant_node.PlantNode(context=context)
    ticks: list[int] = []
    outbox = plant._publishers.outbox
    try:
        with monkeypatch.context() as patch:
            patch.setattr(plant._publishers.clock, "publish", ticks.append)
            plant._time.pause(True)
            plant._poll()
            assert len(ticks) == 1
            patch.setattr(publish, "_is_published", lambda *_: False)
            outbox.send(plant._publishers.clock, JointState())
            plant._poll()
            assert len(ticks) == 1
            patch.setattr(publish, "_is_published", lambda *_: True)
            outbox.flush()
            plant._poll()
            assert len(ticks) == 2
    finally:
        plant.close()
