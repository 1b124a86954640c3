# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether positions still come: judged on the steady clock, by what the plant says of itself.

A plant that is paused, slow or waits for a command is told from a dead one by its diagnostics: it
goes on sending them. A real rig sends none; there, silence for the timeout is all there is.
"""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic_ns

from diagnostic_msgs.msg import DiagnosticStatus

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.ros.diagnostics import MODE, PERIOD, PRESET, TARGET_RATE

# How often, in wall-clock s, the controller polls its watch.
WATCH_PERIOD = 0.02

# Wall-clock s without a report after which a plant that sends them is silent: three have not come.
REPORT_TIMEOUT = 3.5 * PERIOD

# The shortest silence, in wall-clock s, that a simulated plant is taken for dead after. A busy
# machine stops its processes for longer than the default timeout, and plant time with them.
STALL = 0.5

# Samples of a slow plant that must have failed to come.
MISSED_SAMPLES = 3.0


@dataclass(frozen=True)
class PlantReport:
    """What a simulated plant says of its time."""

    mode: str  # realtime or lockstep
    preset: str
    rate: float  # Hz, samples due per wall-clock s; 0 while none is due by the clock

    def text(self) -> str:
        """Return mode, preset and rate in words; the controller's own gains may be others."""
        rate = [f"{self.rate:g} Hz"] if self.rate else []
        preset = [f"plant's preset {self.preset}"] if self.preset else []
        return ", ".join([self.mode, *preset, *rate])


def plant_report(status: DiagnosticStatus, namespace: str) -> PlantReport | None:
    """Return what ``status`` reports of the plant in ``namespace``, None if of something else.

    The plant's node may have any name.
    """
    values = {pair.key: pair.value for pair in status.values}
    if (status.name.rpartition("/")[0] or "/") != namespace or MODE not in values:
        return None
    try:
        rate = float(values[TARGET_RATE])
    except (KeyError, ValueError):
        return None
    return PlantReport(values[MODE], values.get(PRESET, ""), rate)


class PositionWatch:
    """Adds up silence between polls.

    A poll that comes late counts as one that does not: the controller itself was stopped then,
    and what has come meanwhile still waits in its queues.
    """

    def __init__(self, now: Callable[[], int] = monotonic_ns) -> None:
        """Begin with a position that has just come; ``now`` is a steady time in ns."""
        self._now = now
        self._polled = now()
        self._positions_silent = self._reports_silent = 0.0  # s
        self.report: PlantReport | None = None

    @property
    def reports_come(self) -> bool:
        """Whether one has come lately, or there was no time for the first."""
        return self._reports_silent <= REPORT_TIMEOUT

    def arrive(self) -> None:
        """Take note of a position."""
        self._positions_silent = 0.0
        if not self.reports_come:
            # Whoever sends these now is not the plant that has reported.
            self.report = None

    def hear(self, report: PlantReport) -> None:
        """Take what the plant reports."""
        if self.report is not None and not self.report.rate and report.rate:
            # A plant that goes on after a pause owes nothing for the time before.
            self._positions_silent = 0.0
        self._reports_silent = 0.0
        self.report = report

    def poll(self) -> None:
        """Let the time since the last poll pass."""
        now = self._now()
        elapsed = (now - self._polled) / NANOSECONDS_PER_SECOND
        self._polled = now
        silence = min(elapsed, 2.0 * WATCH_PERIOD)
        self._positions_silent += silence
        self._reports_silent += silence

    def missing(self, timeout: float, simulated: bool) -> bool:
        """Whether positions have stopped coming for ``timeout`` (wall-clock s; 0: never).

        ``simulated``: a plant that has said nothing yet may be paused, and is waited for as
        long as for a report.
        """
        if timeout <= 0.0:
            return False
        if self.report is None:
            longest = max(timeout, REPORT_TIMEOUT) if simulated else timeout
        elif self.report.rate:
            longest = max(timeout, STALL, MISSED_SAMPLES / self.report.rate)
        else:
            return self._reports_silent > max(timeout, REPORT_TIMEOUT)
        return self._positions_silent > longest
