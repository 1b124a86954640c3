# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The voltage the valve takes: the last good command, or closed where there is none."""

import math

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE, NANOSECONDS_PER_SECOND
from rodless_base.parameters import Parameter, declare
from rodless_sim.physics.sources import JUDGEMENT

PARAMETERS = declare(
    Parameter(
        "valve.command_timeout",
        0.1,
        "s",
        "time without a command after which the node closes the valve",
        JUDGEMENT,
        1e-3,
        60.0,
        in_runs=False,
    )
)


class CommandInput:
    """Commands as they arrive, made safe: late or not finite closes the valve.

    Times are plant times in ns. The counters only grow, so that a fault stays visible after
    the run has recovered.
    """

    def __init__(self, closed_voltage: float, timeout: float) -> None:
        """Give ``closed_voltage`` (V) whenever no command came for ``timeout`` (s)."""
        self.configure(closed_voltage, timeout)
        self.received = self.clamped = self.not_finite = self.timeouts = 0
        self.reset()

    def configure(self, closed_voltage: float, timeout: float) -> None:
        """Change what is given when no command counts, and after how long (V, s)."""
        self._closed_voltage = closed_voltage
        self._timeout = round(timeout * NANOSECONDS_PER_SECOND)

    def reset(self) -> None:
        """Forget the last command; keep the counters."""
        self._voltage: float | None = None
        self._time = 0

    def receive(self, voltage: float, time: int) -> None:
        """Take a command that arrived at ``time`` (ns)."""
        self.received += 1
        self._time = time
        if not math.isfinite(voltage):
            self.not_finite += 1
            self._voltage = None
            return
        self._voltage = min(max(voltage, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE)
        self.clamped += self._voltage != voltage

    def voltage(self, time: int) -> float:
        """Return the voltage the valve takes at ``time`` (ns)."""
        if self._voltage is not None and time - self._time > self._timeout:
            self._voltage = None
            self.timeouts += 1
        return self._closed_voltage if self._voltage is None else self._voltage

    @property
    def present(self) -> bool:
        """Whether the valve follows a command now."""
        return self._voltage is not None
