# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Tuning: the parameters of a law that score best over many rigs, by differential evolution.

Storn and Price, Journal of Global Optimization 11, 1997, as scipy's ``differential_evolution``.
Each candidate is kept in a journal as soon as its score is known. The search is the same for the
same seed, so that one that goes on after an interruption asks for the same candidates again, finds
them there, and ends where one that was never interrupted does.
"""

import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import Bounds, differential_evolution

from rodless_base.kernels import source_digest
from rodless_base.parameters import ParameterError
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.journal import add_line, claim, known_lines, locked
from rodless_lab.studies.saved_study import study_text
from rodless_lab.studies.study import Study
from rodless_lab.studies.tuning_task import TuningTask
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# The score of values that no law has together.
IMPOSSIBLE = 1e9

JOURNAL = "candidates.jsonl"
TASK = "task.json"


class Candidate(NamedTuple):
    """One set of values that was tried."""

    shares: tuple[float, ...]  # of the ranges
    score: float
    figures: dict[str, float]  # each figure of the score at the score's quantile, in its unit


class Tuned(NamedTuple):
    """What a search has found."""

    values: dict[str, float]
    best: Candidate
    candidates: list[Candidate]  # all that were tried, in order
    complete: bool


class _StoppedError(Exception):
    """The search was asked to stop."""


class Bench:
    """The rigs of a task, on which values of the law are tried."""

    def __init__(self, task: TuningTask, study: Study | None = None) -> None:
        """Make the rigs, those of ``study`` in place of the task's own."""
        chosen = study or task.study
        self._task = task
        self._base = chosen.base
        self._rigs: list[RigParameters] = [
            chosen.row(number).base.rig for number in range(len(chosen))
        ]

    def measured(self, values: dict[str, float]) -> Ensemble:
        """Return the figures of all rigs with ``values``; raises ParameterError."""
        base = self._base.with_values(values)
        return ensemble(
            self._rigs, base.controller, base.reference, base.duration, base.period,
            since=base.since,
        )  # fmt: skip

    def candidate(self, shares: Array) -> Candidate:
        """Try the values at shares of their ranges."""
        score = self._task.score
        key = tuple(map(float, shares))
        try:
            found = self.measured(self._task.values(shares))
        except ParameterError:
            return Candidate(key, IMPOSSIBLE, {})
        return Candidate(key, score.of(found), figures_at(found, score.figures, score.quantile))


def figures_at(found: Ensemble, names: dict[str, float], quantile: float) -> dict[str, float]:
    """Return figures at a quantile over the rigs; infinite where too many rigs have none."""
    return {
        name: float(
            np.quantile(
                np.where(np.isnan(found[name]), np.inf, np.abs(found[name])),
                quantile,
                method="higher",
            )
        )
        for name in names
    }


class Journal:
    """The candidates that were tried, by their shares; kept in a file."""

    def __init__(self, folder: Path, task: TuningTask) -> None:
        """Open or make it.

        Raises StudyError where the folder is another task's or another process is at work, and
        OSError.
        """
        folder.mkdir(parents=True, exist_ok=True)
        claim(folder, TASK, task_text(task), "the search of another task")
        self._path = folder / JOURNAL
        self._only = locked(folder, "another search")
        self.known = {
            tuple(shares): Candidate(tuple(shares), score, figures)
            for shares, score, figures in known_lines(self._path)
        }

    def close(self) -> None:
        """Let others have the folder."""
        os.close(self._only)

    def add(self, one: Candidate) -> None:
        """Keep a candidate."""
        add_line(self._path, one)
        self.known[one.shares] = one


def task_text(task: TuningTask) -> str:
    """Return all that the search depends on."""
    return json.dumps(
        {
            "sources": source_digest(),
            "study": json.loads(study_text(task.study)),
            "tune": {
                name: [one.low, one.high, one.logarithmic] for name, one in task.ranges.items()
            },
            "score": [task.score.figures, task.score.quantile],
            "search": [task.generations, task.population, task.seed],
        },
        indent=1,
    )


def search(
    task: TuningTask,
    folder: Path,
    progress: Callable[[int, float], None] = lambda _count, _best: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Tuned:
    """Look for the values that score best; go on with what ``folder`` knows already.

    The values in force come first, so that the result is never worse. ``progress`` is told how many
    candidates are known and the best score. Raises StudyError and OSError as :class:`Journal`.
    """
    bench, journal = Bench(task), Journal(folder, task)
    asked: dict[tuple[float, ...], Candidate] = {}

    def score(shares: Array) -> float:
        if stopped():
            raise _StoppedError
        key = tuple(map(float, shares))
        if key not in journal.known:
            journal.add(bench.candidate(shares))
        asked[key] = journal.known[key]
        progress(len(asked), min(one.score for one in asked.values()))
        return asked[key].score

    complete = True
    try:
        differential_evolution(
            score,
            Bounds(np.zeros(len(task.ranges)), np.ones(len(task.ranges))),
            maxiter=task.generations,
            popsize=task.population,
            seed=np.random.default_rng(task.seed),
            x0=present_shares(task),
            polish=False,
            updating="immediate",
            tol=1e-3,
        )
    except _StoppedError:
        complete = False
        if not asked:
            raise StudyError(
                f"{folder}: interrupted before the first candidate was known"
            ) from None
    finally:
        journal.close()
    best = min(asked.values(), key=lambda one: one.score)
    return Tuned(task.values(np.array(best.shares)), best, list(asked.values()), complete)


def present_shares(task: TuningTask) -> Array:
    """Return where in their ranges the values in force are; the nearer end for those outside."""
    found: list[float] = []
    for name, one in task.ranges.items():
        value = task.study.base.controller.number(name)
        inside = min(max(value, one.low), one.high)
        if one.logarithmic:
            found.append(math.log(inside / one.low) / math.log(one.high / one.low))
        else:
            found.append((inside - one.low) / (one.high - one.low))
    shares: Array = np.clip(np.array(found), 0.0, 1.0)
    return shares
