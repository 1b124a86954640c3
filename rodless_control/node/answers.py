# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One valve command for each sample: the law's, or a closed valve where there is none."""

from collections.abc import Callable
from time import perf_counter, time_ns

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.measurement import Measurement
from rodless_base.ros.cdr import pack_float64
from rodless_base.ros.message_info import Info
from rodless_base.ros.publish import Outbox, wait_for_readers
from rodless_base.topics import VALVE_VOLTAGE
from rodless_control.loop import ControlLoop, Output
from rodless_control.node.law_pace import LawPace
from rodless_control.node.stalls import Stalls
from rodless_control.node.telemetry import Telemetry

# How often, in s, the log repeats that samples are not finite.
REPORT_PERIOD = 10.0

# What is said with the failure of a law, before what begins anew.
CLOSED_BY_FAILURE = "valve closed until ~/"

# What is said of a controller that was switched off.
DISABLED = "disabled: valve closed"


class Answers:
    """Commands on ``valve/voltage``, and with each of the law's its telemetry."""

    def __init__(
        self,
        node: Node,
        loop: ControlLoop,
        qos: QoSProfile | int,
        neutral_voltage: Callable[[], float],
        plant_waits: Callable[[], bool],
    ) -> None:
        """Answer by ``loop``; ``neutral_voltage`` (V) gives what closes the valve.

        ``plant_waits`` tells whether the plant waits for the answer to each sample, and offers it
        again where that takes long, as one in lock-step does.
        """
        self._node = node
        self._loop = loop
        self._neutral_voltage = neutral_voltage
        self._plant_waits = plant_waits
        self._voltage = node.create_publisher(Float64, VALVE_VOLTAGE, qos)
        self._outbox = Outbox(node)
        self.telemetry = Telemetry(node, loop.law, qos)
        self._reported: str | None = None
        self.pace = LawPace()
        self._stalls = Stalls(lambda: self.pace.interval)
        # A sample that a newer one has passed, as it seems, and whether that has been waited for.
        self._passed: Measurement | None = None
        self._waited_for_newer = False
        self._answered_old = False  # in this stall, as nothing newer seemed to come
        self._has_gap = False
        # Called for each failure of the law, with the valve closed already or about to be.
        self.on_failure: Callable[[], None] = lambda: None
        # Called for each sample that gets a command: one passed over, as it waited through a stall,
        # tells nothing of now.
        self.on_answer: Callable[[], None] = lambda: None
        self.enabled = True
        self.refused = False  # the last sample, because something of it was not finite
        self.any = False  # of the law's
        self.by_law = False  # the last command
        self.stamp = 0  # of the last sample, ns

    @property
    def listeners(self) -> int:
        """How many subscribers the commands have."""
        return int(self._voltage.get_subscription_count())

    @property
    def lost(self) -> int:
        """Messages lost to a stopped subscriber."""
        return self._outbox.lost + self.telemetry.lost

    @property
    def obstacle(self) -> str | None:
        """Who holds the commands back."""
        return self._outbox.obstacle

    def poll(self) -> None:
        """Send what was held back; look up who listens to telemetry; to be called often."""
        self._stalls.poll()
        self._answer_if_none_is_newer()
        self._outbox.flush()
        self.telemetry.poll()

    def take(self, measurement: Measurement, info: Info) -> None:
        """Answer a sample, of whose message ``info`` is; a plant that waits sends none newer."""
        self.stamp = measurement.stamp
        self._pass_over()
        sent = info["source_timestamp"] * SECONDS_PER_NANOSECOND
        self.pace.see(sent)
        may_skip = self.enabled and not self._plant_waits()
        if self._stalls.was_passed(sent) and may_skip:
            # One after another has been answered: their sender has not waited for that.
            self._has_gap |= self._answered_old
            self._passed, self._waited_for_newer = measurement, False
            return
        self._answered_old = False
        if may_skip and self._must_skip(info):
            self._loop.leave_out(measurement.stamp)
        else:
            self._give_answer(measurement)

    def _pass_over(self) -> None:
        """Leave out the sample that a newer one has passed indeed."""
        if self._passed is not None:
            self._loop.leave_out(self._passed.stamp)
            self._passed, self._has_gap = None, True
            self.pace.pass_over(self._stalls.lasted)

    def _answer_if_none_is_newer(self) -> None:
        """Answer a sample after all whose sender waits for that: so each last one is.

        One that has sent on without answers has newer ones, which a middleware that was stopped
        itself may take tenths of a second to fetch: they are waited for.
        """
        passed, waited = self._passed, self._waited_for_newer
        self._waited_for_newer = True
        sends_on = self._has_gap and self._stalls.is_recent
        if passed is not None and waited and not sends_on:
            self._passed, self._answered_old = None, True
            self._give_answer(passed)

    def _give_answer(self, measurement: Measurement) -> None:
        self.on_answer()
        output = self._answer(measurement) if self.enabled else None
        self.refused = self.enabled and output is None
        if output is None:
            self.close_valve()
            self.report_failure()
            self._report_refusal()
        else:
            self.by_law = self.any = True
            self._command(output.voltage)
            self.telemetry.publish(output)

    def _must_skip(self, info: Info) -> bool:
        # Some middlewares do not tell when a message was received.
        received = info["received_timestamp"] or info["source_timestamp"]
        return self.pace.must_skip(
            received * SECONDS_PER_NANOSECOND, time_ns() * SECONDS_PER_NANOSECOND
        )

    def _answer(self, measurement: Measurement) -> Output | None:
        if self._plant_waits() and (output := self._loop.repeat(measurement)) is not None:
            return output
        if self._has_gap:
            self._has_gap = False
            self._loop.expect_gap()
        began = perf_counter()
        output = self._loop.sample(measurement)
        self.pace.took(perf_counter() - began)
        return output

    @property
    def refusal(self) -> str | None:
        """Why the last sample was not answered by the law, if that was for the sample's sake."""
        if not self.refused or self._loop.failure is not None:
            return None
        used = "position or pressure" if self._loop.law.USES_PRESSURES else "position"
        return f"{used} not finite: valve closed"

    def _report_refusal(self) -> None:
        if self.refusal is not None:
            self._node.get_logger().warning(self.refusal, throttle_duration_sec=REPORT_PERIOD)

    @property
    def failure(self) -> str | None:
        """Why the law is not called any more, and until when, if so."""
        if self._loop.failure is None:
            return None
        # A reset switches nothing on.
        way_out = "reset or ~/enable" if self.enabled else "enable"
        return f"{self._loop.failure}; {CLOSED_BY_FAILURE}{way_out}"

    def report_failure(self) -> None:
        """Say once why the law is not called any more."""
        failure = self.failure
        if failure == self._reported:
            return
        self._reported = failure
        if failure is not None:
            self._node.get_logger().error(failure)
            self.on_failure()

    def hold(self) -> None:
        """Let the law wait for positions."""
        self._loop.hold()
        self.report_failure()

    def reset(self) -> None:
        """Forget the run so far, the failure of a law too; not who still waits for an answer."""
        self._loop.reset()
        self._reported = None  # it may have failed again, in the same way
        self.report_failure()

    def enable(self, enabled: bool) -> bool:
        """Answer by the law, or keep the valve closed; return whether the law begins anew.

        A law that fails at once, as ``failure`` says, is not enabled by that.
        """
        begins = enabled and (not self.enabled or self._loop.failure is not None)
        if begins:
            self.reset()
        if not enabled or self._loop.failure is None:
            self.enabled = enabled
        return begins

    def close_valve(self) -> None:
        """Send a command that closes the valve."""
        self.by_law = False
        self._command(self._neutral_voltage())

    def wait_for_readers(self, deadline: float) -> bool:
        """Give whoever reads them time for what is on its way; return whether it has come.

        To be called before the node ends; ``deadline`` is in s, monotonic.
        """
        received = wait_for_readers(self._outbox, [self._voltage], deadline)
        return self.telemetry.wait_for_readers(deadline) and received

    def _command(self, voltage: float) -> None:
        self._outbox.send(self._voltage, pack_float64(voltage))
