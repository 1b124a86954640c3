# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The loop around other people's solvers: control, hold, integrate one period, begin anew."""

from collections.abc import Callable, Iterator
from itertools import islice

import numpy as np
import numpy.typing as npt

from rodless_lab.benchmark.solvers.control import MEMORY, control_of
from rodless_lab.benchmark.solvers.right_hand_side import HELD, STATES, right_hand_side
from rodless_lab.benchmark.work import PERIOD, Run, Work

Array = npt.NDArray[np.float64]

# From a state, up to a duration in s, with what is held: the state then and when that is, which is
# the first event where there is one before.
Integrate = Callable[[Array, float, Array], tuple[Array, float]]

# Returns how to integrate a work at a tolerance.
Method = Callable[[Work, float], Integrate]


def by_periods(method: Method) -> Callable[[Work], Run]:
    """Return what prepares a work for ``method``."""

    def prepare(work: Work) -> Run:
        def run(tolerance: float) -> Array:
            return _rows(work, method(work, tolerance))

        # Two samples compile what there is to compile.
        list(islice(_samples(work, method(work, 1.0)), 2))
        return run

    return prepare


def _rows(work: Work, integrate: Integrate) -> Array:
    rows = np.empty((work.samples, STATES))
    for k, state in enumerate(_samples(work, integrate)):
        rows[k] = state
    return rows


def _samples(work: Work, integrate: Integrate) -> Iterator[Array]:
    rig, control = right_hand_side(work.plant), control_of(work.gains)
    held, memory = np.zeros(HELD), np.zeros(MEMORY)
    state = np.array(work.state)
    for k, wanted in enumerate(work.references[: work.samples]):
        if work.voltages is None:
            voltage = control(memory, state, wanted, PERIOD if k else 0.0)
        else:
            voltage = work.voltages[min(k, len(work.voltages) - 1)]
        yield state
        rig.hold(state, voltage, held)
        left = PERIOD
        while True:
            state, elapsed = integrate(state, left, held)
            if elapsed >= left:
                break
            left -= elapsed
            rig.changed(state, held)
