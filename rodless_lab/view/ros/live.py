# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the topics of a rig carry now, looked up 40 times a second.

The nodes publish for whoever only looks on (THROTTLED): that costs them next to nothing. Of others,
such as a controller of one's own, the view has every message, but nothing here is called for each.
Each subscription keeps the last one alone, without asking for what is lost, so that no node ever
waits for a view; the middleware's own threads throw the others away. At 1 kHz that costs a tenth of
what callbacks would.
"""

import math
import threading
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.closing import Closing
from rodless_base.constants import CARRIAGE, NANOSECONDS_PER_SECOND, PISTON, SPOOL
from rodless_base.frames import joint_among
from rodless_base.one_line import traced
from rodless_base.ros.lasting_topics import LOOK_PERIOD, LastingTopics
from rodless_base.ros.topics import QUEUE_DEPTH, stamp_nanoseconds
from rodless_base.ros.unheard import has_only_unheard_publishers, unheard_text
from rodless_base.topics import (
    JOINT_STATES,
    PRESSURES,
    REFERENCE,
    SETPOINT,
    THROTTLED,
    VALVE_STATE,
    VALVE_VOLTAGE,
)
from rodless_control import Pid
from rodless_lab.view.errors import ViewError
from rodless_lab.view.samples import COLUMNS
from rodless_lab.view.state import CONTROLLER, ViewState
from rodless_lab.view.valve_flows import spool_voltage

# How often the topics are looked up, in wall-clock s; how often who publishes them.
PERIOD = 1.0 / 40.0
DISCOVERY_PERIOD = LOOK_PERIOD

# Takes what a reliable publisher sends, and holds none back.
LATEST_BEST_EFFORT = QoSProfile(
    depth=1, history=HistoryPolicy.KEEP_LAST, reliability=ReliabilityPolicy.BEST_EFFORT
)

# Below the controller's name, of what is no term in volts.
NO_TERMS = ("reference", "error")

Taker = Callable[[Any], None]


class LiveRig(Closing):
    """Follows a rig's topics in a thread of its own, and sends set-points."""

    def __init__(self, context: Context, state: ViewState) -> None:
        """Begin to follow the rig of ``state`` in the domain of ``context``."""
        self._state = state
        self._node = Node(
            "view",
            context=context,
            namespace=state.namespace,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._values: dict[str, float | None] = {}
        self._stamp: int | None = None
        # By topic; what is subscribed for it may be the throttled one.
        self._takers: dict[str, tuple[Subscription, Taker]] = {}
        self._terms: tuple[str, ...] = ()
        self._silent = LastingTopics(partial(has_only_unheard_publishers, self._node))
        self._subscribe(JointState, JOINT_STATES, self._take_joint)
        for field, topic in PRESSURES.items():
            self._subscribe(FluidPressure, topic, self._value(field, "fluid_pressure"))
        self._subscribe(Float64, REFERENCE, self._value("reference", "data"))
        self._subscribe(JointState, VALVE_STATE, self._take_valve)
        self._subscribe(Float64, SETPOINT, self._take_set_point)
        self._set_point = self._node.create_publisher(Float64, SETPOINT, QUEUE_DEPTH)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="view samples", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave the topics."""
        self._ending.set()
        self._thread.join()
        self._node.destroy_node()

    def send_set_point(self, target: float) -> None:
        """Publish a set-point (m); raises :class:`ViewError` where nobody listens."""
        # This view listens too, and a recorder may: a controller publishes its commands as well.
        if not self._node.count_publishers(VALVE_VOLTAGE):
            raise ViewError(f"no controller listens to {self._set_point.topic_name}")
        self._set_point.publish(Float64(data=target))

    def _subscribe(self, kind: type, topic: str, take: Taker) -> None:
        # Never called back: the node is in no executor.
        source = self._source(topic)
        subscription = self._node.create_subscription(kind, source, take, LATEST_BEST_EFFORT)
        self._takers[topic] = subscription, take

    def _unsubscribe(self, topic: str) -> None:
        subscription, _ = self._takers.pop(topic)
        self._node.destroy_subscription(subscription)

    def _source(self, topic: str) -> str:
        """Return the throttled topic, but the topic itself where that alone has a publisher."""
        throttled = THROTTLED + topic
        if topic == SETPOINT:  # comes rarely, from whoever steers
            return topic
        unthrottled = self._node.count_publishers(topic) > 0
        return topic if unthrottled and not self._node.count_publishers(throttled) else throttled

    def _value(self, name: str, field: str) -> Taker:
        def take(message: Any) -> None:
            self._values[name] = _finite(getattr(message, field))

        return take

    def _take_joint(self, message: JointState) -> None:
        if joint_among(CARRIAGE, message.name) is None:
            return
        if len(message.position) != len(message.name):
            return
        self._stamp = stamp_nanoseconds(message.header.stamp)
        for joint, prefix in ((CARRIAGE, ""), (PISTON, "piston_")):
            for field in ("position", "velocity"):
                self._values[prefix + field] = _of_joint(message, joint, field)

    def _take_valve(self, message: JointState) -> None:
        if joint_among(SPOOL, message.name) is None:
            return
        voltage = _of_joint(message, SPOOL, "effort")
        if voltage is not None:
            self._values["voltage"] = voltage
        displacement = _of_joint(message, SPOOL, "position")
        self._values["spool"] = None if displacement is None else spool_voltage(displacement)

    def _take_set_point(self, message: Float64) -> None:
        self._state.target, self._state.target_heard = _finite(message.data), monotonic()

    # The thread

    def _run(self) -> None:
        try:
            self._follow()
        except Exception as error:  # nobody else would hear of it
            self._state.problem = f"readings have ended: {traced(error)}; start the view anew"
            self._node.get_logger().error(self._state.problem)

    def _follow(self) -> None:
        lookups = 0
        while not self._ending.wait(PERIOD):
            if lookups % round(DISCOVERY_PERIOD / PERIOD) == 0:
                self._discover()
            lookups += 1
            self._take_all()
            self._add_row()

    def _take_all(self) -> None:
        for subscription, take in list(self._takers.values()):
            with subscription.handle:
                taken = subscription.handle.take_message(subscription.msg_type, False)
            if taken is not None:
                take(taken[0])

    def _add_row(self) -> None:
        if self._stamp is None:
            return
        _time, *names = COLUMNS
        values = map(self._values.get, (*names, *self._terms))
        self._state.history.add((self._stamp / NANOSECONDS_PER_SECOND, *values))

    def _discover(self) -> None:
        """Follow what publishers come and go: the terms of the law, and who tells the voltage."""
        for topic, (subscription, take) in list(self._takers.items()):
            if subscription.topic_name != self._node.resolve_topic_name(self._source(topic)):
                kind = subscription.msg_type
                self._unsubscribe(topic)
                self._subscribe(kind, topic, take)
        if self._stamp is None:
            self._look_for_samples()
        terms = self._published_terms()
        if terms != self._terms and terms:
            for term in self._terms:
                self._unsubscribe(f"{CONTROLLER}/{term}")
            for term in terms:
                self._subscribe(Float64, f"{CONTROLLER}/{term}", self._value(term, "data"))
            self._terms = self._state.terms = terms
            self._state.history.clear()
        # A real rig has nobody who knows what the valve holds: there its command has to do.
        commanded = not self._node.count_publishers(VALVE_STATE)
        if commanded and VALVE_VOLTAGE not in self._takers:
            self._values.pop("spool", None)  # stays where the last plant had it otherwise
            self._subscribe(Float64, VALVE_VOLTAGE, self._value("voltage", "data"))
        elif not commanded and VALVE_VOLTAGE in self._takers:
            self._unsubscribe(VALVE_VOLTAGE)

    def _look_for_samples(self) -> None:
        samples = self._node.resolve_topic_name(JOINT_STATES)
        if self._silent.look([samples]):
            self._state.unheard = unheard_text([samples])
            self._node.get_logger().error(self._state.unheard)
        elif not has_only_unheard_publishers(self._node, samples):
            self._state.unheard = None

    def _published_terms(self) -> tuple[str, ...]:
        own = self._node.resolve_topic_name(CONTROLLER) + "/"
        terms = (
            name.removeprefix(own)
            for name, kinds in self._node.get_topic_names_and_types()
            if name.startswith(own)
            and "std_msgs/msg/Float64" in kinds
            and name.removeprefix(own) not in NO_TERMS
            and self._node.count_publishers(name)
        )
        # Those of the PID in its own order, which is not that of the alphabet.
        own_order = {term: place for place, term in enumerate(Pid.TERMS)}
        return tuple(sorted(terms, key=lambda term: (own_order.get(term, len(own_order)), term)))


def _of_joint(message: JointState, joint: str, field: str) -> float | None:
    """Return a joint's position, velocity or effort; None where the message does not have it."""
    name = joint_among(joint, message.name)
    values = getattr(message, field)
    if name is None or len(values) != len(message.name):
        return None
    return _finite(values[message.name.index(name)])


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
