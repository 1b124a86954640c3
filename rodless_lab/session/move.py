# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Send the carriage of a running rig somewhere and follow it until it has settled."""

import contextlib
import math
import re
import time
from collections.abc import Callable

from rcl_interfaces.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import CARRIAGE
from rodless_base.ros.joint import carriage_position
from rodless_base.ros.message_info import Info
from rodless_base.ros.topics import stamp_nanoseconds
from rodless_base.topics import JOINT_STATES, REFERENCE, SETPOINT, VALVE_VOLTAGE
from rodless_lab.session.diagnostic import count_among
from rodless_lab.session.errors import InterruptedRunError
from rodless_lab.session.running_rig import CONTROLLER, NODES, PLANT, RigError, RunningRig
from rodless_lab.session.setpoint import has_arrived, hears_all_setpoints, setpoint_is_heard
from rodless_lab.session.track import MoveResult, Track
from rodless_lab.session.travel import BY_THEMSELVES, outside_travel

# Wall-clock s, for the nodes to be found, and for their first or next message. Fast DDS takes up to
# 3 s to match a topic, and diagnostics come once a second.
FIND_TIMEOUT = 6.0
MESSAGE_TIMEOUT = 5.0

# Without a sample for this long (wall-clock s), the plant is looked for: it may have ended.
ABSENT_AFTER = 1.0

# What is checked before a set-point is sent, as far as the controller has it.
CHECKED = {"reference.type", "reference.minimum", "reference.maximum"}

REFUSED = "set-points refused"
# How the lines of its log begin that say what is wrong with one.
SET_POINT = "set-point: "
VALUE = re.compile(r"([-+.\w]+) m ")

# In s, within which the reference of a controller that takes a set-point is heard to move: only a
# later report tells by its count.
FOLLOWS_WITHIN = 0.3


class StandstillError(RuntimeError):
    """Plant time stands still, so that nothing can move; the text says why."""


class SetpointMove:
    """One set-point for a running rig."""

    def __init__(self, rig: RunningRig, target: float) -> None:
        """Prepare a move to ``target`` (m)."""
        self._rig = rig
        self._target = target
        self._sent_at = 0.0
        # What was refused before ours, None where the controller had not said.
        self._refused_before: int | None = None
        self._refusal: str | None = None
        self._last_sample = time.monotonic()
        # The last set-point (m) that anybody has sent, when (ns), and whether ours has gone out.
        self._newest: tuple[int, float] = (0, math.nan)
        self._is_out = False
        # Names of the joints in messages without the carriage.
        self._strangers: list[str] | None = None
        self.track = Track(target)

    def prepare(self) -> None:
        """Find the nodes, listen, and check that the set-point can be sent.

        Raises :class:`RigError` where it cannot, StandstillError where plant time stands still.
        """
        self._rig.wait_for_node(PLANT, FIND_TIMEOUT)
        self._listen()
        if not self._rig.wait_for(self._is_heard, FIND_TIMEOUT):
            raise RigError(self._no_controller)
        # Not before: this would be somebody who listens.
        setpoints = self._rig.observer.subscribe(Float64, SETPOINT, self._take_setpoint, info=True)
        self._rig.check_alone()
        if self._rig.is_known(CONTROLLER):
            self._check_target()
        self._wait_until_heard()
        # Each sender is matched apart: of one that is not, what replaces ours is not known.
        self._rig.wait_for(
            lambda: hears_all_setpoints(self._rig.observer.node, setpoints), FIND_TIMEOUT
        )
        # A recorder that has come in the meantime, too.
        self._rig.wait_for(self._is_heard, FIND_TIMEOUT)

    def _is_heard(self) -> bool:
        return setpoint_is_heard(self._rig.observer.node, self._setpoint)

    def _listen(self) -> None:
        observer = self._rig.observer
        self._setpoint = observer.publisher(Float64, SETPOINT, subscribers=0)
        for topic, take in (
            (REFERENCE, self.track.take_reference),
            (VALVE_VOLTAGE, self.track.take_voltage),
        ):
            observer.subscribe(Float64, topic, _value_taker(take), info=True)
        observer.subscribe(Log, "/rosout", self._take_log)
        observer.subscribe(JointState, JOINT_STATES, self._take_sample, info=True)

    def _take_sample(self, message: JointState, info: Info) -> None:
        self._last_sample = time.monotonic()
        position = carriage_position(message)
        if position is None:
            self._strangers = list(message.name)
            return
        stamp = stamp_nanoseconds(message.header.stamp)
        self.track.take_sample(info["source_timestamp"], stamp, position)

    def _take_setpoint(self, message: Float64, info: Info) -> None:
        self._is_out |= message.data == self._target
        # One that is no number takes nobody's place.
        if math.isfinite(message.data):
            self._newest = max(self._newest, (info["source_timestamp"], message.data))

    def _take_log(self, message: Log) -> None:
        logger = self._rig.name(CONTROLLER).strip("/").replace("/", ".")
        if message.name == logger and self._is_about_ours(message.msg):
            self._refusal = message.msg

    def _is_about_ours(self, line: str) -> bool:
        """Whether ``line`` says that our set-point is refused: others may send wrong ones, too."""
        if not line.startswith(SET_POINT):
            return False
        value = VALUE.match(line, len(SET_POINT))
        return value is None or math.isclose(float(value[1]), self._target, rel_tol=1e-5)

    def _check_target(self) -> None:
        names = set(self._rig.observer.parameter_names(CONTROLLER)) & CHECKED
        values = self._rig.observer.get_parameters(CONTROLLER, sorted(names))
        kind = values.get("reference.type")
        if kind in BY_THEMSELVES:
            raise RigError(
                f"reference.type is {kind}, which takes no set-points; change it with "
                "rodless set reference.type=setpoint"
            )
        if refusal := outside_travel(self._target, values):
            raise RigError(refusal)

    def _wait_until_heard(self) -> None:
        nodes = [node for node in NODES if self._rig.is_known(node)]
        self._rig.wait_for(lambda: all(map(self._rig.diagnostic, nodes)), MESSAGE_TIMEOUT)
        if self._is_paused or not self._rig.wait_for(
            lambda: self.track.has_samples, MESSAGE_TIMEOUT
        ):
            self._check_joint()
            if (elsewhere := self._rig.samples_elsewhere()) is not None:
                raise RigError(elsewhere)
            raise StandstillError(self._standstill)
        speaks = self._rig.observer.node.count_publishers(REFERENCE)
        if speaks and not self._rig.wait_for(lambda: self.track.has_references, MESSAGE_TIMEOUT):
            raise RigError(f"the controller does not control: {self._rig.state_of(CONTROLLER)}")
        # Its commands belong to what is measured, and are matched apart from all others.
        if self._rig.observer.node.count_publishers(VALVE_VOLTAGE):
            self._rig.wait_for(lambda: self.track.has_commands, MESSAGE_TIMEOUT)

    @property
    def _no_controller(self) -> str:
        if not self._rig.is_known(CONTROLLER):
            return self._rig.missing(CONTROLLER, FIND_TIMEOUT)
        return f"the {CONTROLLER} is there but does not listen to {self._setpoint.topic_name}"

    def _check_joint(self) -> None:
        if self._strangers is not None and not self.track.has_samples:
            raise RigError(
                f"{JOINT_STATES} has no position of a joint {CARRIAGE!r}; its joints: "
                f"{', '.join(self._strangers) or 'none'}"
            )

    @property
    def _is_paused(self) -> bool:
        plant = self._rig.diagnostic(PLANT)
        if plant is None or self._rig.is_silent(PLANT):
            return False
        return plant.values.get("paused") == "True"

    @property
    def _standstill(self) -> str:
        """Why no samples come."""
        why = self._rig.state_of(PLANT)
        if self._is_paused:
            why = "it is paused"
        elif why.startswith("ended"):
            why = "its time.duration is over; rodless reset begins anew"
        elif self._rig.is_silent(PLANT):
            why = f"the plant is {why}"
        return f"plant time stands still: {why}"

    def make(
        self, timeout: float, show: Callable[[Track], None], warn: Callable[[str], None]
    ) -> MoveResult:
        """Send the set-point and follow the carriage until it has settled, or ``timeout`` (s).

        Calls ``show`` again and again, and ``warn`` once if plant time comes to stand still. Raises
        :class:`RigError` where the controller refuses the set-point, another takes its place, the
        plant is reset or ends, or what has come cannot be measured.
        """
        self._send()
        warned = False

        def ended() -> bool:
            nonlocal warned
            show(self.track)
            if not warned and time.monotonic() - self._last_sample > MESSAGE_TIMEOUT:
                warned = True
                warn(self._standstill)
            over = self.track.has_settled or self.track.was_reset or self._is_refused
            return over or self._is_overtaken or self.track.is_elsewhere or self._has_gone

        self._rig.wait_for(ended, timeout)
        try:
            return self._verdict()
        finally:
            # A listener that was late to match, such as a recorder, has it only if its sender
            # stays. Who does not want to wait for that has the measurement all the same.
            with contextlib.suppress(InterruptedRunError):
                self._rig.wait_for(lambda: has_arrived(self._setpoint), MESSAGE_TIMEOUT)
            # Two rigs of one name explain whatever has been found.
            self._rig.check_alone()

    def _verdict(self) -> MoveResult:
        """Return what is measured; raises :class:`RigError` where something has come between."""
        if self._is_refused:
            reason = self._refusal or "its log says why"
            raise RigError(f"the controller refuses {self._target * 1e3:g} mm: {reason}")
        if self._is_overtaken:
            other = self._newest[1]
            raise RigError(
                f"another set-point, {other * 1e3:g} mm, has taken the place of this one"
            )
        if self.track.is_elsewhere:
            raise RigError(
                f"the controller's reference rests at {self.track.reference * 1e3:g} mm: another "
                "set-point has taken the place of this one, or this one was lost or limited"
            )
        if self._has_gone:
            raise RigError("the plant has ended during the move")
        if self.track.was_reset:
            raise RigError("the plant was reset during the move")
        try:
            return self.track.result()
        except ValueError as error:
            raise RigError(f"the move cannot be measured: {error}") from error

    def _send(self) -> None:
        self._refused_before = self._refused
        self._refusal = None
        self._sent_at = time.monotonic()
        self._is_out = False
        self.track.begin(time.time_ns())
        self._setpoint.publish(Float64(data=self._target))

    @property
    def _is_overtaken(self) -> bool:
        settled = self.track.has_settled
        return self._is_out and self._newest[1] != self._target and not settled

    @property
    def _has_gone(self) -> bool:
        silent = time.monotonic() - self._last_sample > ABSENT_AFTER
        return silent and not self._rig.is_known(PLANT)

    @property
    def _refused(self) -> int | None:
        said = self._rig.diagnostic(CONTROLLER)
        return count_among(said.values, REFUSED) if said is not None else None

    @property
    def _is_refused(self) -> bool:
        """Whether the log says so, or the count, where the reference has not followed."""
        return self._refusal is not None or (self._is_refused_by_count and not self.track.is_taken)

    @property
    def _is_refused_by_count(self) -> bool:
        """Whether a report that came once the reference would have followed counts more."""
        said, count, before = self._rig.diagnostic(CONTROLLER), self._refused, self._refused_before
        if said is None or count is None or before is None:
            return False
        return count > before and said.arrived >= self._sent_at + FOLLOWS_WITHIN


def _value_taker(take: Callable[[int, float], None]) -> Callable[[Float64, Info], None]:
    return lambda message, info: take(info["source_timestamp"], message.data)
