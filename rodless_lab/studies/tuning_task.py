# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A tuning task: which parameters of a law to choose, over which rigs, by which score."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import in_one_line
from rodless_control.parameters import LAW
from rodless_lab.simulation.design import LARGEST_SEED, Range
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.quantile import mean_beyond, quantile
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.base import refuse_of_both
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.fields import Fields
from rodless_lab.studies.shipped import find_file
from rodless_lab.studies.study import (
    FIELDS,
    GRID,
    Study,
    check_rows,
    check_set,
    read_dimension,
    study_of,
)

Array = npt.NDArray[np.float64]

# What a trial may change of the task's study, and what it has in common with the others.
CHANGED = ("set", "vary", "run")
COMMON = ("base", "sensors", "design")

# What a rig costs that a figure has no number for: it never settled, or its run failed.
NEVER = 10.0

# Shares that are no further apart are the same: the search moves the last digits.
SAME_SHARE = 1e-12

# Generations, and candidates of a generation for each parameter, at most.
LARGEST_SEARCH = 10_000
MOST_FINALISTS = 1000

# On how many draws of as many rigs the finalists of a search meet.
FINAL_DRAWS = 3


@dataclass(frozen=True)
class Score:
    """What a rig's figures cost.

    A rig costs the sum of its figures, each divided by the size at which it costs 1; a figure that
    a rig does not have costs ``NEVER``.
    """

    figures: dict[str, float]  # by name: the size at which it costs 1, in its unit

    def costs(self, found: Ensemble) -> Array:
        """Return what each rig costs, shape (n,)."""
        total = np.zeros(len(found))
        for name, size in self.figures.items():
            share = np.abs(found[name]) / size
            total += np.where(np.isnan(share), NEVER, np.minimum(share, NEVER))
        return total


@dataclass(frozen=True)
class Trial:
    """One thing that each rig of a task has to do, and what its figures cost."""

    name: str  # empty where a task has no others
    study: Study  # whose rows are the rigs
    score: Score

    def label(self, figure: str) -> str:
        """Return what a figure of this trial is called."""
        return f"{self.name}: {figure}" if self.name else figure


@dataclass(frozen=True)
class TuningTask:
    """What a task's file says; :func:`read_task` reads one.

    The score of a law is a quantile, over the rigs, of what they cost in all trials together: near
    1 it is the worst rigs that count. With ``mean_beyond`` it is the mean of the costs from that
    quantile on, its own among them: it changes with each of the worst rigs, and not with one of
    them alone, as the conditional value at risk (Rockafellar and Uryasev, Journal of Risk 2, 2000).
    """

    name: str
    trials: tuple[Trial, ...]  # of the same rigs
    ranges: dict[str, Range]  # of the law's parameters
    quantile: float
    generations: int
    population: int  # candidates of a generation for each parameter
    seed: int
    mean_beyond: bool = False
    # Standard deviation of the first candidates about the values in force, as a share of the
    # ranges; 0: they are spread evenly over the ranges.
    spread: float = 0.0
    # How many of the best candidates meet once more, on rigs that the search has not seen; 0: none.
    finalists: int = 0

    @property
    def study(self) -> Study:
        """The study of the first trial."""
        return self.trials[0].study

    def score(self, found: Sequence[Ensemble]) -> float:
        """Return the score of what the rigs have done in each trial."""
        costs = [trial.score.costs(one) for trial, one in zip(self.trials, found, strict=True)]
        total: Array = np.sum(costs, axis=0)
        return (mean_beyond if self.mean_beyond else quantile)(total, self.quantile)

    def finals(self) -> "list[TuningTask]":
        """Return the same task with as many rigs that the search has not seen, several times."""
        return [self._redrawn(k) for k in range(1, FINAL_DRAWS + 1)] if self.finalists else []

    def other_rigs(self) -> "TuningTask":
        """Return the same task with as many rigs that neither search nor finals have seen."""
        return self._redrawn(len(self.finals()) + 1)

    def _redrawn(self, times: int) -> "TuningTask":
        others = (replace(one, study=_redrawn(one.study, times)) for one in self.trials)
        return replace(self, trials=tuple(others))

    def values(self, shares: Array) -> dict[str, float]:
        """Return the parameters at shares of their ranges, shape (parameters,).

        At the share of a value in force it is that value, to the last digit.
        """
        found = {
            name: one.at(float(share))
            for (name, one), share in zip(self.ranges.items(), shares, strict=True)
        }
        in_force, outside = np.abs(shares - self.present_shares) < SAME_SHARE, self.outside()
        for (name, value), here in zip(self.present().items(), in_force, strict=True):
            if here and name not in outside:
                found[name] = value
        return found

    @property
    def candidates(self) -> int:
        """How many candidates a whole search tries at most."""
        return (self.generations + 1) * self.generation_size

    @property
    def generation_size(self) -> int:
        """How many candidates a generation has; differential evolution wants five."""
        return max(5, self.population * len(self.ranges))

    def outside(self) -> dict[str, float]:
        """Return the values in force that are outside of their ranges."""
        return {
            name: value
            for name, value in self.present().items()
            if not self.ranges[name].low <= value <= self.ranges[name].high
        }

    def present(self) -> dict[str, float]:
        """Return the values that the law has before it is tuned."""
        return {name: self.study.base.controller.number(name) for name in self.ranges}

    @cached_property
    def present_shares(self) -> Array:
        """Where in their ranges the values in force are; the nearer end for those outside."""
        return np.array([self.ranges[name].share(value) for name, value in self.present().items()])


def _redrawn(study: Study, times: int) -> Study:
    """Return as many other rigs: of a grid, which has no others, drawn at random within it."""
    seed = (study.seed + times) % LARGEST_SEED
    if study.method == GRID:
        return replace(study, seed=seed, method="random", count=len(study))
    return replace(study, seed=seed)


def read_task(given: str | Path) -> TuningTask:
    """Read a task (docs/tuning.md), a YAML file or the name of one that ships.

    Raises StudyError in one line with file, key, value and the way out; nothing has run then.
    """
    path = find_file("tasks", given)
    fields = Fields.of_file(path, (*FIELDS, "tune", "trials", "score", "search"))
    ranges = _ranges(fields.below("tune"))
    score = fields.below("score")
    share = score.number("quantile", 0.9, 0.0, 1.0)
    mean_beyond = score.flag("mean_beyond")
    search = fields.below("search")
    sizes = {
        name: search.whole(name, default, 1, LARGEST_SEARCH)
        for name, default in (("generations", 30), ("population", 8))
    }
    seed = search.whole("seed", 1, 0, LARGEST_SEED)
    spread = search.number("spread", 0.0, 0.0, 1.0)
    finalists = search.whole("finalists", 0, 0, MOST_FINALISTS)
    if finalists == 1:
        raise search.error(
            "finalists", "1 refused, it is the values in force; must be 0, 2 or more"
        )
    search.end()
    trials = tuple(_trials(fields, score, path))
    check_set(fields.below("set"), [trial.study for trial in trials])
    score.end()
    task = TuningTask(
        path.stem,
        trials,
        ranges,
        share,
        seed=seed,
        mean_beyond=mean_beyond,
        spread=spread,
        finalists=finalists,
        **sizes,
    )
    _check_trials(task, str(path))
    _check_ranges(task, str(path))
    for name in ranges:
        refuse_of_both(fields, "tune", name, task.study.base.by_law)
    # After hours of search they would be refused all the same.
    for others in (*task.finals(), task.other_rigs()):
        for trial in others.trials:
            place = f"{path}: of the rigs that the search does not see, by seed {trial.study.seed}"
            check_rows(trial.study, place)
    return task


def _ranges(fields: Fields) -> dict[str, Range]:
    found: dict[str, Range] = {}
    for name in fields.values:
        one = read_dimension(fields, name, "the search says how many")
        if not isinstance(one.axis, Range) or one.factor:
            raise fields.error(name, "must be a range, from and to in the parameter's unit")
        found[name] = one.axis
    if not found:
        raise fields.error("nothing to tune", "name parameters of the law with from and to")
    return found


def _trials(fields: Fields, score: Fields, path: Path) -> Iterator[Trial]:
    """Yield what a rig has to do: each of ``trials`` changes set, vary and run of the study."""
    given = fields.below("trials")
    # With trials it is they that run.
    study = study_of(fields, path, runs=not given.values)
    if not given.values:
        yield Trial("", study, Score(_sizes(score.below("figures"))))
        return
    if "figures" in score.values:
        raise score.error("figures", "refused: each of trials has its own")
    for name in given.values:
        own = given.below(name)
        changed = {
            part: {**fields.below(part).values, **own.below(part).values} for part in CHANGED
        }
        for name_of_set in _given_way(own, changed["set"]):
            del changed["set"][name_of_set]
        figures = _sizes(own.below("figures"))
        own.end()
        common = {part: fields.values[part] for part in COMMON if part in fields.values}
        trial = study_of(Fields.of(own.where, {**common, **changed}), path)
        check_set(own.below("set"), [trial])
        yield Trial(name, trial, Score(figures))


def _given_way(trial: Fields, all_set: Mapping[str, object]) -> set[str]:
    """Return what of ``all_set`` a trial varies and does not set itself; factors multiply it."""
    vary = trial.below("vary")
    axes = [read_dimension(vary, name) for name in vary.values]
    varied = {name for one in axes if not one.factor for name in one.names(list(all_set))}
    return varied - trial.below("set").values.keys()


def _sizes(figures: Fields) -> dict[str, float]:
    sizes = {name: figures.number(name, 1.0) for name in figures.values}
    for name, size in sizes.items():
        if name not in RunMetrics._fields:
            raise figures.error(name, f"no such figure, there are {', '.join(RunMetrics._fields)}")
        if not 0.0 < size < np.inf:
            raise figures.error(name, f"{size:g} refused, must be the size that costs 1, above 0")
    if not sizes:
        raise figures.error("no figure", "name figures with the size at which each costs 1")
    return sizes


def _check_trials(task: TuningTask, where: str) -> None:
    """Refuse a trial whose rigs would be others: an axis more, or in another order."""
    first, *others = task.trials
    axes = [one.name for one in first.study.dimensions]
    for trial in others:
        if [one.name for one in trial.study.dimensions] != axes or len(trial.study) != len(
            first.study
        ):
            raise StudyError(
                f"{where}: trials: {in_one_line(trial.name)}: vary: refused, other axes than those "
                f"of {in_one_line(first.name)}; all trials have the same rigs: vary the same "
                "parameters in each, for example in vary of the whole file"
            )


def _check_ranges(task: TuningTask, where: str) -> None:
    controller = task.study.base.controller
    tuned = {LAW: controller[LAW], **controller.of_law()}
    for trial in task.trials:
        own = trial.study.base.controller
        for name, value in tuned.items():
            if own.get(name) != value:
                raise StudyError(
                    f"{where}: trials: {in_one_line(trial.name)}: {name}: refused, a task tunes "
                    "one law; give it in set of the whole file"
                )
    varied = {
        name
        for trial in task.trials
        for one in trial.study.dimensions
        for name in one.names(trial.study.base.names)
    }
    if LAW in varied:
        raise StudyError(f"{where}: vary: {LAW}: refused, a task tunes one law; give it in set")
    for name in sorted(varied - set(task.study.base.rig)):
        raise StudyError(
            f"{where}: vary: {name}: refused, a task varies rigs alone; give it in set"
        )
    for name, one in task.ranges.items():
        declared = controller.LAW_CLASS.PARAMETERS.get(name)
        if declared is None:
            law = controller.text(LAW)
            raise StudyError(
                f"{where}: tune: {in_one_line(name)}: no such parameter of the law {law}"
            )
        if not isinstance(declared.default, float):
            raise StudyError(f"{where}: tune: {name}: is no real number, and cannot be tuned")
        if not declared.minimum <= one.low < one.high <= declared.maximum:
            raise StudyError(
                f"{where}: tune: {name}: from {one.low:g} to {one.high:g} refused, must be within "
                f"{declared.minimum:g} to {declared.maximum:g} {declared.unit}"
            )
