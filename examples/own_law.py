# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A control law of one's own, in plain Python, beside the PID.

python examples/own_law.py [picture.png]
"""

import sys

from matplotlib.figure import Figure

from rodless_control import Law, PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import RigParameters

CLOSED = 5.08  # V
TARGET = 0.058  # m


class PressureDamped(Law):
    """Proportional to the error, damped by the difference of the pressures."""

    GAIN, DAMPING, ACROSS = 90.0, 1e-6, 0.4  # V/m, V/Pa, V to cross the valve's flat centre

    def update(self, measurement, reference, interval):  # noqa: ARG002
        """Return the voltage for one sample; ``interval`` is in s."""
        error = reference.position - measurement.position
        difference = measurement.pressure_a - measurement.pressure_b
        wanted = self.GAIN * error - self.DAMPING * difference
        across = max(-self.ACROSS, min(self.ACROSS, 500.0 * error))
        return CLOSED + wanted + across


figure = Figure(figsize=(6.3, 3.0), layout="constrained")
axes = figure.subplots()
for name, law in (("PID", PidParameters.preset("calibrated")), ("my law", PressureDamped())):
    step = references.step(0.0, TARGET, at=0.1)
    run = closed_loop(RigParameters.preset("calibrated"), law, step, duration=2.0, period=1e-3)
    print(f"{name}: {1e3 * run.error[-1]:+.3f} mm from the target after {run.time[-1]:.0f} s")
    axes.plot(run.time, 1e3 * run.position, label=name)
axes.axhline(1e3 * TARGET, color="k", linestyle="--", linewidth=0.8)
axes.set_xlabel("time / s")
axes.set_ylabel("position / mm")
axes.legend(frameon=False)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "own_law.png", dpi=110)
