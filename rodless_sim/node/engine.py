# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig, its command and its samples: what each time keeper (Realtime or Lockstep) shares."""

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.measurement import Measurement
from rodless_base.parameters import ParameterError
from rodless_sim.node.command import CommandInput
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.state import State
from rodless_sim.rig import Rig
from rodless_sim.scenario import AnyScenario, ScenarioError

# Takes each sample: what the instruments read, and the true state, which they do not show whole.
Publish = Callable[[Measurement, State], None]


class Engine:
    """A rig that steps by one period at a time and hands out each sample.

    Everything happens under one lock, the handing out too: a reset cannot overtake the sample
    before it. Where the simulation fails, the valve closes and nothing is handed out until a reset.
    """

    def __init__(
        self,
        parameters: RigParameters,
        publish: Publish,
        scenario: AnyScenario | None = None,
        changed: Callable[[RigParameters, int], None] = lambda _values, _time: None,
    ) -> None:
        """Build, compile and settle the rig; nothing is handed out yet.

        ``changed`` is told the parameters that the plant has from a time (ns) on, before the sample
        of that time is handed out. Raises ScenarioError for a scenario that this rig refuses.
        """
        self._publish = publish
        self._changed = changed
        self._lock = threading.RLock()
        self._failure: str | None = None
        self.resets = 0
        self._period = parameters.number("time.period")
        self._duration = round(parameters.number("time.duration") * NANOSECONDS_PER_SECOND)
        self.rig = Rig(parameters, scenario)
        # What fails here is said when it is stepped.
        with suppress(SimulationError, ScenarioError):
            self.rig.advance(self.rig.state.voltage, self._period)
        self.rig.read()
        self.rig.reset()
        self.command = CommandInput(*_command_settings(self.rig.parameters))
        self._follow()

    def change(self, changes: Mapping[str, object]) -> None:
        """Change parameters by name; the state stays as it is.

        Raises ParameterError for what the state does not allow, and nothing has changed then.
        """
        with self._lock:
            try:
                self.rig.configure(self.rig.parameters.with_values(changes))
            except SimulationError as error:
                raise ParameterError(str(error)) from error
            self._follow()

    def _follow(self) -> None:
        """Take over the parameters of the rig, which have changed."""
        values = self._values = self.rig.parameters
        self.command.configure(*_command_settings(values))
        self._changed(values, self.rig.nanoseconds)

    def receive(self, voltage: float) -> None:
        """Take a command (V)."""
        with self._lock:
            self.command.receive(voltage, self.rig.nanoseconds)
            if self._failure is not None:
                self.command.reset()

    @property
    def failure(self) -> str | None:
        """Why the simulation failed, if it did."""
        return self._failure

    @property
    def ended(self) -> bool:
        """Whether ``time.duration`` is over."""
        return 0 < self._duration <= self.rig.nanoseconds

    @property
    def state(self) -> State:
        """What the rig is at, between two steps and not within a change of its equations."""
        with self._lock:
            return self.rig.state

    @property
    def free_air_flow(self) -> float:
        """What it takes from the supply then; see :attr:`Rig.free_air_flow`."""
        with self._lock:
            return self.rig.free_air_flow

    def offer(self) -> None:
        """Hand out the present state."""
        with self._lock:
            if self._failure is None:
                self._hand_out()

    def step(self) -> None:
        """Advance by one period at the command in force, and hand out the sample."""
        with self._lock:
            if self._failure is not None:
                return
            voltage = self.command.voltage(self.rig.nanoseconds)
            try:
                state = self.rig.advance(voltage, self._period)
            except (SimulationError, ScenarioError) as error:
                self.fail(str(error))
                return
            if self.rig.parameters is not self._values:
                self._follow()
            self._publish(self.rig.read(), state)

    def fail(self, reason: str) -> None:
        """Close the valve; no step from now on until a reset."""
        with self._lock:
            self._failure = f"{reason}; valve closed, reset to go on"
            self.command.reset()

    def reset(self, offer: bool = True) -> None:
        """Return to the start, forget the command, hand out sample 0 unless not to ``offer``."""
        with self._lock:
            self._failure = None
            self.resets += 1
            self.command.reset()
            self.rig.reset()
            self._follow()
            if offer:
                self._hand_out()

    def _hand_out(self) -> None:
        self._publish(self.rig.read(), self.rig.state)


def _command_settings(parameters: RigParameters) -> tuple[float, float]:
    return parameters.number("valve.closed_voltage"), parameters.number("valve.command_timeout")
