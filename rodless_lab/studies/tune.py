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

The best of many candidates are the best partly by luck with the rigs of the task. So a task may let
``finalists`` meet once more on rigs that the search has not seen: the one that scores best there is
taken.
"""

import json
import math
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import Bounds, differential_evolution

from rodless_base.atomic_write import make_folder
from rodless_base.parameters import ParameterError
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.simulation.quantile import quantile
from rodless_lab.studies.base import Base
from rodless_lab.studies.journal import Journal
from rodless_lab.studies.own_file import LOCK, claim, locked
from rodless_lab.studies.saved_study import study_text
from rodless_lab.studies.tuning_task import TuningTask
from rodless_lab.studies.version import rules_digest
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

# The score of values that no law has together.
IMPOSSIBLE = 1e9

JOURNAL = "candidates.jsonl"
FINALS = "finalists.jsonl"
TASK = "task.json"


class Candidate(NamedTuple):
    """One set of values that was tried."""

    shares: tuple[float, ...]  # of the ranges
    score: float
    figures: dict[str, float]  # each figure that is scored, at the score's quantile, in its unit


class Tuned(NamedTuple):
    """What a search has found."""

    values: dict[str, float]
    best: Candidate
    candidates: list[Candidate]  # all that were tried, in order
    complete: bool
    converged: bool = False  # the last candidates score alike, and the search has ended early
    final_score: float | None = None  # of the best among the finalists, on the rigs of the finals


class _StoppedError(Exception):
    """The search was asked to stop."""


class _FailedError(Exception):
    """A candidate could not be tried; scipy would take its error for one of the map it calls."""

    def __init__(self, error: Exception) -> None:
        """Keep the error."""
        super().__init__()
        self.error = error


class NothingKnownError(Exception):
    """The search was interrupted before it knew a candidate."""


class Bench:
    """The rigs of a task, on which values of the law are tried."""

    def __init__(self, task: TuningTask) -> None:
        """Make the rigs."""
        self._task = task
        self._trials: list[tuple[Base, list[RigParameters]]] = [
            (study.base, [study.row(number).base.rig for number in range(len(study))])
            for study in (trial.study for trial in task.trials)
        ]

    def measured(self, values: dict[str, float]) -> list[Ensemble]:
        """Return the figures of all rigs with ``values``, by trial; raises ParameterError."""
        return [_measured(base.with_values(values), rigs) for base, rigs in self._trials]

    def candidate(self, shares: Array) -> Candidate:
        """Try the values at shares of their ranges."""
        key = tuple(map(float, shares))
        try:
            found = self.measured(self._task.values(shares))
        except ParameterError:
            return Candidate(key, IMPOSSIBLE, {})
        return Candidate(key, self._task.score(found), figures_of(self._task, found))


def _measured(base: Base, rigs: list[RigParameters]) -> Ensemble:
    return ensemble(
        rigs, base.controller, base.reference, base.duration, base.period, since=base.since
    )


def figures_of(task: TuningTask, found: Sequence[Ensemble]) -> dict[str, float]:
    """Return all figures that are scored, by their labels, at the quantile of the score."""
    return {
        trial.label(name): quantile(np.abs(one[name]), task.quantile)
        for trial, one in zip(task.trials, found, strict=True)
        for name in trial.score.figures
    }


class Candidates:
    """The candidates that were tried, by their shares; kept in a folder."""

    def __init__(self, folder: Path, task: TuningTask) -> None:
        """Open or make it.

        Raises StudyError where the folder is another task's, another process is at work, or a line
        is not as it was written; and OSError.
        """
        make_folder(folder)
        self._folder = folder
        self._only = locked(folder)
        try:
            text = task_text(task)
            claim(folder, TASK, text, "the search of another task")
            self._tried = Journal(folder / JOURNAL, text.encode())
            self._met = Journal(folder / FINALS, text.encode())
            candidates = [Candidate(tuple(shares), *rest) for shares, *rest in self._tried.known()]
            self.known = {one.shares: one for one in candidates}
            self.finals: dict[tuple[float, ...], float] = {
                tuple(shares): score for shares, score in self._met.known()
            }
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let others have the folder."""
        os.close(self._only)

    def forget(self) -> None:
        """Leave the folder, of which nothing is known, to any other search."""
        for file in (TASK, LOCK):
            (self._folder / file).unlink(missing_ok=True)
        with suppress(OSError):  # it holds something else
            self._folder.rmdir()

    def add(self, one: Candidate) -> None:
        """Keep a candidate."""
        self._tried.add(one)
        self.known[one.shares] = one

    def add_final(self, one: Candidate, score: float) -> None:
        """Keep how a finalist scores on the rigs of the finals."""
        self._met.add((one.shares, score))
        self.finals[one.shares] = score


def task_text(task: TuningTask) -> str:
    """Return all that the search depends on."""
    return json.dumps(
        {
            "sources": rules_digest(),
            "trials": [
                [one.name, json.loads(study_text(one.study)), one.score.figures]
                for one in task.trials
            ],
            "tune": {
                name: [one.low, one.high, one.logarithmic] for name, one in task.ranges.items()
            },
            "score": [task.quantile, task.mean_beyond],
            "search": [
                *(task.generations, task.population, task.seed, task.spread, task.finalists)
            ],
        },
        indent=1,
    )


def search(
    task: TuningTask,
    folder: Path,
    progress: Callable[[str], None] = lambda _text: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Tuned:
    """Look for the values that score best; go on with what ``folder`` knows already.

    The values in force come first and are among the finalists, so that the result is never worse,
    but for values that were outside of their ranges.
    ``progress`` is told how far the search is. Raises StudyError and OSError as
    :class:`Candidates`, and NothingKnownError where it is ``stopped`` before it knows anything.
    """
    bench, kept, best = Bench(task), Candidates(folder, task), math.inf
    asked: dict[tuple[float, ...], Candidate] = {}

    def score(shares: Array) -> float:
        nonlocal best
        key = tuple(map(float, shares))
        if key not in kept.known:
            # What is known comes whole, however early it is stopped: the result is of no less.
            if stopped():
                raise _StoppedError
            try:
                kept.add(bench.candidate(shares))
            except (ValueError, TypeError) as error:
                raise _FailedError(error) from error
        asked[key] = kept.known[key]
        best = min(best, asked[key].score)
        progress(f"{len(asked)} of {task.candidates} candidates, best score {best:.4g}")
        return asked[key].score

    complete, converged = True, False
    final: tuple[Candidate, float] | None = None
    try:
        found = differential_evolution(
            score,
            Bounds(np.zeros(len(task.ranges)), np.ones(len(task.ranges))),
            maxiter=task.generations,
            popsize=task.population,
            seed=np.random.default_rng(task.seed),
            init=_near_the_present(task) if task.spread else "latinhypercube",
            x0=task.present_shares,
            polish=False,
            updating="immediate",
            tol=1e-3,
        )
        converged = bool(found.success)
        if task.finalists:
            final = _final(task, kept, list(asked.values()), progress, stopped)
    except _FailedError as failed:
        raise failed.error from None
    except _StoppedError:
        complete = False
        if not asked:
            if not kept.known:
                kept.forget()
            raise NothingKnownError(
                f"{folder}: interrupted before the first candidate was known"
            ) from None
    finally:
        kept.close()
    tried = list(asked.values())
    taken, final_score = final or (min(tried, key=lambda one: one.score), None)
    values = task.values(np.array(taken.shares))
    return Tuned(values, taken, tried, complete, converged, final_score)


def _final(
    task: TuningTask,
    kept: Candidates,
    tried: Sequence[Candidate],
    progress: Callable[[str], None],
    stopped: Callable[[], bool],
) -> tuple[Candidate, float]:
    """Return the finalist that scores best on other rigs, and its score there."""
    benches = [Bench(one) for one in task.finals()]
    in_force, *others = tried
    finalists = [in_force, *sorted(others, key=lambda one: one.score)[: task.finalists - 1]]
    scores: list[float] = []
    for one in finalists:
        if one.shares not in kept.finals:
            if stopped():
                raise _StoppedError
            found = [bench.candidate(np.array(one.shares)).score for bench in benches]
            kept.add_final(one, float(np.mean(found)))
        scores.append(kept.finals[one.shares])
        progress(
            f"{len(scores)} of {len(finalists)} finalists on other rigs, best score "
            f"{min(scores):.4g}"
        )
    best = int(np.argmin(scores))
    return finalists[best], scores[best]


def _near_the_present(task: TuningTask) -> Array:
    """Return the first candidates about the values in force, shape (candidates, parameters)."""
    present = task.present_shares
    random = np.random.default_rng(task.seed)
    drawn = random.normal(present, task.spread, (task.generation_size, len(present)))
    return np.clip(drawn, 0.0, 1.0)
