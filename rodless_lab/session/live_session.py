# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What every part of a session stands on: processes, an observer, and waits with a bound."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from std_srvs.srv import Trigger

from rodless_base.one_line import shown
from rodless_lab.session.bag import SessionBag
from rodless_lab.session.catch_up import CatchUp
from rodless_lab.session.commands import OwnCommands, RelayedCommands
from rodless_lab.session.deprecated import timeout_was_patience
from rodless_lab.session.errors import HarnessError, RefusedError, WaitTimeoutError
from rodless_lab.session.lag import LagWatch
from rodless_lab.session.law_watch import LawWatch
from rodless_lab.session.observer import Observer
from rodless_lab.session.plant_hears import PlantHears
from rodless_lab.session.processes import SessionProcesses
from rodless_lab.session.receiver import Receiver
from rodless_lab.session.running_rig import PLANT, is_silent
from rodless_lab.session.samples import Received, Sample, instant

OUTSIDE = "this session does not run: use it inside its with block"

# What there is from __enter__ on.
_LIVE = {
    "_observer",
    "_received",
    "_processes",
    "_environment",
    "_setpoint",
    "_stack",
    "_heard",
    "_opening",
}

Mode = Literal["realtime", "lockstep"]
Found = TypeVar("Found")


class LiveSession:
    """Plant and controller at work; :class:`RigSession` sets the attributes."""

    _mode: Mode
    _duration: float
    _has_controller: bool
    _processes: SessionProcesses
    _observer: Observer
    _receiver: Receiver
    _received: Received
    _own: OwnCommands | None = None
    _relayed: RelayedCommands | None = None
    _bag: SessionBag | None = None
    # Of a session with the controller node whose law must not fail.
    _law_watch: LawWatch | None = None
    # Of a session in real time.
    _lag: LagWatch | None = None
    _paused = False
    # What the test has made of the controller that runs.
    _switched_off = False
    _reference_type = ""
    _range_changed = False
    # Between __enter__ and __exit__.
    _inside = False
    # Whether commands of the test go out in a wait.
    _answering = False
    # Whether they arrive, in lock-step; in real time a lost one is followed by the next.
    _plant_hears: PlantHears | None = None
    _environment: dict[str, str]
    # Of the processes before they start and once they have ended; None while they run.
    _outputs: dict[str, str] | None
    _exit_codes: dict[str, int | None] | None

    def __init__(self) -> None:
        """Nothing runs yet."""
        self._outputs = {}
        self._exit_codes = {}

    def __getattr__(self, name: str) -> Any:
        """Refuse what only a session has that was entered."""
        if name in _LIVE:
            raise HarnessError(OUTSIDE)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def _check_inside(self) -> None:
        if not self._inside:
            raise HarnessError(OUTSIDE)

    @property
    def observer(self) -> Observer:
        """The session's own node, for topics and services that the session does not know."""
        return self._observer

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables that put another process into this session's domain."""
        return dict(self._environment)

    @property
    def outputs(self) -> dict[str, str]:
        """What each process has printed so far; also after the end."""
        return self._processes.outputs if self._outputs is None else self._outputs

    @property
    def exit_codes(self) -> dict[str, int | None]:
        """Exit code of each process, negative for a signal, None of what runs."""
        return self._processes.exit_codes if self._exit_codes is None else self._exit_codes

    @property
    def pids(self) -> dict[str, int]:
        """Process ID of each process."""
        return self._processes.pids

    @timeout_was_patience
    def wait_until(
        self, condition: Callable[[], Found], what: str, timeout: float | None = None
    ) -> Found:
        """Let the rig run until ``condition()`` is true, and return what it returned.

        ``what`` completes the error "timed out … waiting for …". Raises WaitTimeoutError after
        ``timeout`` s of wall clock (default: the session's), ValueError for what is no function.
        """
        if not callable(condition):
            raise ValueError(f"wait_until: {shown(condition)} refused, must be a function")
        return self._wait(condition, what, timeout, running=True)

    def _wait(
        self,
        condition: Callable[[], Found],
        what: str,
        timeout: float | None = None,
        running: bool = False,
    ) -> Found:
        with self._waiting(running):
            return self._observer.wait(condition, what, timeout)

    @contextmanager
    def _waiting(self, running: bool = False) -> Iterator[None]:
        """Send the commands that are due meanwhile; show what nodes have printed if it times out.

        In lock-step a plant that the test answers stands still except while it is to run.
        """
        self._check_inside()
        before, self._answering = self._answering, running or self._mode == "realtime"
        if self._lag is not None:
            self._lag.begin()
        try:
            yield
        except WaitTimeoutError as error:
            watched = (self._law_watch, self._own, self._plant_hears)
            silence = "".join(one.silence for one in watched if one is not None)
            silence += "; the plant is paused: resume() lets it go on" if self._paused else ""
            text = f"{error}{silence}{self._processes.held}{self._complaint}"
            raise WaitTimeoutError(self._processes.with_outputs(text)) from error
        finally:
            self._answering = before

    @property
    def _complaint(self) -> str:
        """What a plant in lock-step warns of, to complete the text of a wait."""
        said = self._observer.diagnostics.get(self._observer.node.resolve_topic_name(PLANT))
        if self._mode != "lockstep" or said is None or is_silent(said):
            return ""
        return "" if said.level == DiagnosticStatus.OK else f"; the plant says: {said.message}"

    def _catch_up(self) -> None:
        """Take what the plant has sent until now: a test has not heard of it while it computed.

        What it looks at next is then from after the command that it has just given.
        """
        answers = self._own is not None or self._relayed is not None
        if not self._received.runs or (answers and self._mode == "lockstep"):
            return  # a plant that waits for the test is not ahead of it
        coming = CatchUp(self._received, self._paused)

        def caught_up() -> bool:
            self._receiver.take_waiting(coming.until)
            return coming.is_over() or self._has_ended

        # It has a bound of its own: the command has taken effect, however patient the session is.
        self._wait(caught_up, "the samples until now", math.inf)

    @property
    def latest(self) -> Sample:
        """The newest sample that has come."""
        run = self._received.runs - 1
        if run < 0:
            raise HarnessError("no sample has come yet: the session is being entered")
        return self._received.sample(run, self._received.complete(run) - 1)

    @property
    def _has_ended(self) -> bool:
        """Whether the newest sample is the last one of the session's duration, if it has one."""
        return bool(self._duration) and instant(self.latest.time) >= instant(self._duration)

    def _check_goes_on(self, what: str) -> None:
        """Raise HarnessError where the run is over and ``what`` can no longer come."""
        if self._has_ended:
            raise HarnessError(
                f"{what} has not come, and the run is over: the session's duration is "
                f"{self._duration:g} s"
            )

    def _between_spins(self) -> None:
        self._processes.check()
        if self._law_watch is not None:
            self._law_watch.check()
        if self._lag is not None:
            self._lag.check()
        for commands in (self._own, self._relayed):
            if self._answering and commands is not None and self._is_heard:
                commands.answer()

    @property
    def _is_heard(self) -> bool:
        return self._plant_hears is None or self._plant_hears()

    def _controller_begins(self) -> None:
        """Take the controller for what it was given: what the test has made of it is gone."""
        self._switched_off, self._reference_type, self._range_changed = False, "", False

    def _ask(self, kind: type, service: str, **fields: object) -> str:
        """Call a service; return what it says. Raises RefusedError where it does not succeed."""
        with self._asking(service.partition("/")[0]):
            response = self._observer.call(kind, service, **fields)
        return _said(service, response)

    def _ask_once(self, service: str, has_worked: Callable[[], object]) -> str | None:
        """Ask as :meth:`_ask` for what is not to be done twice; None: done, and nothing said."""
        response = self._call_once(service, has_worked)
        return None if response is None else _said(service, response)

    def _call_once(self, service: str, has_worked: Callable[[], object]) -> Any:
        """Call a service as :meth:`Observer.call_once` does."""
        with self._asking(service.partition("/")[0]):
            return self._observer.call_once(Trigger, service, has_worked)

    @contextmanager
    def _asking(self, node: str) -> Iterator[None]:
        """Wait for an answer of ``node``; raises HarnessError where the test has ended that."""
        with self._waiting():
            self._processes.check_node(node, f"no answer of {node} will come")
            yield


def _said(service: str, response: Any) -> str:
    """Return what a service says. Raises RefusedError where it does not succeed."""
    if not response.success:
        raise RefusedError(f"{service}: {response.message}")
    return str(response.message)
