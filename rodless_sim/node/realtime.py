# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time paced by the wall clock."""

import threading
import time
from collections.abc import Callable

from rodless_base.one_line import traced
from rodless_sim.node.engine import Engine
from rodless_sim.node.pacing import Pacer
from rodless_sim.node.time_keeper import RESET_DONE, RUN_IS_OVER, Outgoing, TimeKeeper

# How often, in s, the plant looks whether it may start.
POLL_PERIOD = 0.02

WAITING = "waiting for subscribers"


class Realtime(TimeKeeper):
    """Steps the engine from a thread of its own, once a period."""

    steps_by_itself = True

    def __init__(
        self,
        engine: Engine,
        wall_period: int,
        ready: Callable[[], bool],
        outgoing: Outgoing,
        now: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """Step every ``wall_period`` ns of ``now`` as soon as ``ready`` says so.

        What is ``outgoing`` still is sent before the next sample.
        """
        super().__init__(engine)
        self._ready = ready
        self._outgoing = outgoing
        self._pacer = Pacer(wall_period, now)
        self._stepping = threading.Lock()
        # Of a failure and of a reset, each of which is told in two places.
        self._failing = threading.Lock()
        self._failure: Exception | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="plant", daemon=True)
        self._thread.start()

    @property
    def overruns(self) -> int:
        """Periods that the machine could not keep."""
        return self._pacer.overruns

    @property
    def problem(self) -> str | None:
        """What keeps the plant from following commands now."""
        if self._engine.failure is not None:
            return self._engine.failure
        if not self._started:
            return WAITING
        command = self._engine.command
        if command.received and not command.present:
            return "no valid command: valve closed"
        return None

    def connect(self, in_all: int) -> None:
        """Whoever sends last is followed."""

    def receive(self, voltage: float, number: int | None = None) -> None:  # noqa: ARG002
        """Take a command (V)."""
        self._engine.receive(voltage)

    def pause(self, paused: bool) -> None:
        """Stop plant time, or let it run on; a step under way ends before this does."""
        self._paused = paused
        with self._stepping:
            pass

    def step(self) -> str | None:
        """Advance by one period; return what is in the way, if anything."""
        if not self._paused:
            return "pause the plant first"
        if not self._started:
            return WAITING
        if self._engine.ended:
            return RUN_IS_OVER
        self._engine.step()
        return self._engine.failure

    def reset(self) -> str:
        """Return to the start; say when."""
        with self._failing:
            self._engine.reset()
            self._failure = None
        return RESET_DONE

    def poll(self) -> None:
        """Raise what has come out of the thread, once: the node is to know, as of a callback."""
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                self._keep_time()
            except Exception as failure:
                with self._failing:
                    self._engine.fail(traced(failure))
                    self._failure = failure
                self._closing.wait(POLL_PERIOD)

    def _keep_time(self) -> None:
        while not self._ready():
            if self._closing.wait(POLL_PERIOD):
                return
        self._started = True
        self._engine.offer()
        self._pacer.restart()
        while self._pacer.wait(self._closing.is_set):
            with self._stepping:
                if self._paused or self._engine.ended:
                    # Nothing was due, so nothing can be late.
                    self._pacer.restart()
                else:
                    self._outgoing.flush()
                    self._engine.step()
