# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which effect beside the model a second run confirms: each fitted to the first, judged there."""

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.pressures.causes import trials
from rodless_lab.identification.pressures.fit import ROBUST, Solution, solve
from rodless_lab.identification.pressures.unknowns import SPOOL_START
from rodless_lab.identification.validation import Candidate, Selection, robust_squares
from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# Length in s of the parts whose losses are compared: what is correlated in time is within one.
PART = 0.1

AS_IT_IS = "the model as it is"


def select(run: MeasuredRun, second: MeasuredRun, fit: Solution) -> Selection:
    """Judge ``fit``, and it with each effect that it lacks, all fitted to ``run``, on ``second``.

    Of the second run only what the sensors leave open is fitted: where it starts, and the errors
    of the sensors within their accuracy. Raises UninformativeRunError where no pressure changes.
    """
    found = [Candidate(AS_IT_IS, "", 0, _first(fit), _losses(second, fit))]
    found += [
        Candidate(
            trial.name,
            trial.sizes,
            len(trial.added),
            _first(trial.solution),
            _losses(second, trial.solution),
        )
        for trial in trials(run, fit)
    ]
    return Selection(found, "Pa")


def _first(solution: Solution) -> float:
    return float(np.mean(_squares(solution)))


def _losses(second: MeasuredRun, first: Solution) -> Array:
    known = [(unknown, size) for unknown, size in first.sizes if unknown.name != SPOOL_START]
    solution = solve(second, first.parameters, [], known=known)
    squares = _squares(solution).reshape(2, -1).mean(axis=0)
    parts = max(int(len(squares) * solution.problem.spacing / PART), 1)
    return np.array([np.mean(part) for part in np.array_split(squares, parts)])


def _squares(solution: Solution) -> Array:
    return robust_squares(solution.residuals, ROBUST) * solution.problem.noise**2
