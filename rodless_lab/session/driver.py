# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A node that gives a rig the voltages of an identification, one for each sample."""

import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.joint import carriage_position
from rodless_base.ros.lasting_topics import LOOK_PERIOD, LastingTopics
from rodless_base.ros.namesakes import KILLED
from rodless_base.ros.process import run_node
from rodless_base.ros.publish import UNKNOWN, Outbox
from rodless_base.ros.rivals import publishers_of
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH, stamp_nanoseconds
from rodless_base.ros.unheard import has_only_unheard_publishers, unheard_text
from rodless_base.start import Stop
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.running_rig import DISCOVERY

# How often, in wall-clock s, the driver polls whether it is heard.
POLL_PERIOD = 0.02

# Somebody else who commands for longer than this, in wall-clock s, is not on the way out.
STAYS = 1.0

# After how long without a sample, in wall-clock s, that is said.
SILENCE = 5.0

RECORD_ANEW = "what was recorded is of no use, record anew"

# How long the last command may take to arrive.
LAST_COMMAND_TIMEOUT = Duration(seconds=1.0)


class Driver:
    """Answers each sample with the voltage that is due ``time`` after the first one."""

    def __init__(
        self,
        voltages: npt.NDArray[np.float64],
        period: float,
        closed_voltage: float,
        recorders: int,
        show: Callable[[int], None],
        ended: Callable[[], None],
    ) -> None:
        """Send ``voltages`` (V, shape (n,), ``period`` s apart), then call ``ended``.

        :meth:`close` commands the ``closed_voltage`` (V).

        Answers samples once the rig and ``recorders`` hear it, so that no command is lost; one that
        came before, and that a plant in lock-step has offered again meanwhile, is answered as often
        as it came. Calls ``ended`` too where somebody else commands the valve: ``rivals`` names
        who, and where the plant is of no use: ``trouble`` says why.
        ``show`` is told each whole second (s, plant time) of the run.
        """
        self.node = GuardedNode("driver")
        self._voltages = voltages
        self._closed_voltage = closed_voltage
        self._period = round(period * NANOSECONDS_PER_SECOND)
        self._listeners = 1 + recorders
        self._show = show
        self._ended = ended
        self._first: int | None = None
        self._last = 0  # stamp of the last sample, ns
        self._shown = -1
        self.done = False
        self.rivals: str | None = None
        self.trouble: str | None = None
        self._last_sample = 0.0  # s, of time.monotonic(), from when it answers on
        self._told_of_silence = False
        self._heard_since: float | None = None
        self._beside_since: float | None = None
        self._outbox = Outbox(self.node)
        self._answers = False
        self._kept: list[JointState] = []  # the last sample from before, as often as it came
        # Before the publisher, without which a plant in lock-step offers nothing: whoever misses an
        # offer is waited for.
        self.node.create_subscription(JointState, JOINT_STATES, self._hear, QUEUE_DEPTH)
        self._publisher = self.node.create_publisher(Float64, VALVE_VOLTAGE, LOSSLESS)
        self._samples = self.node.resolve_topic_name(JOINT_STATES)
        self._silent = LastingTopics(partial(has_only_unheard_publishers, self.node))
        self.node.create_timer(POLL_PERIOD, self._poll, clock=steady_clock())
        self.node.create_timer(LOOK_PERIOD, self._look_for_samples, clock=steady_clock())

    def close(self) -> None:
        """Leave the valve closed, if it was driven, and destroy the node."""
        if self.has_begun and self._publisher.get_subscription_count():
            self._outbox.send(self._publisher, Float64(data=self._closed_voltage))
            self._publisher.wait_for_all_acked(LAST_COMMAND_TIMEOUT)
        self.node.destroy_node()

    def _poll(self) -> None:
        self._outbox.flush()
        self._look_for_rivals()
        if self._beside_since is None and not self._answers and self._is_heard():
            self._answers = True
            self._last_sample = time.monotonic()  # from here on there may be silence
            for sample in self._kept:
                self._answer(sample)

    def _look_for_rivals(self) -> None:
        """End before the first voltage where others command; later where they stay."""
        found = publishers_of(self.node, self._publisher.topic_name)
        if not found:
            self._beside_since = None
            return
        self._kept.clear()  # offered to them, perhaps; where they go it is offered once more
        if self._beside_since is None:
            self._beside_since = time.monotonic()
        stays = time.monotonic() - self._beside_since > STAYS
        if self.rivals is None and (stays or not (self.has_begun or UNKNOWN in found)):
            others = found - {self.node.get_fully_qualified_name()}
            self.rivals = ", ".join(sorted(others)) or "another rodless drive"
            self._ended()

    def _look_for_samples(self) -> None:
        if not self.has_begun and self._silent.look([self._samples]):
            self._end_because(unheard_text([self._samples]))
        elif self._answers:
            self._look_for_silence()

    def _look_for_silence(self) -> None:
        """Say once that no sample comes; end where nobody is left to send any of the run."""
        if time.monotonic() - self._last_sample < SILENCE:
            self._told_of_silence = False
        elif self.has_begun and not self.node.count_publishers(self._samples):
            self._end_because(f"{self._samples}: the plant has ended; {RECORD_ANEW}")
        elif not self._told_of_silence:
            self._told_of_silence = True
            print(
                f"\n{self._samples}: no sample for {SILENCE:g} s, the plant is paused, stopped, "
                "killed or at the end of its run; going on once there is one",
                file=sys.stderr,
            )

    def _end_because(self, trouble: str) -> None:
        self.trouble = trouble
        self._ended()

    @property
    def has_begun(self) -> bool:
        """Whether a voltage was given."""
        return self._first is not None

    def _is_heard(self) -> bool:
        """Whether all listen, and have for long enough that others who command were found."""
        if self._publisher.get_subscription_count() < self._listeners:
            self._heard_since = None
            return False
        if self._heard_since is None:
            self._heard_since = time.monotonic()
        return time.monotonic() - self._heard_since > DISCOVERY

    def _hear(self, sample: JointState) -> None:
        if carriage_position(sample) is None:  # an arm on the same topic tells no plant time
            return
        if self._answers:
            self._answer(sample)
            return
        if self._kept and self._kept[0].header.stamp != sample.header.stamp:
            self._kept.clear()
        self._kept.append(sample)

    def _answer(self, sample: JointState) -> None:
        now = stamp_nanoseconds(sample.header.stamp)
        self._last_sample = time.monotonic()
        if self._first is None:
            self._first = now
        if now < self._last:  # one that is offered again has the same
            self._end_because(
                f"{self._samples}: the plant was reset or started again; {RECORD_ANEW}"
            )
            return
        self._last = now
        elapsed = now - self._first
        due = elapsed // self._period
        self.done = due >= len(self._voltages)
        if self.done:
            self._ended()
            return
        self._outbox.send(self._publisher, Float64(data=float(self._voltages[due])))
        seconds = elapsed // NANOSECONDS_PER_SECOND
        if seconds != self._shown:
            self._shown = seconds
            self._show(seconds)


def drive(
    voltages: npt.NDArray[np.float64],
    period: float,
    closed_voltage: float,
    recorders: int,
    stop: Stop,
    show: Callable[[int], None],
) -> tuple[int, bool]:
    """Run a :class:`Driver` to its end or to ``stop``; return exit code and whether it is done.

    After a line on standard error the code is 2 where somebody else commands the valve, and 1 where
    somebody came to do so meanwhile, and where the plant is not heard, ends or begins anew.
    """
    drivers: list[Driver] = []

    def end() -> None:
        stop.requested = True

    def make() -> Driver:
        drivers.append(Driver(voltages, period, closed_voltage, recorders, show, end))
        return drivers[0]

    code = run_node(make, stop)
    driver = drivers[0] if drivers else None
    if driver is not None and driver.rivals is not None:
        since = "has come to command the valve too: what was recorded is of no use"
        what = since if driver.has_begun else "commands the valve too"
        print(
            f"{VALVE_VOLTAGE}: {driver.rivals} {what}; stop it, or start the rig without its "
            f"controller {KILLED}",
            file=sys.stderr,
        )
        return 1 if driver.has_begun else 2, False
    if driver is not None and driver.trouble is not None:
        print(driver.trouble, file=sys.stderr)
        return 1, False
    return code, driver is not None and driver.done
