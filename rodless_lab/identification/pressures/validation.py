# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which model predicts a second run: nothing of what the first one told is fitted there again.

A model with one more effect always follows the run it was fitted to more closely. A run it has not
seen tells whether the effect is there (Stone 1974, cross-validation).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.estimate import covariance
from rodless_lab.identification.plausible import from_gauge
from rodless_lab.identification.pressures.causes import Trial
from rodless_lab.identification.pressures.fit import (
    DRAWS,
    SEED,
    Solution,
    left_of,
    solve,
    with_biases,
)
from rodless_lab.identification.pressures.problem import Problem
from rodless_lab.identification.pressures.unknowns import SPOOL_START
from rodless_lab.identification.verdict import Verdict, span_checks
from rodless_lab.runs.measured_run import MeasuredRun, RunError

Array = npt.NDArray[np.float64]

PLAIN = "the model as it is"

# A model of which the first run leaves more open than this many times the noise predicts nothing.
MOST_OPEN = 2.0

# How many times what is stated a sensor's bias is found that is no error of the first fit.
SURELY = 2.0

# Relative step of a derivative, in natural sizes.
STEP = 1e-4


@dataclass(frozen=True)
class Prediction:
    """How a model fitted to one run predicts another: ``left`` and ``explained``, RMS in Pa.

    ``explained`` is what the sensors leave, and the errors of what the first run told; ``noise``
    (Pa) is that of a reading. The cause of its verdict, if it has one, is not the model's.
    """

    name: str
    left: float
    explained: float
    noise: float
    verdict: Verdict

    @property
    def tells(self) -> bool:
        """Whether the first run determines the model well enough for any prediction."""
        return self.explained <= MOST_OPEN * self.noise

    @property
    def predicts(self) -> bool:
        """Whether what is left is what a right model leaves."""
        return self.tells and self.verdict.fits

    def __str__(self) -> str:
        said = "predicts it" if self.predicts else "does not predict it"
        if self.verdict.fits and not self.tells:
            said = "the first run leaves it too open to predict"
        if self.verdict.cause:
            said = f"{said}: {self.verdict.checks[-1]}"
        return f"{self.name}: {self.left:.4g} Pa, explained {self.explained:.4g} Pa; {said}"


@dataclass(frozen=True)
class Validation:
    """The model as it is, and with each effect it may lack, on a run that none was fitted to."""

    plain: Prediction
    others: Sequence[Prediction]

    @property
    def chosen(self) -> Prediction:
        """The plain model where it predicts the run, else the one of the others that leaves least.

        The plain one too where none of the others does, or only one that the first run leaves so
        open that it may leave more.
        """
        able = [
            prediction
            for prediction in self.others
            if prediction.predicts and prediction.left < self.plain.left
        ]
        if self.plain.predicts or not able:
            return self.plain
        return min(able, key=lambda prediction: prediction.left)

    def __str__(self) -> str:
        if self.chosen.predicts:
            others = "" if self.chosen is self.plain else f"; {self.plain}"
            return f"chosen: {self.chosen}{others}"
        able = any(prediction.predicts for prediction in self.others)
        none = f"chosen: none of the models tried predicts it{' and leaves less' if able else ''}"
        return f"{none}; take {self.plain.verdict.cause or 'a first bag that shows more'}"


def validated(
    fitted: Solution, second: MeasuredRun, try_effects: Callable[[], list[Trial]]
) -> Validation:
    """Predict ``second`` by what another run told, with and without effects the model may lack.

    ``try_effects`` fits each of these to the other run. Where the model as it is predicts
    ``second``, none is tried: the simplest model is taken.
    Fitted on ``second`` are what belongs to a run only: where pressures, temperatures and the
    spool start, and the constant errors of the sensors within their accuracy. Raises RunError for
    gauge pressures.
    """
    plain = prediction(PLAIN, fitted, second)
    if plain.predicts:
        return Validation(plain, [])
    if prediction(PLAIN, fitted, from_gauge(second, fitted.parameters)).predicts:
        raise RunError(
            "the model as it is predicts it with the atmosphere added to all pressures: they are "
            "gauge readings, and absolute ones are needed"
        )
    tried = [prediction(trial.title, trial.solution, second) for trial in try_effects()]
    return Validation(plain, tried)


def prediction(name: str, fitted: Solution, second: MeasuredRun) -> Prediction:
    """Hold what ``fitted`` leaves of ``second`` against draws of what a right model leaves."""
    told = [pair for pair in fitted.sizes if pair[0].name != SPOOL_START]
    own = [unknown for unknown in fitted.unknowns if unknown.name == SPOOL_START]
    found = solve(second, fitted.parameters, own, known=told)
    explained = _explained(fitted, found, second)
    compared = [("scatter of the pressures", found.residuals.reshape(2, -1), explained)]
    checks = list(span_checks(compared, found.problem.spacing, "Pa", found.problem.noise))
    left, expected_left = checks[0].found, checks[0].expected
    verdict = with_biases(Verdict(tuple(checks)), found, SURELY)
    return Prediction(name, left, expected_left, found.problem.noise, verdict)


def _explained(fitted: Solution, found: Solution, second: MeasuredRun) -> Array:
    """Draw residuals of ``second``, shape (DRAWS, 2, m): of the sensors, and of the first fit.

    The run's own values take out of each draw what they can follow.
    """
    generator = np.random.default_rng(SEED)
    drawn = found.problem.draws(found.values, DRAWS, generator).reshape(DRAWS, -1)
    drawn = drawn + _of_sizes(fitted, found, second, generator)
    return left_of(drawn, found.problem, found.jacobian)


def _of_sizes(
    fitted: Solution, found: Solution, second: MeasuredRun, generator: np.random.Generator
) -> Array:
    """What the errors of the sizes that the first run told do to the second, (DRAWS, 2 m)."""
    places = [k for k, unknown in enumerate(fitted.unknowns) if unknown.name != SPOOL_START]
    told = [fitted.unknowns[place] for place in places]
    problem = Problem(second, fitted.parameters, [*told, *found.unknowns])
    values = np.concatenate([fitted.values[places], found.values])
    readings = problem.readings
    before = problem.residuals(values)[:readings]
    columns = []
    for place in range(len(told)):
        beside = values.copy()
        step = max(STEP, problem.blur[place]) * problem.scale[place]
        beside[place] += step
        columns.append((problem.residuals(beside)[:readings] - before) / step)
    # Of the sensors' noise alone: what a wrong model leaves of the first run explains nothing.
    spread = covariance(fitted.jacobian, 1.0)[np.ix_(places, places)]
    known = np.isfinite(np.diag(spread))
    errors = np.zeros((DRAWS, len(told)))
    if known.any():
        within = spread[np.ix_(known, known)]
        errors[:, known] = generator.multivariate_normal(np.zeros(int(known.sum())), within, DRAWS)
    return np.asarray(errors @ np.array(columns).reshape(len(told), readings))
