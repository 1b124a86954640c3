# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Models that were fitted to one run, judged on another: the one that generalises is named."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """A model fitted to one run, and what it leaves there and on another.

    ``size`` says what was found of its effect, ``added`` how many numbers that took. ``losses``,
    shape (k,), are mean squares of what it leaves of parts of the other run, the same for all
    candidates; ``first`` is that of the run it was fitted to.
    """

    name: str
    size: str
    added: int
    first: float
    losses: Array

    @property
    def loss(self) -> float:
        """Mean square of what it leaves of the other run."""
        return float(np.mean(self.losses))


@dataclass(frozen=True)
class Selection:
    """Candidates, and the ``unit`` of what they leave, whose squares they hold.

    Examples
    --------
    >>> as_it_is = Candidate("the model as it is", "", 0, 9e4, np.array([9e4, 8e4, 1e5]))
    >>> heat = Candidate("heat", "h 50", 1, 4e4, np.array([4e4, 4.1e4, 3.9e4]))
    >>> leak = Candidate("leak", "2e-9 m²", 1, 8.9e4, np.array([9.1e4, 8e4, 1e5]))
    >>> found = Selection((as_it_is, heat, leak), "Pa")
    >>> found.chosen.name
    'heat'
    """

    candidates: Sequence[Candidate]
    unit: str

    @property
    def chosen(self) -> Candidate:
        """The simplest of those that are no worse than the best by more than chance.

        Chance is one standard error of the difference over the parts of the other run (Breiman and
        others 1984).
        """
        best = min(self.candidates, key=lambda candidate: candidate.loss)
        alike = [candidate for candidate in self.candidates if _alike(candidate, best)]
        return min(alike, key=lambda candidate: (candidate.added, candidate.loss))

    def __str__(self) -> str:
        rows = [
            (found.name, _root(found.first, self.unit), _root(found.loss, self.unit), found.size)
            for found in sorted(self.candidates, key=lambda candidate: candidate.loss)
        ]
        heading = ("model", "leaves of the first", "of the second", "found")
        table = [heading, *rows]
        widths = [max(len(row[column]) for row in table) for column in range(3)]
        lines = [
            f"{row[0]:{widths[0]}}  {row[1]:>{widths[1]}}  {row[2]:>{widths[2]}}  {row[3]}".rstrip()
            for row in table
        ]
        return "\n".join([*lines, f"the one that generalises: {self.chosen.name}"])


def _alike(one: Candidate, best: Candidate) -> bool:
    more = one.losses - best.losses
    if len(more) < 2:
        return one is best
    return float(np.mean(more)) <= float(np.std(more, ddof=1)) / math.sqrt(len(more))


def _root(square: float, unit: str) -> str:
    return f"{math.sqrt(square):.4g} {unit}"


def robust_squares(residuals: Array, limit: float) -> Array:
    """Squares of ``residuals``, shape (n,), that grow linearly beyond ``limit`` (soft L1)."""
    return np.asarray(2.0 * limit**2 * (np.sqrt(1.0 + (residuals / limit) ** 2) - 1.0))
