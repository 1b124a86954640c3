# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a session tells the rig: set-points, voltages, parameters; and what the nodes say."""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import cast

from rclpy.publisher import Publisher
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.one_line import shown
from rodless_base.real_number import is_number
from rodless_base.ros.diagnostics import ENABLED
from rodless_base.topics import SETPOINT
from rodless_control import ControllerParameters
from rodless_control.node.answers import CLOSED_BY_FAILURE
from rodless_control.setpoint import FROM_PARAMETERS
from rodless_lab.session.commands import Alteration, Law, OwnCommands, RelayedCommands, voltage_of
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.errors import HarnessError, RefusedError, WaitTimeoutError
from rodless_lab.session.live_session import LiveSession
from rodless_lab.session.processes import ProcessPlan
from rodless_lab.session.running_rig import CONTROLLER
from rodless_lab.session.setpoint import (
    has_arrived,
    setpoint_is_heard,
    warn_of_late_setpoint,
)

# Names of the range of set-points that the controller of this package takes.
RANGE = ("reference.minimum", "reference.maximum")

# The parameter that says where its reference comes from.
TYPE = "reference.type"

# For a set-point to arrive, in wall-clock s; a frozen controller takes none.
ARRIVAL_TIMEOUT = 1.0

# For the answer to the sample at which a plant stands, in wall-clock s: one that was started anew
# beside relayed commands has none to give.
ANSWER_TIMEOUT = 10.0


class Controls(LiveSession):
    """The methods of a session that command the rig and change its parameters."""

    _plan: ProcessPlan
    _setpoint: Publisher

    def setpoint(self, position: float) -> None:
        """Send a set-point (m); by the return, a controller that runs has received it.

        Raises ValueError for what is no finite number, RefusedError for what the controller of this
        package does not take: out of its range, beside a reference of its own, switched off, or its
        law failed; and HarnessError where the test has ended the controller.
        Warns with SetpointWarning where it has not arrived in a second: a frozen controller takes
        it once it is thawed.
        """
        if not is_number(position) or not math.isfinite(position):
            raise ValueError(f"setpoint {shown(position)} refused, must be a finite number (m)")
        self._check_range(float(position))
        self._check_inside()
        self._processes.check_node("controller", "no controller will take a set-point")
        self._check_follows(float(position))
        self._wait_for_controller()
        self._let_controller_answer()
        self._setpoint.publish(Float64(data=float(position)))
        try:
            self._wait(
                lambda: has_arrived(self._setpoint),
                "the set-point to arrive",
                ARRIVAL_TIMEOUT,
            )
        except WaitTimeoutError:
            warn_of_late_setpoint(position, ARRIVAL_TIMEOUT)
        self._catch_up()

    @cached_property
    def _first(self) -> ControllerParameters:
        """What the controller began with that says which set-points it takes."""
        given = self._plan.controller
        told = given if isinstance(given, Mapping) else {}
        return ControllerParameters.preset(self._plan.preset).with_values(
            {name: told[name] for name in (*RANGE, TYPE) if name in told}
        )

    def _check_range(self, position: float) -> None:
        """Ask a controller of this package, but within the range that it began with."""
        if not self._plan.runs_controller_node:
            return
        low, high = map(self._first.number, RANGE)
        if low <= position <= high and not self._range_changed:
            return
        low, high = (cast(float, one) for one in self.parameters("controller", RANGE).values())
        if not low <= position <= high:
            raise RefusedError(
                f"setpoint {position:.12g} m refused, must be from {low:.12g} to {high:.12g} m "
                f"({', '.join(RANGE)})"
            )

    def _check_follows(self, position: float) -> None:
        """Raise RefusedError where a controller of this package, as the test has it, takes none."""
        if not self._plan.runs_controller_node:
            return
        refused = f"setpoint {position:g} m refused"
        if self._switched_off and self._is_off():
            raise RefusedError(f"{refused}, the controller is disabled; enable_controller() first")
        if (failure := self._failure_of_the_law()) is not None:
            raise RefusedError(f"{refused}, {failure}")
        if (self._reference_type or self._first.text(TYPE)) not in FROM_PARAMETERS:
            return
        kind = self.parameters("controller", [TYPE])[TYPE]
        if kind in FROM_PARAMETERS:
            raise RefusedError(
                f"{refused}, {TYPE} is {kind}; set-points need setpoint, ramp or move"
            )

    def _is_off(self) -> bool:
        """Whether the controller is: others may have switched it on again."""
        return self._observer.diagnostic("controller", fresh=True).values.get(ENABLED) == "False"

    def _failure_of_the_law(self) -> str | None:
        """Return what a controller says whose law has failed: it may have begun anew since."""
        self._observer.take_waiting_diagnostics()
        said = self._observer.diagnostics.get(self._observer.node.resolve_topic_name(CONTROLLER))
        if said is None or CLOSED_BY_FAILURE not in said.message:
            return None
        try:
            message = self._observer.diagnostic(CONTROLLER, fresh=True).message
        except WaitTimeoutError:  # frozen since then
            message = said.message
        return message if CLOSED_BY_FAILURE in message else None

    def _let_controller_answer(self) -> None:
        """Let a controller answer the sample at which a lock-step plant stands.

        What it is told then acts from the next sample on, in every repetition: before, it would
        depend on which of the two the controller takes first.
        """
        stands = self._relayed is not None or (self._paused and self._has_controller)
        if self._mode != "lockstep" or not stands or self._processes.is_held("controller"):
            return
        answers, last = self._received.answers, self._received.last_sent
        with suppress(WaitTimeoutError):
            self._wait(
                lambda: answers and answers[-1].sent > last,
                "the controller to answer",
                ANSWER_TIMEOUT,
            )

    def _wait_for_controller(self) -> None:
        self._wait(
            lambda: setpoint_is_heard(self._observer.node, self._setpoint),
            f"a controller to listen to {SETPOINT}",
        )

    def send_voltage(self, voltage: float) -> None:
        """Send one command (V), NaN included; in lock-step wait for the sample that it answers.

        Raises HarnessError where a controller does so, for what is no number, in a law of
        :meth:`drive` in lock-step, once the session's ``duration`` is over, and where the test has
        ended the plant.
        """
        commands = self._commander("send_voltage")
        command, sample = voltage_of(voltage, "send_voltage"), "a sample for the command"
        waits = self._mode == "lockstep"

        def due() -> bool:
            if waits and self._is_heard:
                commands.answer_again()
                if commands.is_due:
                    return True
            self._processes.check_plant()
            if not waits:  # a test that only sends has not heard how far the plant is
                self._receiver.take_waiting(time.time_ns())
            self._check_goes_on(sample)
            return not waits

        self._wait(due, sample)
        commands.send(command)

    def drive(self, law: Law | float | None) -> None:
        """Answer every sample from now on by ``law``, a function or a voltage (V).

        A law that returns None loses its command, for which a lock-step plant would wait: there it
        is refused. None in place of a law ends the answers. Raises HarnessError for what is no law.
        """
        commands = self._commander("drive")
        commands.drive(_as_law(law), from_now=self._mode == "realtime")

    def _commander(self, what: str) -> OwnCommands:
        self._check_inside()
        if self._own is None:
            raise HarnessError(f"{what}: the controller of this session sends the commands")
        return self._own

    def alter_commands(self, alteration: Alteration | None) -> None:
        """Pass the controller's commands (V) through a function; what it makes None is lost.

        Needs ``relay_commands``. None passes them on as they are.
        """
        relayed = self._relayed_commands("alter_commands")
        if alteration is not None and not callable(alteration):
            raise ValueError(
                f"alter_commands: {shown(alteration)} refused, must be a function of a voltage, or "
                "None"
            )
        relayed.alter = alteration

    def _relayed_commands(self, what: str) -> RelayedCommands:
        self._check_inside()
        if self._relayed is None:
            raise HarnessError(f"{what}: start the session with relay_commands")
        return self._relayed

    @contextmanager
    def commands_lost(self) -> Iterator[None]:
        """Lose every command inside the block; needs ``relay_commands`` and real time.

        Behind it they go on as before. A lock-step plant would stand still for good: make its
        commands NaN instead.
        """
        if self._mode == "lockstep":
            raise HarnessError("commands_lost: a lock-step plant waits for its commands")
        relayed = self._relayed_commands("commands_lost")
        before, relayed.alter = relayed.alter, lambda _: None
        try:
            yield
        finally:
            relayed.alter = before

    def enable_controller(self, enabled: bool = True) -> None:
        """Switch the PID on, or off: the valve is then commanded closed.

        Switched on again it holds the carriage where it is until a new set-point comes, or follows
        the step or sine that its reference is. Raises RefusedError where its law fails at once.
        """
        self._let_controller_answer()
        self._ask(SetBool, "controller/enable", data=enabled)
        self._switched_off = not enabled
        self._catch_up()

    def reset_controller(self) -> None:
        """Let the PID forget the run so far, the set-point too."""
        self._let_controller_answer()
        self._ask(Trigger, "controller/reset")
        self._catch_up()

    def set_parameters(self, node: str, values: Mapping[str, object]) -> None:
        """Set parameters of a node (``plant``, ``controller``) as one change.

        Raises RefusedError with the node's reason, and then nothing has changed. A plant that has
        not had such an option before, on this machine, is compiled first, which takes a minute.
        """
        if not isinstance(values, Mapping):
            raise TypeError(f"{shown(values)} refused, must be values by name: {{name: value}}")
        of_controller = str(node).lstrip("/") == "controller"
        if of_controller:
            self._let_controller_answer()
        with self._asking(node):
            self._observer.once_ready(
                lambda: self._observer.set_parameters(node, values), self._timeout
            )
        if of_controller:
            self._reference_type = str(values.get(TYPE, self._reference_type))
            self._range_changed |= not values.keys().isdisjoint(RANGE)
        self._catch_up()

    def parameters(self, node: str, names: Sequence[str]) -> dict[str, object]:
        """Return the values of a node's parameters; raises RefusedError for unknown names."""
        if isinstance(names, str):
            raise TypeError(f"{names!r} refused, must be a list of names: [{names!r}]")
        with self._asking(node):
            return self._observer.get_parameters(node, names)

    def diagnostics(self, node: str) -> dict[str, str]:
        """Return what a node last said on ``/diagnostics``: its ``message`` and its counters."""
        found = self._said(node)
        return {} if found is None else {"message": found.message, **found.values}

    def counter(self, node: str, name: str) -> float:
        """Return a counter of :meth:`diagnostics`, NaN before the node has said anything.

        Raises HarnessError for what the node does not count, and for what is no number.
        """
        found = self._said(node)
        return math.nan if found is None else found.number(name, node)

    def _said(self, node: str) -> Diagnostic | None:
        return self._observer.diagnostics.get(f"/{node.removeprefix('/')}")


def _as_law(law: Law | float | None) -> Law | None:
    if law is None or callable(law):
        return law
    voltage = voltage_of(law, "drive")
    return lambda _: voltage
