# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""All laws at all tasks on the same rigs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_lab.benchmark.laws.entries import Entry
from rodless_lab.benchmark.laws.tasks import Task
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.simulation.quantile import quantile
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# A limit cycle has at least this amplitude (m): ten times what parking leaves.
LIMIT_CYCLE = 25e-6


@dataclass(frozen=True)
class Score:
    """What one law has made of one task."""

    entry: Entry
    task: Task
    runs: Ensemble

    def quantiles(self, figure: str, scale: float = 1.0) -> tuple[float, float, float]:
        """Median, 90 % and worst of the size of a figure; a run without it counts as infinite."""
        values = np.abs(self.runs[figure]) * scale
        return quantile(values, 0.5), quantile(values, 0.9), quantile(values, 1.0)

    def count(self, figure: str, beyond: float) -> int:
        """How many runs are beyond a size of a figure, or have none."""
        return int(np.sum(~(np.abs(self.runs[figure]) <= beyond)))


def score(entry: Entry, task: Task, drawn: Sequence[RigParameters]) -> Score:
    """Let one law do one task on all rigs."""
    return Score(
        entry,
        task,
        ensemble(
            map(task.rig, drawn),
            entry.law,
            task.reference,
            task.duration,
            task.period,
            position=task.position,
            since=task.since,
            scenario=task.scenario,
        ),
    )


def contest(
    entries: Sequence[Entry],
    tasks: Sequence[Task],
    drawn: Sequence[RigParameters],
    progress: Callable[[str], None],
    stop: Callable[[], bool],
) -> list[Score]:
    """Return all scores, those of one task together; fewer where ``stop`` says so."""
    found: list[Score] = []
    for task in tasks:
        progress(task.name)
        for entry in entries:
            if stop():
                return found
            found.append(score(entry, task, drawn))
    return found
