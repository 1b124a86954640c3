# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""Whoever only looks on has some samples, as they are, and costs the nodes next to nothing."""

from collections.abc import Iterator
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import QoSProfile
from running import StartRig
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

from rodless_base.ros.topics import set_stamp, stamp_nanoseconds
from rodless_base.topics import THROTTLED
from rodless_lab.session.observer import Observer
from rodless_lab.view.ros.live import LiveRig
from rodless_lab.view.samples import Mark, value
from rodless_lab.view.state import ViewState


@pytest.fixture(scope="module", autouse=True)
def rig(start_rig: StartRig) -> Iterator[None]:
    """Run a rig at 1 kHz."""
    with start_rig():
        yield


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("joint_states", JointState),
        ("chamber_a/pressure", FluidPressure),
        ("supply/pressure", FluidPressure),
        ("valve/state", JointState),
    ],
)
def test_a_few_samples_as_the_topic_itself_has_them(
    observer: Observer, topic: str, kind: type
) -> None:
    """Every message is that of its stamp on the topic itself, and most of those are left out."""
    observer.publisher(Float64, "/setpoint").publish(Float64(data=0.03))
    every: list[Any] = observer.collect(kind, f"/{topic}")
    observer.more(every, 1)
    some: list[Any] = observer.collect(kind, f"/{THROTTLED}{topic}")
    observer.more(some, 30)
    last = stamp_nanoseconds(some[29].header.stamp)
    observer.wait(lambda: stamp_nanoseconds(every[-1].header.stamp) >= last, "the same on both")
    full = {stamp_nanoseconds(message.header.stamp): message for message in every}
    stamps = [stamp_nanoseconds(message.header.stamp) for message in some[:30]]
    assert stamps == sorted(set(stamps))
    assert [full[stamp] for stamp in stamps] == some[:30]
    left_out = [stamp for stamp in full if stamps[0] < stamp < last and stamp not in stamps]
    assert len(left_out) > 5 * len(stamps)


def test_terms_of_the_law_come_throttled_too(observer: Observer) -> None:
    """The reference under the controller's own name, at the set-point in the end."""
    observer.publisher(Float64, "/setpoint").publish(Float64(data=0.04))
    found = observer.collect(Float64, f"/{THROTTLED}controller/reference")
    observer.wait(lambda: found and found[-1].data == 0.04, "the set-point")


def test_whoever_comes_in_a_pause_is_shown_where_the_rig_stands(observer: Observer) -> None:
    """The last sample and the last reference, once; a second reader has them, too."""
    every = observer.collect(JointState, "/joint_states")
    observer.more(every, 1)
    wanted = observer.collect(Float64, "/controller/reference")
    observer.more(wanted, 1)
    assert observer.call(SetBool, "/plant/pause", data=True).success
    try:
        for _ in range(2):
            some = observer.collect(JointState, f"/{THROTTLED}joint_states")
            observer.more(some, 1)
            observer.wait(lambda some=some: every[-1] == some[-1], "the last sample on both")
            reference = observer.collect(Float64, f"/{THROTTLED}controller/reference")
            observer.more(reference, 1)
            assert reference[-1] == wanted[-1]
    finally:
        assert observer.call(SetBool, "/plant/pause", data=False).success


def readers(observer: Observer, topic: str) -> set[str]:
    """The names of the nodes that subscribe."""
    return {info.node_name for info in observer.node.get_subscriptions_info_by_topic(topic)}


def test_a_view_reads_what_is_throttled_alone(observer: Observer) -> None:
    """The view has rows of the rig, and the controller is the only reader of all samples."""
    state = ViewState()
    with LiveRig(observer.context, state):
        observer.wait(lambda: state.terms and _whole(state), "a row with everything")
        assert "view" in readers(observer, f"/{THROTTLED}joint_states")
        for topic in ("/joint_states", "/valve/state", "/chamber_a/pressure"):
            assert "view" not in readers(observer, topic)
        observer.wait(lambda: len(state.history.since(Mark()).rows) > 40, "further rows")


def _whole(state: ViewState) -> bool:
    row = state.history.last
    return row is not None and None not in (*row[:9], *row[-len(state.terms) :])


def test_a_view_of_a_rig_without_throttled_topics_reads_the_topics(observer: Observer) -> None:
    """Of a driver of a real rig, which publishes joint_states alone; and of a plant after it."""
    state = ViewState("/real")
    driver = Node("driver", context=observer.context, namespace="/real")
    positions = driver.create_publisher(JointState, "joint_states", 10)
    throttled = None
    stamp = 0

    def send(publisher: Any, position: float) -> None:
        nonlocal stamp
        stamp += 1_000_000
        message = JointState(name=["carriage"], position=[position])
        set_stamp(message.header.stamp, stamp)
        publisher.publish(message)

    def shown(position: float) -> bool:
        send(throttled or positions, position)
        row = state.history.last
        return row is not None and value(row, "position") == position

    try:
        with LiveRig(observer.context, state):
            observer.wait(lambda: shown(0.05), "what the driver says")
            throttled = driver.create_publisher(
                JointState, f"{THROTTLED}joint_states", QoSProfile(depth=1)
            )
            observer.wait(lambda: shown(0.07), "what is throttled")
            assert readers(observer, "/real/joint_states") == set()
    finally:
        driver.destroy_node()
