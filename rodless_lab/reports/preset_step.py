# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The step of section 6.2, 0 to 58 mm at 0.52 MPa gauge, as pictures of a preset show it."""

import numpy as np

from rodless_control import PidParameters, references
from rodless_lab.runs.measured_run import MeasuredRun, Setpoint, run_of_trace
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters

AT, DURATION = 0.5, 5.0  # s
TARGET = 0.058  # m


def preset_step(preset: str) -> tuple[MeasuredRun, Setpoint]:
    """Return the run of a preset and its set-points."""
    parameters = RigParameters.preset(preset)
    step = references.step(0.0, TARGET, at=AT)
    law = PidParameters.preset(preset)
    trace = closed_loop(parameters, law, step, duration=DURATION, period=1e-3)
    run = run_of_trace(trace, parameters.number("supply.pressure"))
    return run, Setpoint(np.array([0.0, AT]), np.array([0.0, TARGET]))
