# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time driven by commands: one period for each, as fast as they come."""

import time
from collections.abc import Callable

from rodless_sim.node.commanders import Account, Crowd, Publishers, share_a_node
from rodless_sim.node.engine import Engine
from rodless_sim.node.time_keeper import (
    NO_COMMAND_YET,
    RESET_DONE,
    RUN_IS_OVER,
    Outgoing,
    TimeKeeper,
)

# s after which a further answer is long in coming: what it is waited for is said, and a second
# commander of the same name is taken for dead.
SECOND_ANSWER = 2.0


class Lockstep(TimeKeeper):
    """Answers each command with the next sample.

    It runs while exactly one publisher of commands is there: with two, nobody knows whose answer
    is whose. Two of one name are a controller that was started again and a dead one that the
    middleware has not missed yet: where one sample gets one answer, the run goes on.

    A publisher numbers its messages: from an answer's number follows how many have been given, with
    those that were lost. In a crowd nothing acts and nothing is counted; once it has gone, the
    sample is offered again. A commander whose very first answer was among what came then is waited
    for as one whose answer was lost.

    No sample is dropped. One that a reader holds back is sent as soon as that reads on or is gone;
    one that nobody answers for ``timeout`` is offered again, at growing intervals. As commands have
    no stamp, they are counted: a sample offered twice has two answers, and the plant steps when
    both are here, or when the second has not followed the first for as long as that took. A reset
    waits for the answers under way and drops them: taken for the answer to sample 0, one would set
    the loop one sample apart for good. Where nobody answers, it happens after ``timeout``, or when
    the commander has gone.
    """

    steps_by_itself = False

    def __init__(
        self,
        engine: Engine,
        timeout: float,
        ready: Callable[[], bool],
        commanders: Callable[[], Publishers],
        matched: Callable[[], int],
        outgoing: Outgoing,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer sample 0 as soon as ``ready``, and to one publisher of commands only.

        ``commanders`` gives the publishers of commands that are known by name, and ``matched`` how
        many are connected; ``timeout`` is in s of ``now``, in which a plant that was stopped itself
        does not wait.
        """
        super().__init__(engine)
        self._timeout = timeout
        self._ready = ready
        self._commanders = commanders
        self._crowd = Crowd(matched, now)
        self._outgoing = outgoing
        self._now = now
        self._present: Publishers = {}
        # Whom samples were offered to: their answers may still be under way.
        self._offered_to: Publishers = {}
        self._own = Account()
        self._out_of_turn = False  # whether a number came that was counted already
        # Of a second one of the same name, while it is to be seen which of them answers.
        self._second: Account | None = None
        self._known_before: frozenset[bytes] = frozenset()  # of the two
        self._several_answer = False
        self._answer: float | None = None  # the last answer to the present sample
        self._first_offer = self._last_event = 0.0
        self._reset_wanted = False

    @property
    def problem(self) -> str | None:
        """What keeps the plant from following commands now."""
        if self._engine.failure is not None or self._engine.ended:
            return self._engine.failure
        who = ", ".join(sorted(self._present.values()))
        if not self._started and (self._crowd.is_here or len(self._present) > 1):
            if len(self._present) < 2:
                who = f"{who or 'one'} and one that has gone, or is not known by name"
            return f"more than one publisher on valve/voltage ({who}): holding until one is left"
        if not self._started:
            return "waiting for subscribers and for one publisher on valve/voltage"
        return self._obstacle(", ".join(sorted(set(self._present.values()))))

    def _obstacle(self, commander: str) -> str | None:
        """What a run that has begun waits for."""
        if self._outgoing.obstacle is not None:
            return f"{self._outgoing.obstacle}: holding"
        if self._overdue:
            return f"no command for {self._timeout:g} s of wall time from {commander}: holding"
        if self._second is not None and self._answer is not None:
            return (
                f"two publishers on valve/voltage of one name ({commander}): holding for "
                f"{self._patience:.0f} s at most, to see whether both answer"
            )
        since = self._now() - self._last_event
        if self._is_between_answers and since > min(self._timeout, SECOND_ANSWER):
            return (
                f"a sample that was offered again has been answered, and {commander} may answer it "
                f"{self._own.owed} times more: holding for {self._patience:.0f} s at most"
            )
        return None

    @property
    def _overdue(self) -> bool:
        return self._answer is None and self._now() - self._first_offer > self._timeout

    def receive(self, voltage: float, number: int | None = None) -> None:
        """Take an answer (V) to the last sample, and its publisher's ``number`` for it, if any."""
        self._crowd.hear()
        self._look_for_a_crowd()
        if self._crowd.is_here:
            return
        if self._second is not None:
            self._take_of_either(voltage, number, self._second)
        elif number is None or self._is_in_turn(number):
            self._take(voltage, number)
        elif self._started and len(self._present) > 1:  # the one that was taken for dead
            self._several_answer = True
            self._hold()

    def connect(self, in_all: int) -> None:
        """Look whether one of the publishers is another's."""
        self._crowd.connect(in_all)
        self._look_for_a_crowd()

    def _is_in_turn(self, number: int) -> bool:
        if self._own.is_due(number):
            return True
        if self._own.last is not None and number <= self._own.last:
            self._out_of_turn = True
            return False
        # The first, or more than are due; where there is another publisher, or was until now, it
        # may be its.
        self._look_who_commands()
        is_alone = self._own.last is None or (len(self._present) == 1 and self._crowd.is_settled)
        return is_alone and self._may_be_one and bool(self._offered_to)

    def _take(self, voltage: float, number: int | None) -> None:
        self._own.take(number)
        if self._started:
            self._keep(voltage)
            if self._own.owed <= 0:
                self._complete()

    def _take_of_either(self, voltage: float, number: int | None, second: Account) -> None:
        """Take the answer of whoever of two of one name is alive; hold where both are."""
        own = self._own
        if number is None or own.last is None:  # nothing tells whose it is
            own.owed -= 1
            second.owed = max(second.owed - 1, 0)
            second.last = number
            both = own.owed < 0
        elif own.is_due(number):
            own.take(number)
            both = own.owed == 0 and second.last is not None
        elif second.last is None or number > second.last:
            second.take(number)
            both = own.owed == 0
        else:
            return
        if self._started:
            self._keep(voltage)
            if both:
                self._several_answer = True
                self._hold()

    def _keep(self, voltage: float) -> None:
        self._answer = voltage
        self._last_event = self._now()

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
            return NO_COMMAND_YET
        self._step()
        return self._engine.failure

    def reset(self) -> str:
        """Return to the start as soon as no answer is under way; say when that is."""
        if self._started and self._own.owed > 0 and not self._overdue:
            self._reset_wanted = True
            return "with the answer to the last sample"
        self._restart()
        return RESET_DONE

    def poll(self) -> None:
        """Do what no command triggers: start, hold without a sole commander, offer again."""
        self._look_who_commands()
        self._look_for_a_crowd()
        self._crowd.poll(self._present, self._offered_to)
        if self._reset_wanted and not self._started:
            self._restart()  # the answer that it waits for may never come
        # Before the run begins, too: what tells the time and the faults is sent then already.
        is_sent = self._outgoing.flush()
        if self._started and not is_sent:
            self._first_offer = self._last_event = self._now()
        elif self._started:
            self._wait()
        elif self._may_be_one and self._crowd.is_settled and self._ready():
            self._start()

    def close(self) -> None:
        """Nothing runs by itself."""

    @property
    def _answered(self) -> bool:
        """Whether the present sample has all its answers."""
        return self._answer is not None and self._own.owed <= 0 and self._second is None

    @property
    def _is_between_answers(self) -> bool:
        """Whether the present sample has an answer and may get more."""
        return self._answer is not None and self._own.owed > 0

    @property
    def _may_be_one(self) -> bool:
        return len(set(self._present.values())) == 1 and not self._several_answer

    def _look_who_commands(self) -> None:
        before, self._present = self._present, self._commanders()
        # A name may be told late.
        self._offered_to = {
            key: self._present.get(key, name) for key, name in self._offered_to.items()
        }
        if self._present.keys() == before.keys():
            return
        self._several_answer = False
        if before.keys() - self._present.keys():
            self._crowd.lose()
        if self._second is not None and len(self._present) < 2:
            if self._known_before.isdisjoint(self._present):
                self._own = self._second
            self._second = None
            self._hold()
        elif not self._present or self._present.keys() - before.keys():
            self._hold()

    def _look_for_a_crowd(self) -> None:
        if self._crowd.look(self._present, self._offered_to):
            self._hold()

    def _hold(self) -> None:
        if not self._started:
            return
        self._started = False
        self._answer = None
        self._withdraw()

    def _start(self) -> None:
        self._take_over()
        self._second = Account() if len(self._present) > 1 else None
        self._started = True
        self._engine.offer()
        self._has_offered()
        self._first_offer = self._last_event

    def _take_over(self) -> None:
        """Go on with the account of those who are present, or begin one where they are others."""
        self._known_before = frozenset(self._offered_to.keys() & self._present.keys())
        is_the_same_node = share_a_node(self._offered_to, self._present)
        if not is_the_same_node:
            self._own.owed = 0
        if not self._known_before:  # a publisher made anew counts from 1, what it lost included
            self._own.last = 0 if is_the_same_node else None
        self._own.owed = max(self._own.owed, 0)
        self._offered_to = self._present

    @property
    def _patience(self) -> float:
        """How long to wait after an offer or an answer, in s."""
        # Twice as long each time, and longer than a slow controller takes.
        twice, least = 2.0 * (self._last_event - self._first_offer), self._timeout
        if self._second is not None and self._answer is not None:
            least = min(least, SECOND_ANSWER)
        return max(least, twice)

    def _wait(self) -> None:
        if self._paused and self._answered:
            return
        if self._now() - self._last_event <= self._patience:
            return
        if self._answer is not None:
            # The other answers were lost on the way, or never sent.
            if self._second is not None and self._second.last is not None:
                self._own = self._second
            self._second = None
            self._own.owed = 0
            self._complete()
        elif self._reset_wanted:
            self._restart()
        elif not self._engine.ended:
            if self._out_of_turn:  # it numbers anew, perhaps
                self._own.last, self._out_of_turn = None, False
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
        if not self._started:
            # What goes out before the run begins is answered too. Of several, the one that is left
            # would owe an answer that another's account has: they are offered nothing.
            self._look_who_commands()
            if self._crowd.is_here or len(self._present) > 1:
                self._engine.reset(offer=False)
                return
            if self._present:
                self._take_over()
        self._engine.reset()
        self._has_offered()
        self._first_offer = self._last_event

    def _step(self) -> None:
        voltage, self._answer = self._answer, None
        if voltage is None or self._engine.ended:
            return
        self._engine.receive(voltage)
        self._engine.step()
        self._own.owed = 0
        self._out_of_turn = False
        self._has_offered()
        self._first_offer = self._last_event

    def _has_offered(self) -> None:
        self._last_event = self._now()
        # Who has been offered samples gets this one as well, beside another commander, too, and
        # while it makes its publisher anew. Where it has ended, the next one owes nothing.
        if self._engine.failure is None:
            for account in self._accounts:
                account.offer()

    def _withdraw(self) -> None:
        """Take back a sample that is still held back: nobody will answer it."""
        if self._outgoing.clear():
            for account in self._accounts:
                account.withdraw()

    @property
    def _accounts(self) -> list[Account]:
        return [self._own] if self._second is None else [self._own, self._second]
