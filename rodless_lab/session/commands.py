# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where a session's commands come from when the test has a hand in them."""

from collections.abc import Callable

from rodless_lab.session.errors import HarnessError
from rodless_lab.session.samples import Cursor, Received, Sample
from rodless_sim.single_number import single_number

# The test's own control law: the voltage (V) for a sample, or None for no command.
Law = Callable[[Sample], float | None]

# What becomes of a controller's command (V) on its way to the plant; None loses it.
Alteration = Callable[[float], float | None]


class OwnCommands:
    """Commands by a law of the test's own; each sample is answered once."""

    def __init__(
        self, received: Received, send: Callable[[float], None], one_per_sample: bool
    ) -> None:
        """Answer nothing until there is a law; ``one_per_sample``: the plant waits for each."""
        self._received = received
        self._waits = one_per_sample
        self._send = send
        self._samples = Cursor(received)
        self._law: Law | None = None

    def drive(self, law: Law | None, from_now: bool) -> None:
        """Answer samples by ``law``: those not answered yet, or ``from_now`` new ones only."""
        self._law = law
        if from_now:
            self._samples = Cursor(self._received)

    @property
    def silence(self) -> str:
        """Say that the plant waits for commands that nothing sends, if so."""
        if not self._waits or self._law is not None:
            return ""
        return "; the plant waits for a command to each sample: let drive() answer them"

    def send(self, voltage: float) -> None:
        """Send one command; it answers the sample that waits for one."""
        self._samples.next()
        self._send(voltage)

    def answer(self) -> None:
        """Answer what has come.

        Raises what the law raises, and HarnessError for no command that the plant waits for; the
        sample it was asked for is the next one's then.
        """
        while self._law is not None and (found := self._samples.peek()) is not None:
            if not self._waits:
                self._samples.skip()
            law = f"drive: the law's answer to the sample at {found[1].time:g} s"
            voltage = voltage_or_none(self._law(found[1]), law, self._waits)
            if self._waits:
                self._samples.skip()
            if voltage is not None:
                self._send(voltage)


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
        self._samples = Cursor(received) if one_per_sample else None
        self._passed = 0
        self.alter: Alteration | None = None

    def answer(self) -> None:
        """Pass on what has come."""
        answers = self._received.answers
        while self._passed < len(answers) and (self._samples is None or self._samples.peek()):
            wanted = answers[self._passed].value
            altered = wanted if self.alter is None else self.alter(wanted)
            waits = self._samples is not None
            voltage = voltage_or_none(altered, "alter_commands: the result", waits)
            self._passed += 1
            if self._samples is not None:
                self._samples.skip()
            if voltage is not None:
                self._send(voltage)
