# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The PID as a numba function of arrays, for the loop around other people's solvers."""

from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt

from rodless_base.measurement import Measurement
from rodless_control import ReferencePoint
from rodless_control.laws.pid import Gains, Memory, begin, update
from rodless_lab.benchmark.solvers.right_hand_side import compiled

Array = npt.NDArray[np.float64]

MEMORY = len(Memory._fields)


@cache
def control_of(gains: Gains) -> Callable[[Array, Array, Array, float], float]:
    """Return ``control(memory, y, reference, interval) -> V``.

    ``memory``, one number for each field of ``Memory``, is kept up to date; ``reference`` is in m
    and m/s, ``interval`` in s, 0 for the first sample.
    """

    @compiled
    def control(memory: Array, y: Array, wanted: Array, interval: float) -> float:
        measurement = Measurement(0, y[0], y[2], y[3], 0.0)
        if interval == 0.0:
            before = begin(gains, measurement)
        else:
            # Compiled code cannot know the length of an array.
            before = Memory(
                memory[0],
                memory[1],
                memory[2],
                memory[3],
                memory[4],
                memory[5],
                memory[6],
                memory[7],
                memory[8],
                memory[9],
                memory[10],
                memory[11],
            )
        after, command = update(
            gains, before, measurement, ReferencePoint(wanted[0], wanted[1]), interval
        )
        for k in range(len(after)):
            memory[k] = after[k]
        return command.voltage

    return control
