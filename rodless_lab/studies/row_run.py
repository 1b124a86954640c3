# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One row of a study run: its figures, and its trace where the study wants one."""

from collections import deque
from typing import NamedTuple

from rodless_control import ControllerParameters
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, Loop
from rodless_lab.simulation.ensemble import outcome
from rodless_lab.simulation.run_metrics import RunMetrics, metrics_of
from rodless_lab.studies.base import Base
from rodless_lab.studies.study import Row

# Loops that are kept: one for each law of a study.
LOOPS = 8


class RowResult(NamedTuple):
    """What is kept of a row."""

    row: int
    metrics: RunMetrics
    failure: str  # why there are no figures; empty where there are
    traces: dict[str, list[float]]  # by column, decimated


class RowRunner:
    """Runs rows; those that differ in the rig alone share a loop. For several threads."""

    def __init__(self, columns: tuple[str, ...], every: int) -> None:
        """Keep every ``every``-th sample of ``columns`` of each run."""
        self._columns = columns
        self._every = every
        self._known: deque[tuple[ControllerParameters, Loop]] = deque(maxlen=LOOPS)

    def __call__(self, row: Row) -> RowResult:
        """Run a row; one that fails says so in its result."""
        traces: dict[str, list[float]] = {}

        def run() -> RunMetrics:
            loop = self._loop(row.base)
            found = loop.run(row.base.rig)
            if self._columns:
                traces.update(self._decimated(loop.traced(found)))
            return metrics_of(
                loop.times, loop.wanted, found.rows, found.flows, found.commands, row.base.since
            )

        metrics, failure = outcome(run)
        return RowResult(row.number, metrics, failure, traces)

    def _loop(self, base: Base) -> Loop:
        for controller, loop in list(self._known):
            if controller is base.controller:
                return loop
        loop = base.loop()
        self._known.appendleft((base.controller, loop))
        return loop

    def _decimated(self, run: ClosedLoopTrace) -> dict[str, list[float]]:
        columns = run.columns()
        return {name: columns[name][:: self._every].tolist() for name in self._columns}
