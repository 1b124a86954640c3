# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Settling time against breakaway force: 40 rigs, on all cores.

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
AT, DURATION = 0.1, 8.0  # s


def settling_time(breakaway: float) -> float:
    """Return when (s) a rig of this breakaway force (N) stays within 0.2 mm of 58 mm."""
    rig = BASE.with_values(
        {"friction.forward.static": breakaway, "friction.reverse.static": breakaway}
    )
    step = references.step(0.0, 0.058, at=AT)
    run = closed_loop(rig, PidParameters.preset("calibrated"), step, DURATION, 1e-3)
    return float(run.time[abs(run.error) > 2e-4][-1] - AT)


forces = np.linspace(15.0, 90.0, 40)  # N
with ThreadPoolExecutor() as pool:
    times = np.array(list(pool.map(settling_time, forces)))
never = times > DURATION - AT - 0.1
print(f"{np.sum(~never)} of {len(forces)} settle, in {times[~never].min():.2f} s at best")

figure = Figure(figsize=(6.3, 3.0), layout="constrained")
axes = figure.subplots()
axes.plot(forces[~never], times[~never], "o", label="settled")
axes.plot(forces[never], times[never], "x", color="tab:red", label="not within 8 s")
axes.set_xlabel("breakaway force / N")
axes.set_ylabel("within 0.2 mm after / s")
axes.legend(frameon=False)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "friction_sweep.png", dpi=110)
