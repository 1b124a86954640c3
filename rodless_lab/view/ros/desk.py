# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages ask of the rig, done in one thread, one after the other, as the other verbs do it."""

import math
import queue
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import ParameterEvent

from rodless_base.one_line import traced
from rodless_base.start import Stop
from rodless_base.topics import PARAMETER_EVENTS
from rodless_control.parameters import LAW
from rodless_lab.session.errors import HarnessError, InterruptedRunError, WaitTimeoutError
from rodless_lab.session.observer import python_value
from rodless_lab.session.running_rig import NODES, RunningRig
from rodless_lab.session.services import ask_each
from rodless_lab.session.set_parameters import change_parameters, failed_law
from rodless_lab.session.status import LEVELS
from rodless_lab.view.errors import ViewError
from rodless_lab.view.state import CONTROLLER, PLANT, NodeState, ViewState, number_in

# For each answer of a node, in wall-clock s.
ANSWER_TIMEOUT = 5.0

# Longest wait for a request, in wall-clock s.
SPIN_SECONDS = 0.02

# A report may have been under way while a set-point was heard; in wall-clock s.
REPORT_SECONDS = 1.0

Job = Callable[[RunningRig], Any]


class Desk:
    """Runs requests and keeps what the nodes say of themselves in the state."""

    def __init__(self, rig: RunningRig, state: ViewState) -> None:
        """Serve ``rig``; :meth:`serve` does the work."""
        self._rig = rig
        self._state = state
        self._jobs: queue.SimpleQueue[tuple[Job, Future[Any]]] = queue.SimpleQueue()
        self._stale = set(NODES)
        self._asked_at = dict.fromkeys(NODES, -math.inf)  # when the report came, by node
        self._run = -1
        self._closed = False
        rig.observer.subscribe(ParameterEvent, PARAMETER_EVENTS, self._take_event)

    # From any thread

    def set_parameters(self, given: Mapping[str, str]) -> "Future[None]":
        """Set parameters, all or none, to what their texts stand for."""

        def change(rig: RunningRig) -> None:
            changes = change_parameters(rig, given, ANSWER_TIMEOUT)
            for one in changes:
                self._state.take_parameters(one.node, {one.name: one.new})
            has_changed = any(one.node == CONTROLLER for one in changes)
            failure = failed_law(rig) if has_changed else None
            if failure is not None:
                raise ViewError(f"{CONTROLLER}: {failure}; the new values are in force")

        return self._ask(change)

    def call(self, services: Mapping[str, bool | None], times: int = 1) -> "Future[None]":
        """Call services by ``node/service``, as ``rodless pause`` and the like do."""

        def call(rig: RunningRig) -> None:
            for _ in range(times):
                for _answer in ask_each(rig, services, ANSWER_TIMEOUT):
                    pass

        return self._ask(call)

    def _ask(self, job: Job) -> "Future[None]":
        asked: Future[None] = Future()
        if self._closed:
            asked.set_exception(ViewError("the view is ending"))
        else:
            self._jobs.put((job, asked))
        return asked

    # In the thread that serves

    def serve(self, stop: Stop, check: Callable[[], object] = lambda: None) -> None:
        """Work until ``stop``; ``check`` is called over and over."""
        try:
            while not stop.requested:
                check()
                self._next_job()
                self._rig.observer.spin(SPIN_SECONDS)
                self._look()
        except InterruptedRunError:
            pass
        finally:
            self._closed = True
            self._refuse_the_rest()

    def _next_job(self) -> None:
        try:
            job, asked = self._jobs.get_nowait()
        except queue.Empty:
            return
        if not asked.set_running_or_notify_cancel():
            return
        try:
            asked.set_result(job(self._rig))
        except WaitTimeoutError as error:
            asked.set_exception(ViewError("; ".join([str(error), *self._rig.obstacles()])))
        except HarnessError as error:
            asked.set_exception(ViewError(str(error)))
        except InterruptedRunError:
            asked.set_exception(ViewError("the view is ending"))
            raise
        except ViewError as error:
            asked.set_exception(error)
        except Exception as error:  # the page that has asked is to hear of it, whatever it is
            asked.set_exception(ViewError(f"not done: {traced(error)}"))

    def _refuse_the_rest(self) -> None:
        while not self._jobs.empty():
            _job, asked = self._jobs.get_nowait()
            # A page that has closed has cancelled what it asked for.
            if asked.set_running_or_notify_cancel():
                asked.set_exception(ViewError("the view is ending"))

    def _look(self) -> None:
        run = self._state.history.run
        if run != self._run:  # a plant that was reset, or is another
            self._run = run
            self._stale.update(NODES)
        for node in NODES:
            self._look_at(node)

    def _look_at(self, node: str) -> None:
        said = self._rig.diagnostic(node)
        if said is None or self._rig.is_silent(node):
            self._stale.add(node)
            known = said is not None or self._rig.is_known(node)
            message = self._rig.state_of(node) if known else "not found"
            self._state.nodes[node] = NodeState("missing", message)
            return
        level = LEVELS.get(said.level, LEVELS[DiagnosticStatus.ERROR])
        self._state.nodes[node] = NodeState(level, said.message, said.values)
        if node == CONTROLLER and said.arrived > self._state.target_heard + REPORT_SECONDS:
            self._state.target = number_in(said.values.get("set-point (m)"))
        if node in self._stale and said.arrived > self._asked_at[node]:
            self._asked_at[node] = said.arrived
            self._read_parameters(node)

    def _read_parameters(self, node: str) -> None:
        """Read all parameters of a node, which is there; tried again with its next report."""
        unknown = f"{node}: its parameters are not known"
        try:
            names = self._rig.observer.parameter_names(node)
            values = self._rig.observer.get_parameters(node, names)
        except HarnessError as error:
            self._state.problem = f"{unknown}: {error}"
            return
        self._stale.discard(node)
        if (self._state.problem or "").startswith(unknown):
            self._state.problem = None
        self._state.take_parameters(node, values, whole=True)

    def _take_event(self, event: ParameterEvent) -> None:
        """Follow what others change."""
        for node in (PLANT, CONTROLLER):
            if event.node == self._rig.name(node):
                values = {
                    one.name: python_value(one.value)
                    for one in (*event.new_parameters, *event.changed_parameters)
                }
                self._state.take_parameters(node, values)
                if LAW in values:  # another law has parameters of its own
                    self._stale.add(node)
