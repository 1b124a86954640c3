# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where a session's commands come from when the test has a hand in them."""

import math
from collections.abc import Callable

from rodless_lab.session.errors import HarnessError
from rodless_lab.session.offers import Offers
from rodless_lab.session.samples import Received, Sample
from rodless_sim.single_number import single_number

# The test's own control law: the voltage (V) for a sample, or None for no command.
Law = Callable[[Sample], float | None]

# What becomes of a controller's command (V) on its way to the plant; None loses it.
Alteration = Callable[[float], float | None]

# What is wrong where the result of an alteration is no voltage.
ALTERED = "alter_commands: the result"


class OwnCommands:
    """Commands by a law of the test's own, which is asked once for each sample.

    One that a lock-step plant offers again is answered again with the same voltage.
    """

    def __init__(
        self, received: Received, send: Callable[[float], None], one_per_sample: bool
    ) -> None:
        """Answer nothing until there is a law; ``one_per_sample``: the plant waits for each."""
        self._received = received
        self._waits = one_per_sample
        self._send = send
        self._samples = Offers(received)
        self._last = math.nan  # the answer to the sample before
        self._law: Law | None = None
        self._asking = False  # whether the law is asked at the moment

    def drive(self, law: Law | None, from_now: bool) -> None:
        """Answer samples by ``law``: those not answered yet, or ``from_now`` new ones only."""
        self._law = law
        if from_now:
            self._samples = Offers(self._received)

    def begin_run(self, run: int) -> None:
        """Answer a plant that has been started anew from its sample 0 on.

        That of the one before still waits for an answer, which the new one would take for its own.
        """
        if self._waits:
            self._samples.begin(run)

    @property
    def silence(self) -> str:
        """Say that the plant waits for commands that nothing sends, if so."""
        if not self._waits or self._law is not None:
            return ""
        return "; the plant waits for a command to each sample: let drive() answer them"

    def end_run(self, run: int, at_once: bool) -> None:
        """Let a plant that is to be reset go on to ``run``, in lock-step.

        It counts on an answer to its last sample, which it drops: that is due even where it was
        reset ``at_once``, as beside another commander.
        """
        if self._waits and (at_once or self._law is None) and self._samples.is_due_before(run):
            self.send(math.nan)

    @property
    def is_due(self) -> bool:
        """Whether a command can be sent in lock-step: a sample must wait for it.

        Raises HarnessError in a law that the plant waits for: its result is the command.
        """
        if self._asking:
            raise HarnessError("send_voltage: refused in a law of drive(); return the voltage")
        return self._samples.peek() is not None

    def send(self, voltage: float) -> None:
        """Send one command; it answers the sample that waits for one."""
        self.answer_again()
        self._samples.skip()
        self._last = voltage
        self._send(voltage)
        self.answer_again()

    def answer(self) -> None:
        """Answer what has come.

        Raises what the law raises, and HarnessError for no command that the plant waits for; the
        sample it was asked for is the next one's then.
        """
        self.answer_again()
        while self._law is not None and (found := self._samples.peek()) is not None:
            if not self._waits:
                self._samples.skip()
            law = f"drive: the law's answer to the sample at {found[1].time:g} s"
            self._asking = True
            try:
                value = self._law(found[1])
            finally:
                self._asking = False
            voltage = voltage_or_none(value, law, self._waits)
            if voltage is not None:
                (self.send if self._waits else self._send)(voltage)

    def answer_again(self) -> None:
        """Answer what was answered, and has been offered again, with the same voltage."""
        while self._waits and self._samples.again > 0:
            self._samples.answer_again()
            self._send(self._last)


def voltage_of(value: object, what: str) -> float:
    """Return a command (V) that a test gives; raises HarnessError, with ``what``, for none."""
    try:
        return single_number(value, what, "V")
    except TypeError as error:
        raise HarnessError(str(error)) from error


def voltage_or_none(value: object, what: str, waits: bool) -> float | None:
    """Return :func:`voltage_of`; None for no command, refused where the plant ``waits``."""
    if value is not None:
        return voltage_of(value, what)
    if waits:
        raise HarnessError(f"{what} is None, and a lock-step plant waits for a number of V")
    return None


class RelayedCommands:
    """A controller's commands, passed on to the plant by the test."""

    def __init__(
        self, received: Received, send: Callable[[float], None], one_per_sample: bool
    ) -> None:
        """Pass commands on as they are; ``one_per_sample``: each when its sample is complete."""
        self._received = received
        self._send = send
        self._samples = Offers(received) if one_per_sample else None
        self._passed = 0
        self._last: float | None = None  # what was passed on for the sample before
        # Answers of controllers that have ended, from a place to another: they are of no sample.
        self._void = (0, 0)
        self._is_orphaned = False  # the sample that waits: its controller has ended without answer
        self.alter: Alteration | None = None

    def begin_run(self, run: int) -> None:
        """Pass on nothing that was sent before a plant that has been started anew, in lock-step."""
        if self._samples is None:
            return
        self._samples.begin(run)
        self._is_orphaned = False
        answers, began = self._received.answers, self._received.sent(run, 0)
        self._passed = sum(answer.sent < began for answer in answers)

    def forget_controller(self) -> None:
        """Pass on no answer of a controller that has ended but that to the last sample.

        Its last command, which closes the valve as it ends, answers none.
        """
        if self._samples is not None:
            answers = len(self._received.answers)
            kept = min(self._passed + self._samples.due, answers)
            self._is_orphaned = self._passed == kept
            self._void = (kept, answers)
            self._leave_void()

    def end_run(self, run: int) -> None:
        """Let a plant that is to be reset go on to ``run``, whose last sample nobody answers."""
        if self._is_orphaned and self._samples is not None and self._samples.is_due_before(run):
            self._samples.skip()
            self._send(math.nan)
        self._is_orphaned = False

    def _leave_void(self) -> None:
        begin, end = self._void
        if begin <= self._passed < end:
            self._passed = end

    def answer(self) -> None:
        """Pass on what has come."""
        answers = self._received.answers
        while self._passed < len(answers) and (self._samples is None or self._samples.due):
            wanted = answers[self._passed].value
            voltage = (
                self._in_real_time(wanted)
                if self._samples is None
                else self._of_sample(wanted, self._samples)
            )
            self._passed += 1
            self._leave_void()
            if voltage is not None:
                self._send(voltage)

    def _in_real_time(self, wanted: float) -> float | None:
        """Return what becomes of a command; None loses it."""
        return voltage_or_none(self._altered(wanted), ALTERED, waits=False)

    def _of_sample(self, wanted: float, samples: Offers) -> float | None:
        """Return what becomes of an answer in lock-step; of a further one to a sample, the same."""
        if samples.again > 0:
            samples.answer_again()
            return self._last
        self._last = voltage_or_none(self._altered(wanted), ALTERED, waits=True)
        samples.skip()
        return self._last

    def _altered(self, wanted: float) -> float | None:
        return wanted if self.alter is None else self.alter(wanted)
