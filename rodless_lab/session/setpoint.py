# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""When a set-point reaches the controller, whoever else listens to set-points."""

import warnings

from rclpy.duration import Duration
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.subscription import Subscription

from rodless_base.topics import PARAMETER_EVENTS

# What a recorder publishes too; a controller publishes more.
OF_ANY_NODE = ("/rosout", PARAMETER_EVENTS, "/events/write_split")

# One poll whether a set-point has arrived, in wall-clock s.
ARRIVAL_POLL = Duration(seconds=0.005)


class SetpointWarning(RuntimeWarning):
    """A set-point was sent, but the controller is not known to have it."""


def warn_of_late_setpoint(position: float, waited: float) -> None:
    """Tell that a set-point (m) has not arrived everywhere in the time (s) that was waited."""
    warnings.warn(
        f"setpoint {position:g} m has not arrived at every listener within {waited:g} s: the "
        "controller may be frozen or busy, and takes it later, or a listener has just been killed; "
        "thaw the controller, or look at controller/reference",
        SetpointWarning,
        stacklevel=3,
    )


def has_arrived(publisher: Publisher) -> bool:
    """Whether every listener has what ``publisher`` has sent."""
    return bool(publisher.wait_for_all_acked(ARRIVAL_POLL))


def setpoint_is_heard(node: Node, publisher: Publisher) -> bool:
    """Whether every listener to the set-points of ``publisher`` is matched, a controller included.

    A recorder may be matched before the controller, which would then miss the set-point. Listeners
    that want earlier set-points too do not count: ``publisher``, which keeps none, never matches
    them.
    """
    listeners = [
        listener
        for listener in node.get_subscriptions_info_by_topic(publisher.topic_name)
        if listener.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL
    ]
    return publisher.get_subscription_count() >= len(listeners) and any(
        _controls(node, listener.node_name, listener.node_namespace) for listener in listeners
    )


def hears_all_setpoints(node: Node, subscription: Subscription) -> bool:
    """Whether every sender of set-points is matched that a controller would hear.

    It listens reliably, as ``subscription`` does: best-effort senders match neither.
    """
    senders = node.get_publishers_info_by_topic(subscription.topic_name)
    heard = [
        sender
        for sender in senders
        if sender.qos_profile.reliability != ReliabilityPolicy.BEST_EFFORT
    ]
    return bool(subscription.get_publisher_count() >= len(heard))


def _controls(node: Node, name: str, namespace: str) -> bool:
    """Whether a node does more than listen; not as long as its name is not discovered."""
    if not namespace.startswith("/"):
        return False
    try:
        published = node.get_publisher_names_and_types_by_node(name, namespace)
    except NodeNameNonExistentError:
        return False
    return any(not topic.endswith(OF_ANY_NODE) for topic, _ in published)
