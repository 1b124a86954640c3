# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the benchmark knows of a solver."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rodless_lab.benchmark.work import Run, Work

# A tolerance of 1 allows an error of so much, as ``time.tolerance`` does: m, m/s, Pa, Pa.
UNITS = np.array([1e-8, 1e-5, 2.0, 2.0])

# Beside it, relative errors are kept this small, so that both mean the same.
RELATIVE = 1e-7
SMALLEST_RELATIVE = 1e-13

LADDER = (10.0, 1.0, 0.1, 0.01)


def relative(tolerance: float) -> float:
    """Return the relative tolerance that goes with ``tolerance``."""
    return max(RELATIVE * tolerance, SMALLEST_RELATIVE)


class MissingError(RuntimeError):
    """A solver is not there; the text says how to get it."""


class Solver(NamedTuple):
    """A solver, with settings and tolerances to try, loosest first.

    ``prepare`` compiles what a work needs and returns what runs it; it raises MissingError.
    """

    name: str
    settings: str
    prepare: Callable[[Work], Run]
    tolerances: tuple[float, ...] = LADDER
    repeats: int = 1  # the best counts
