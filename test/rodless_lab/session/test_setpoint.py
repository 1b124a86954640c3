# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether a set-point would reach a controller, beside listeners that control nothing."""

from collections.abc import Iterator
from contextlib import contextmanager

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Float64

from rodless_lab.session.observer import Observer
from rodless_lab.session.setpoint import hears_all_setpoints, setpoint_is_heard


@contextmanager
def listener(observer: Observer, name: str, publishes: str = "", **qos: object) -> Iterator[None]:
    """Run a node that listens to set-points and may publish a topic."""
    node = Node(name, context=observer.context, use_global_arguments=False)
    node.create_subscription(Float64, "/setpoint", lambda _: None, QoSProfile(depth=1, **qos))
    if publishes:
        node.create_publisher(Float64, publishes, 1)
    try:
        yield
    finally:
        node.destroy_node()


def test_a_recorder_alone_hears_no_set_point_for_the_controller(observer: Observer) -> None:
    """Matched, it does not count; with a controller beside it, both must be matched."""
    publisher = observer.publisher(Float64, "/setpoint", subscribers=0)
    assert not setpoint_is_heard(observer.node, publisher)
    with listener(observer, "rosbag2_recorder", "/events/write_split"):
        observer.wait(publisher.get_subscription_count, "the recorder to be matched")
        observer.wait(
            lambda: observer.node.get_publishers_info_by_topic("/events/write_split"),
            "the recorder's own topic",
        )
        assert not setpoint_is_heard(observer.node, publisher)
        with listener(observer, "my_controller", "/valve/voltage"):
            observer.wait(lambda: setpoint_is_heard(observer.node, publisher), "the controller")
            assert publisher.get_subscription_count() == 2


def test_a_listener_that_cannot_be_matched_is_not_waited_for(observer: Observer) -> None:
    """One that wants earlier set-points too gets none from this publisher."""
    publisher = observer.publisher(Float64, "/setpoint", subscribers=0)
    late = {"durability": DurabilityPolicy.TRANSIENT_LOCAL}
    with (
        listener(observer, "my_controller", "/valve/voltage"),
        listener(observer, "archive", "/archive/state", **late),
    ):
        observer.wait(lambda: observer.node.count_subscribers("/setpoint") == 2, "both listeners")
        observer.wait(lambda: setpoint_is_heard(observer.node, publisher), "the controller")
        assert publisher.get_subscription_count() == 1


def test_a_sender_whom_no_controller_hears_is_not_waited_for(observer: Observer) -> None:
    """A best-effort one matches neither the controller nor who watches for set-points with it."""
    watch = observer.subscribe(Float64, "/wanted", lambda _: None)
    node = Node("sender", context=observer.context, use_global_arguments=False)
    try:
        node.create_publisher(Float64, "/wanted", qos_profile_sensor_data)
        observer.wait(lambda: observer.node.count_publishers("/wanted") == 1, "the sender")
        assert watch.get_publisher_count() == 0
        assert hears_all_setpoints(observer.node, watch)
        node.create_publisher(Float64, "/wanted", 1)
        observer.wait(lambda: observer.node.count_publishers("/wanted") == 2, "both senders")
        observer.wait(lambda: hears_all_setpoints(observer.node, watch), "the one that counts")
        assert watch.get_publisher_count() == 1
    finally:
        node.destroy_node()
