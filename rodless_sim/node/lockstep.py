# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time driven by commands: one period for each, as fast as they come."""

import time
from collections.abc import Callable, Collection, Mapping

from rodless_sim.node.engine import Engine
from rodless_sim.node.time_keeper import RUN_IS_OVER, Outgoing, TimeKeeper


class Lockstep(TimeKeeper):
    """Answers each command with the next sample.

    It runs while exactly one publisher of commands is there: with two, nobody knows whose answer
    is whose. Two of one name are a controller that was started again and a dead one that the
    middleware has not missed yet: where one sample gets one answer, the run goes on.

    No sample is dropped. One that a reader holds back is sent as soon as that reads on or is gone;
    one that nobody answers for ``timeout`` is offered again, at growing intervals. As commands have
    no stamp, they are counted: a sample offered twice has two answers, and the plant steps when
    both are here, or when the second has not followed the first for as long as that took. A reset
    waits for the answers under way and drops them: taken for the answer to sample 0, one would set
    the loop one sample apart for good. Where nobody answers, it happens after ``timeout``.
    """

    steps_by_itself = False

    def __init__(
        self,
        engine: Engine,
        timeout: float,
        ready: Callable[[], bool],
        commanders: Callable[[], Mapping[bytes, str]],
        outgoing: Outgoing,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer sample 0 as soon as ``ready``, and to one publisher of commands only.

        ``commanders`` gives the nodes that publish commands, by what identifies the publisher;
        ``timeout`` is in s of ``now``, in which a plant that was stopped itself does not wait.
        """
        super().__init__(engine)
        self._timeout = timeout
        self._ready = ready
        self._commanders = commanders
        self._outgoing = outgoing
        self._now = now
        self._present: Mapping[bytes, str] = {}
        # Whom samples were offered to: their answers may still be under way.
        self._offered_to: Collection[bytes] = ()
        self._owed = 0  # answers to what has been offered
        self._answer: float | None = None  # the last answer to the present sample
        self._first_offer = self._last_event = 0.0
        self._identifying = self._several_answer = False
        self._reset_wanted = False

    @property
    def problem(self) -> str | None:
        """What keeps the plant from following commands now."""
        if self._engine.failure is not None or self._engine.ended:
            return self._engine.failure
        who = ", ".join(sorted(self._present.values()))
        if not self._started and len(self._present) > 1:
            return f"more than one publisher on valve/voltage ({who}): holding until one is left"
        if not self._started:
            return "waiting for subscribers and for one publisher on valve/voltage"
        return self._obstacle(who)

    def _obstacle(self, commander: str) -> str | None:
        """What a run that has begun waits for."""
        if self._outgoing.obstacle is not None:
            return f"{self._outgoing.obstacle}: holding"
        if self._overdue:
            return f"no command for {self._timeout:g} s of wall time from {commander}: holding"
        if self._is_between_answers and self._now() - self._last_event > self._timeout:
            return (
                f"a sample that was offered again has been answered, and {commander} may answer it "
                f"{self._owed} times more: holding for {self._patience:.0f} s at most"
            )
        return None

    @property
    def _overdue(self) -> bool:
        return self._answer is None and self._now() - self._first_offer > self._timeout

    def receive(self, voltage: float) -> None:
        """Take an answer (V) to the last sample."""
        self._owed = max(self._owed - 1, -1)
        if not self._started:
            return
        self._answer = voltage
        self._last_event = self._now()
        if self._identifying:
            self._several_answer = self._owed < 0
            if self._several_answer:
                self._hold()
        elif self._owed <= 0:
            self._complete()

    def pause(self, paused: bool) -> None:
        """Keep the next answer back, or let it take effect."""
        self._paused = paused
        if not paused and self._answered:
            self._step()

    def step(self) -> str | None:
        """Let one answer take effect; return what is in the way, if anything."""
        if self._engine.failure is not None:
            return self._engine.failure
        if not self._paused:
            return "pause the plant first"
        if self._engine.ended:
            return RUN_IS_OVER
        if not self._answered:
            return "no command has come for the last sample yet"
        self._step()
        return None

    def reset(self) -> str:
        """Return to the start as soon as no answer is under way; say when that is."""
        if self._started and self._owed > 0 and not self._overdue:
            self._reset_wanted = True
            return "with the answer to the last sample"
        self._restart()
        return "done"

    def poll(self) -> None:
        """Do what no command triggers: start, hold without a sole commander, offer again."""
        self._look_who_commands()
        if self._started and not self._outgoing.flush():
            self._first_offer = self._last_event = self._now()
        elif self._started:
            self._wait()
        elif self._may_be_one and self._ready():
            self._start()

    def close(self) -> None:
        """Nothing runs by itself."""

    @property
    def _answered(self) -> bool:
        """Whether the present sample has all its answers."""
        return self._answer is not None and self._owed <= 0 and not self._identifying

    @property
    def _is_between_answers(self) -> bool:
        """Whether the present sample has an answer and may get more."""
        return self._answer is not None and self._owed > 0

    @property
    def _may_be_one(self) -> bool:
        return len(set(self._present.values())) == 1 and not self._several_answer

    def _look_who_commands(self) -> None:
        before, self._present = self._present, self._commanders()
        if self._present.keys() == before.keys():
            return
        self._several_answer = False
        if self._started and (not self._present or self._present.keys() - before.keys()):
            self._hold()

    def _hold(self) -> None:
        self._started = self._identifying = False
        self._answer = None
        self._withdraw()

    def _start(self) -> None:
        if not set(self._offered_to).issuperset(self._present):
            self._owed = 0
        self._owed = max(self._owed, 0)
        self._offered_to = self._present.keys()
        self._identifying = len(self._present) > 1
        self._started = True
        self._engine.offer()
        self._has_offered()
        self._first_offer = self._last_event

    @property
    def _patience(self) -> float:
        """How long to wait after an offer or an answer, in s."""
        # Twice as long each time, and longer than a slow controller takes.
        return max(self._timeout, 2.0 * (self._last_event - self._first_offer))

    def _wait(self) -> None:
        if self._paused and self._answered:
            return
        if self._now() - self._last_event <= self._patience:
            return
        if self._answer is not None:
            # The other answers were lost on the way, or never sent.
            self._owed = 0
            self._identifying = False
            self._complete()
        elif self._reset_wanted:
            self._restart()
        elif not self._engine.ended:
            self._engine.offer()
            self._has_offered()

    def _complete(self) -> None:
        if self._reset_wanted:
            self._restart()
        elif not self._paused:
            self._step()

    def _restart(self) -> None:
        self._reset_wanted = False
        self._answer = None
        self._withdraw()
        self._engine.reset()
        self._has_offered()
        self._first_offer = self._last_event

    def _step(self) -> None:
        voltage, self._answer = self._answer, None
        if voltage is None or self._engine.ended:
            return
        self._engine.receive(voltage)
        self._engine.step()
        self._owed = 0
        self._has_offered()
        self._first_offer = self._last_event

    def _has_offered(self) -> None:
        self._owed += self._started and self._engine.failure is None
        self._last_event = self._now()

    def _withdraw(self) -> None:
        """Take back a sample that is still held back: nobody will answer it."""
        if self._outgoing.clear():
            self._owed = max(self._owed - 1, 0)
