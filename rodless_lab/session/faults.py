# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Faults that a session makes: processes killed, restarted, frozen."""

import time
from collections.abc import Callable

from rclpy.qos import DurabilityPolicy

from rodless_base.ros.diagnostics import SUBSCRIBERS
from rodless_base.topics import JOINT_STATES
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.live_session import LiveSession
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.processes import ProcessPlan
from rodless_lab.session.running_rig import CONTROLLER, PLANT


class Faults(LiveSession):
    """The methods of a session that disturb its processes."""

    # Whether the controller's commands are matched.
    _heard: Callable[[], bool]
    _plan: ProcessPlan

    def kill(self, process: str) -> None:
        """Kill a process (``plant``, ``controller``; ``rig`` when they share one)."""
        managed = self._running(process)
        try:
            self._prepare_for_the_end_of(process)
        finally:
            managed.kill()

    def restart(self, process: str) -> None:
        """Stop a process, unless it was killed before, start it again, wait until it works.

        A lock-step plant offers its last sample anew to a new controller, unless commands are
        relayed: reset it then. One that was killed remains in DDS discovery for about 20 s of wall
        clock, for which lock-step waits. Raises HarnessError for a controller beside a plant in
        real time that is paused or whose run is over: it would wait for the next sample.
        """
        managed = self._running(process)
        if process == "controller" and self._mode == "realtime":
            self._check_samples_come()
        self._prepare_for_the_end_of(process)
        managed.ask_to_stop()
        managed.end()
        if process != "controller":
            self._paused = False
        if process != "plant":
            self._controller_begins()
        if process == "controller" and self._mode == "lockstep":
            self._wait(lambda: not self._heard(), "the old controller to be forgotten")
            if self._relayed is not None:
                self._receiver.take_waiting(time.time_ns())
                self._relayed.forget_controller()
            managed.start()
            self._wait(self._heard, "the new controller")
            if self._plan.runs_controller_node:
                self._wait_until_known(time.monotonic())
            return
        runs, began = self._received.runs, time.time_ns()
        if process == "controller":
            managed.start()
            self._wait(lambda: self._has_answered_since(began), "the new controller")
            return
        with self._received.expecting_run():
            managed.start()
            self._wait(lambda: self._received.runs > runs, f"sample 0 of the new {process}")
        self._receiver.take_waiting(time.time_ns())
        for commands in (self._own, self._relayed):
            if commands is not None:
                commands.begin_run(runs)

    def _wait_until_known(self, since: float) -> None:
        """Wait until the plant says, after ``since`` (s), that it sends to all readers there are.

        A sample that is sent before goes to those alone whom the plant knows.
        """
        node = self._observer.node
        samples, plant = map(node.resolve_topic_name, (JOINT_STATES, PLANT))

        def all_are_known() -> bool:
            readers = node.get_subscriptions_info_by_topic(samples)
            # One that wants what was sent before it came is never matched.
            fit = [r for r in readers if r.qos_profile.durability == DurabilityPolicy.VOLATILE]
            said = self._observer.diagnostics.get(plant)
            if said is None or said.arrived <= since:
                return False
            is_there = any(reader.node_name == CONTROLLER for reader in fit)
            return is_there and said.number(SUBSCRIBERS, PLANT) >= len(fit)

        self._wait(all_are_known, "the plant to find the new controller")

    def _prepare_for_the_end_of(self, process: str) -> None:
        """Take what waits for a test that computes: it would end with the process."""
        if process == "controller":
            return
        if self._processes[process].exit_code is None:
            self._catch_up()
        self._received.cut_run_short()

    def _check_samples_come(self) -> None:
        """Raise HarnessError where a new controller would find no sample to answer."""
        self._processes.check_plant()
        reason = "the plant is paused" if self._paused else "the run is over"
        if self._paused or self._has_ended:
            way_out = "resume()" if self._paused else "reset()"
            raise HarnessError(
                f"restart: {reason}, and a new controller answers samples alone; {way_out} first"
            )

    def _has_answered_since(self, began: int) -> bool:
        """Whether a command was sent after ``began`` (ns); HarnessError once none can be."""
        # Samples and answers come on topics of their own: the last sample may be there first.
        self._receiver.take_waiting(time.time_ns())
        answers = self._received.answers
        if answers and answers[-1].sent > began:
            return True
        self._check_goes_on("an answer of the new controller")
        return False

    def freeze(self, process: str) -> None:
        """Hold a process where it is, as a machine does that has no time for it."""
        self._running(process).freeze()

    def thaw(self, process: str) -> None:
        """Let a frozen process go on."""
        self._running(process).thaw()

    def _running(self, process: str) -> NodeProcess:
        """Return a process of the session; raises HarnessError outside its block."""
        self._check_inside()
        return self._processes[process]
