# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The largest error on a slow sine against breakaway force: 40 rigs, on all cores.

The compiled loop lets other threads run, so that threads are enough.

python examples/friction_sweep.py [picture.png]
"""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from matplotlib.figure import Figure

from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import RigParameters

BASE = RigParameters.preset("calibrated")
SINE = references.sine(0.1, 0.020, 0.381)  # m, m, Hz
CYCLES = 3


def peak_error(breakaway: float) -> float:
    """Return the largest error (m) after the first cycle, at this breakaway force (N)."""
    rig = BASE.with_values(
        {"friction.forward.static": breakaway, "friction.reverse.static": breakaway}
    )
    duration = CYCLES / 0.381
    run = closed_loop(rig, PidParameters.preset("calibrated"), SINE, duration, 1e-3, position=0.1)
    return float(np.abs(run.error[run.time > duration / CYCLES]).max())


forces = np.linspace(15.0, 90.0, 40)  # N
with ThreadPoolExecutor() as pool:
    errors = np.array(list(pool.map(peak_error, forces)))
print(f"{len(forces)} rigs, {1e3 * errors.min():.2f} to {1e3 * errors.max():.2f} mm")

figure = Figure(figsize=(6.3, 3.0), layout="constrained")
axes = figure.subplots()
axes.plot(forces, 1e3 * errors, "o")
axes.set_xlabel("breakaway force / N")
axes.set_ylabel("largest error on the sine / mm")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "friction_sweep.png", dpi=110)
