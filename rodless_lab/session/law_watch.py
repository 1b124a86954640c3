# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether the law of a session's controller has failed, so that no test passes without its law."""

from collections.abc import Callable

from rodless_control.node.answers import CLOSED_BY_FAILURE
from rodless_lab.session.diagnostic import Diagnostic, count_among
from rodless_lab.session.errors import LawFailedError
from rodless_lab.session.observer import Observer
from rodless_lab.session.running_rig import CONTROLLER, SILENT, is_silent
from rodless_lab.session.set_parameters import LAW_FAILURES

WAY_OUT = "law_may_fail=True lets the run go on"


class LawWatch:
    """Raises :class:`LawFailedError` once for each time that the law has failed."""

    def __init__(self, observer: Observer, printed: Callable[[], str]) -> None:
        """Watch the controller in the domain of ``observer``; ``printed`` gives its output."""
        self._observer = observer
        self._printed = printed
        self._name = observer.node.resolve_topic_name(CONTROLLER)
        self._seen: Diagnostic | None = None
        self._told = 0

    def check(self) -> None:
        """Look at the last report of the controller, which follows a failure at once."""
        said = self._observer.diagnostics.get(self._name)
        if said is None or said is self._seen:
            return
        self._seen = said
        failures = count_among(said.values, LAW_FAILURES)
        if failures:
            # Reports count from the last ~/reset on, of which nobody may have told the session.
            lines = self._lines
            self._raise_for(max(failures, len(lines)), (lines or [said.message])[-1])

    def check_to_the_end(self) -> None:
        """Look at all that the ended controller has printed, for a failure in no report read."""
        lines = self._lines
        self._raise_for(len(lines), "".join(lines[-1:]))

    @property
    def silence(self) -> str:
        """Say that the controller has not reported for a while, if so."""
        silent = is_silent(self._observer.diagnostics.get(self._name))
        return f"; the controller is {SILENT[CONTROLLER]}" if silent else ""

    @property
    def _lines(self) -> list[str]:
        """What the log says of each failure, if the session has the log."""
        lines = (line for line in self._printed().splitlines() if CLOSED_BY_FAILURE in line)
        return [line.partition("]: ")[2] or line for line in lines]

    def _raise_for(self, failures: int, text: str) -> None:
        before, self._told = self._told, max(failures, self._told)
        if failures > before:
            raise LawFailedError(f"{text}; {WAY_OUT}")
