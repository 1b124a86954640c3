# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time in a session: run, pause, step, reset, and the samples that come."""

import math
import time
from collections.abc import Callable, Sequence

from std_srvs.srv import SetBool

from rodless_base.one_line import shown
from rodless_base.real_number import is_number, whole_number
from rodless_base.ros.diagnostics import CLOSED_VALVE, LAST_COMMAND
from rodless_lab.session.deprecated import timeout_was_patience
from rodless_lab.session.errors import HarnessError, RefusedError
from rodless_lab.session.live_session import LiveSession
from rodless_lab.session.running_rig import CONTROLLER
from rodless_lab.session.samples import Cursor, Sample, Samples, Unstamped, instant
from rodless_sim.node.time_keeper import NO_COMMAND_YET, RESET_DONE


class PlantTime(LiveSession):
    """The methods of a session that let plant time pass."""

    _telemetry: bool

    @timeout_was_patience
    def run_until(
        self,
        condition: float | Callable[[Sample], object],
        what: str = "the condition of run_until",
        timeout: float | None = None,
    ) -> Sample:
        """Let the rig run to a plant time (s) or to a sample for which ``condition`` holds.

        Returns that sample, the newest counting first. In lock-step with commands from the test
        (no controller, or ``relay_commands``) the plant then stands at that very sample; it has
        gone on otherwise. Raises ValueError for a condition that is neither, and HarnessError once
        the session's ``duration`` is over and the condition has not held.
        """
        if not callable(condition):
            if not is_number(condition) or not math.isfinite(condition):
                raise ValueError(
                    f"run_until: {shown(condition)} refused, must be a plant time (s) or a "
                    "function of a sample"
                )
            end = instant(condition)
            what = f"plant time {condition:g} s"
            return self._run_until(lambda _, s: instant(s.time) >= end, what, timeout)
        wanted = condition
        return self._run_until(lambda _, sample: wanted(sample), what, timeout)

    def _run_until(
        self, condition: Callable[[int, Sample], object], what: str, timeout: float | None = None
    ) -> Sample:
        samples = Cursor(self._received)

        def found() -> Sample | None:
            while (next_sample := samples.next()) is not None:
                if condition(*next_sample):
                    return next_sample[1]
            self._processes.check_plant()
            self._check_goes_on(what)
            return None

        sample = self._wait(found, what, timeout, running=True)
        assert sample is not None
        return sample

    @timeout_was_patience
    def run_for(self, duration: float, timeout: float | None = None) -> Sample:
        """Let the rig run for ``duration`` s of plant time; see :meth:`run_until`.

        Raises ValueError for a duration that is no number of s, or negative.
        """
        if not is_number(duration) or not 0.0 <= duration < math.inf:
            raise ValueError(
                f"run_for: {shown(duration)} refused, must be a number of s, from 0 on"
            )
        return self.run_until(self.latest.time + duration, timeout=timeout)

    @timeout_was_patience
    def run(self, timeout: float | None = None) -> Samples:
        """Let the rig run to the end of its ``duration``; return all samples of the run.

        With a controller in lock-step, its answer to the last sample is there too. Raises
        HarnessError in a session without ``duration``, and LawFailedError where the law has failed
        by then; of a failure at the very last sample the end of the block may be the first to know.
        """
        if not self._duration:
            raise HarnessError("run: this session has no duration")
        self.run_until(self._duration, timeout=timeout)
        if self._mode == "lockstep" and self._has_controller and self._relayed is None:
            self._wait_for_the_last_answer()
        if self._law_watch is not None:
            # A report is sent before the answers to the samples after the failure.
            self._observer.take_waiting_diagnostics()
            self._law_watch.check()
        return self.samples()

    def _wait_for_the_last_answer(self) -> None:
        answers, last = self._received.answers, self._received.last_sent
        self._wait(lambda: answers and answers[-1].sent > last, "the answer to the last sample")
        if self._telemetry:
            self._wait_for_the_last_telemetry(time.monotonic())
        bag = self._bag
        if bag is not None:
            commands = len(self._received.voltage)
            self._wait(lambda: bag.has(commands), "the bag to have every command")

    def _wait_for_the_last_telemetry(self, since: float) -> None:
        """Wait for the last answer's, or for word that it has none; ``since`` (s) it has come.

        Terms that nobody publishes any more are those of a law before.
        """
        answers, node = self._received.answers, self._observer.node

        def has_come(name: str, term: Sequence[Unstamped]) -> bool:
            there = bool(term) and term[-1].sent > answers[-1].sent
            return there or not node.count_publishers(f"controller/{name}")

        self._wait(
            lambda: (
                all(has_come(*term) for term in self._received.terms.items())
                or self._last_answer_is_a_closed_valve(since)
            ),
            "the telemetry of the last sample",
        )

    def _last_answer_is_a_closed_valve(self, since: float) -> bool:
        """Whether the controller has said so, of the last sample, ``since`` then (s)."""
        name = self._observer.node.resolve_topic_name(CONTROLLER)
        said = self._observer.diagnostics.get(name)
        if said is None or said.arrived < since or said.stamp < instant(self.latest.time):
            return False
        return said.values.get(LAST_COMMAND) == CLOSED_VALVE

    def samples(self, run: int = -1) -> Samples:
        """Return what has come of a run of the plant: 0 the first, -1 the last; resets part runs.

        Raises LostSampleError if samples were lost, IndexError for a run that there is not, and
        TypeError for what is no whole number.
        """
        run = whole_number(run, "run")
        runs = range(self._received.runs)
        if not -len(runs) <= run < len(runs):
            raise IndexError(f"run {run}: there are {len(runs)}, from 0 to {len(runs) - 1}")
        found = runs[run]
        count = self._received.complete(found)
        if self._inside and self._mode == "lockstep" and found == runs[-1]:
            self._wait_for_commands(found, count)
        return self._received.samples(found, count)

    def _wait_for_commands(self, run: int, count: int) -> None:
        """Wait for those between the first ``count`` samples: they come on a topic of their own.

        Not in a law of the test, which is asked in a wait, nor of a plant that was ended: what was
        on its way may have ended with it.
        """
        self._receiver.take_waiting(time.time_ns())
        if count < 2 or self._observer.is_checking or run in self._received.cut_short:
            return
        before, commands = self._received.sent(run, count - 2), self._received.voltage
        self._wait(
            lambda: commands and commands[-1].sent > before, "the commands between the samples"
        )

    def pause(self) -> None:
        """Stop plant time; a lock-step plant keeps the next answer back."""
        self._ask(SetBool, "plant/pause", data=True)
        self._paused = True
        self._catch_up()

    def resume(self) -> None:
        """Let plant time run on."""
        self._ask(SetBool, "plant/pause", data=False)
        self._paused = False

    def step(self, count: int = 1) -> Sample:
        """Let a paused plant advance by ``count`` samples; return the last.

        In lock-step each step waits for the answer to the sample before. Raises RefusedError
        where the plant is not paused or its simulation has failed, ValueError for less than one,
        TypeError for what is no whole number, and HarnessError once the session's ``duration`` is
        over.
        """
        if (count := whole_number(count, "count")) < 1:
            raise ValueError(f"count {count} refused, must be 1 or more")
        self._check_inside()
        if not self._paused:
            raise RefusedError("step: pause the plant first")
        for _ in range(count):
            sample = self._step()
        return sample

    def _step(self) -> Sample:
        asked = time.time_ns()

        def stepped() -> bool:
            self._check_goes_on("a step")
            answer = self._call_once("plant/step", lambda: self._received.last_sent >= asked)
            if answer is None or answer.success:
                return True
            if answer.message != NO_COMMAND_YET:
                raise RefusedError(f"plant/step: {answer.message}")
            return False

        self._wait(stepped, "the plant to step", running=True)
        return self._run_until(lambda sent, _: sent >= asked, "the sample of a step")

    def reset(self) -> Sample:
        """Return the plant to its start, where a new run begins; return its sample 0."""
        runs = self._received.runs
        with self._received.expecting_run():
            said = self._ask_once("plant/reset", lambda: self._received.runs > runs)
            if self._own is not None:
                self._own.end_run(runs, at_once=said in {RESET_DONE, None})
            if self._relayed is not None:
                self._relayed.end_run(runs)
            self._wait(lambda: self._received.runs > runs, "sample 0 after a reset", running=True)
        return self._received.sample(runs, 0)
