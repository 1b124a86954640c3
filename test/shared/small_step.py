# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A small step of the command in steady motion: what a rig answers, and what its model does."""

import numpy as np
import numpy.typing as npt
from scipy import signal

from rodless_lab import LinearModel
from rodless_sim import RigParameters, Trace, simulate

Array = npt.NDArray[np.float64]

PERIOD = 1e-3
STEP = 5e-3  # V
LEAD, AFTER = 500, 50  # samples before the step, and from it on


def small_step(
    parameters: RigParameters, found: LinearModel, position: float
) -> tuple[Trace, list[tuple[Array, Array]]]:
    """Return a run without the step, and of each state what the rig and the model answer to it.

    At the step the carriage passes ``position`` (m), about which the model was ``found``. Both
    answers have shape (AFTER + 1,).
    """
    voltage, motion = found.point.voltage, found.point.motion
    start = position - motion.velocity * LEAD * PERIOD
    commands = np.full(LEAD + AFTER, voltage)
    stepped = commands + STEP * (np.arange(len(commands)) >= LEAD)
    pressures = (motion.pressure_a, motion.pressure_b)
    first, second = (
        simulate(parameters, each, PERIOD, start, pressures) for each in (commands, stepped)
    )
    system = signal.cont2discrete((found.A, found.B[:, :1], found.C, found.D[:, :1]), PERIOD)
    _, expected, _ = signal.dlsim(system, np.full(AFTER + 1, STEP))
    shown = [state.name for state in found.states if hasattr(first, state.name)]
    answers = [(getattr(second, name) - getattr(first, name))[LEAD:] for name in shown]
    return first, list(zip(answers, expected.T, strict=False))
