# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A tuning task: which parameters of a law to choose, over which rigs, by which score."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import in_one_line
from rodless_base.parameters import Value
from rodless_lab.simulation.design import LARGEST_SEED, Range
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.fields import Fields
from rodless_lab.studies.shipped import find_file
from rodless_lab.studies.study import Study, read_dimension, study_of

Array = npt.NDArray[np.float64]

# What a rig costs that a figure has no number for: it never settled, or its run failed.
NEVER = 10.0


@dataclass(frozen=True)
class Score:
    """One number for a law over many rigs.

    A rig costs the sum of its figures, each divided by the size at which it costs 1; a figure that
    a rig does not have costs ``NEVER``. The score is a quantile of the costs over the rigs: near 1
    it is the worst rigs that count.
    """

    figures: dict[str, float]  # by name: the size at which it costs 1, in its unit
    quantile: float

    def costs(self, found: Ensemble) -> Array:
        """Return what each rig costs, shape (n,)."""
        total = np.zeros(len(found))
        for name, size in self.figures.items():
            share = np.abs(found[name]) / size
            total += np.where(np.isnan(share), NEVER, np.minimum(share, NEVER))
        return total

    def of(self, found: Ensemble) -> float:
        """Return the score of an ensemble."""
        return float(np.quantile(self.costs(found), self.quantile))


@dataclass(frozen=True)
class TuningTask:
    """What a task's file says; :func:`read_task` reads one."""

    name: str
    study: Study  # whose rows are the rigs
    ranges: dict[str, Range]  # of the law's parameters
    score: Score
    generations: int
    population: int  # candidates of a generation for each parameter
    seed: int

    def values(self, shares: Array) -> dict[str, float]:
        """Return the parameters at shares of their ranges, shape (parameters,)."""
        return {
            name: one.at(float(share))
            for (name, one), share in zip(self.ranges.items(), shares, strict=True)
        }

    def present(self) -> dict[str, Value]:
        """Return the values that the law has before it is tuned."""
        return {name: self.study.base.controller[name] for name in self.ranges}


def read_task(given: str | Path) -> TuningTask:
    """Read a task (docs/tuning.md), a YAML file or the name of one that ships.

    Raises StudyError in one line with file, key, value and the way out; nothing has run then.
    """
    path = find_file("tasks", given)
    fields = Fields.of_file(path)
    ranges = _ranges(fields.below("tune"))
    score = _score(fields.below("score"))
    search = fields.below("search")
    sizes = {
        name: search.whole(name, default)
        for name, default in (("generations", 30), ("population", 8))
    }
    for name, size in sizes.items():
        if not 1 <= size <= 10_000:
            raise search.error(name, f"{size} refused, must be from 1 to 10000")
    seed = search.whole("seed", 1)
    if not 0 <= seed <= LARGEST_SEED:
        raise search.error("seed", f"{seed} refused, must be from 0 to {LARGEST_SEED}")
    search.end()
    study = study_of(fields, path)
    fields.end()
    task = TuningTask(path.stem, study, ranges, score, seed=seed, **sizes)
    _check_ranges(task, str(path))
    return task


def _ranges(fields: Fields) -> dict[str, Range]:
    found: dict[str, Range] = {}
    for name in fields.values:
        one = read_dimension(fields, name)
        if not isinstance(one.axis, Range) or one.factor:
            raise fields.error(name, "must be a range, from and to in the parameter's unit")
        found[name] = one.axis
    if not found:
        raise fields.error("nothing to tune", "name parameters of the law with from and to")
    return found


def _score(fields: Fields) -> Score:
    figures = fields.below("figures")
    sizes = {name: figures.number(name, 1.0) for name in figures.values}
    for name, size in sizes.items():
        if name not in RunMetrics._fields:
            raise figures.error(name, f"no such figure, there are {', '.join(RunMetrics._fields)}")
        if not 0.0 < size < np.inf:
            raise figures.error(name, f"{size:g} refused, must be the size that costs 1, above 0")
    if not sizes:
        raise figures.error("no figure", "name figures with the size at which each costs 1")
    quantile = fields.number("quantile", 0.9)
    if not 0.0 <= quantile <= 1.0:
        raise fields.error("quantile", f"{quantile:g} refused, must be from 0 to 1")
    fields.end()
    return Score(sizes, quantile)


def _check_ranges(task: TuningTask, where: str) -> None:
    controller = task.study.base.controller
    varied = {name for one in task.study.dimensions for name in one.names(task.study.base.names)}
    for name, one in task.ranges.items():
        declared = controller.LAW_CLASS.PARAMETERS.get(name)
        if declared is None:
            law = controller["controller.law"]
            raise StudyError(
                f"{where}: tune: {in_one_line(name)}: no such parameter of the law {law}"
            )
        if name in varied:
            raise StudyError(f"{where}: tune: {name}: is varied over the rigs too; keep one")
        if not isinstance(declared.default, float):
            raise StudyError(f"{where}: tune: {name}: is no real number, and cannot be tuned")
        if not declared.minimum <= one.low < one.high <= declared.maximum:
            raise StudyError(
                f"{where}: tune: {name}: from {one.low:g} to {one.high:g} refused, must be within "
                f"{declared.minimum:g} to {declared.maximum:g} {declared.unit}"
            )
