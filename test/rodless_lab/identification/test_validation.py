# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The model that generalises: judged on what it was not fitted to."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from rodless_lab.identification.validation import Candidate, Selection, robust_squares

FIRST, SECOND = np.linspace(-1.0, 1.0, 40), np.linspace(-0.99, 0.97, 40)
NOISE = 0.1


def polynomials(truth: Polynomial, seed: int) -> Selection:
    """Polynomials of degree 0 to 8 fitted to noisy points, judged at others."""
    generator = np.random.default_rng(seed)
    first, second = (truth(x) + generator.normal(0.0, NOISE, x.shape) for x in (FIRST, SECOND))
    found = []
    for degree in range(9):
        fit = Polynomial.fit(FIRST, first, degree)
        squares = (first - fit(FIRST)) ** 2
        found.append(
            Candidate(str(degree), "", degree, float(squares.mean()), (second - fit(SECOND)) ** 2)
        )
    return Selection(found, "V")


@pytest.mark.parametrize("truth", [Polynomial([1.0, 2.0]), Polynomial([0.0, 1.0, -1.0, 1.5])])
def test_the_degree_of_a_polynomial_is_found(truth: Polynomial) -> None:
    """Of 50 noisy sets at least 40 name the true degree, though a higher one always leaves less."""
    chosen = []
    for seed in range(50):
        found = polynomials(truth, seed)
        assert found.candidates[-1].first <= min(one.first for one in found.candidates) + 1e-12
        chosen.append(int(found.chosen.name))
    assert sum(degree == truth.degree() for degree in chosen) >= 40
    assert all(degree >= truth.degree() for degree in chosen)


def test_the_table_names_it() -> None:
    """A row for each, the one that leaves least of the second run first."""
    good = Candidate("heat", "h 50", 1, 1.0, np.array([1.0, 1.1, 0.9]))
    bad = Candidate("the model as it is", "", 0, 9.0, np.array([9.0, 9.1, 8.9]))
    lines = str(Selection((bad, good), "Pa")).splitlines()
    assert lines[1].split() == ["heat", "1", "Pa", "1", "Pa", "h", "50"]
    assert lines[2].split()[-4:] == ["3", "Pa", "3", "Pa"]
    assert lines[-1] == "the one that generalises: heat"


def test_a_robust_square_is_one_within_its_limit() -> None:
    """Small residuals count squared, large ones by 2 limit |r|."""
    squares = robust_squares(np.array([1e-3, 1e6]), 2.0)
    assert squares == pytest.approx([1e-6, 4e6], rel=1e-4)
