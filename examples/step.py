# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A step of 58 mm in closed loop, with both presets: metrics, and a picture.

python examples/step.py [picture.png]
"""

import sys

from matplotlib.figure import Figure

from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import RigParameters

TARGET, AT = 0.058, 0.1  # m, s

figure = Figure(figsize=(6.3, 4.0), layout="constrained")
position, voltage = figure.subplots(2, 1, sharex=True)
for preset in ("paper", "calibrated"):
    rig = RigParameters.preset(preset)
    law = PidParameters.preset(preset)
    step = references.step(0.0, TARGET, at=AT)
    run = closed_loop(rig, law, step, duration=2.0, period=1e-3)
    outside = abs(run.error) > 2e-4
    settled = run.time[outside][-1] - AT
    print(f"{preset}: within 0.2 mm after {settled:.2f} s, peak {run.voltage.max():.1f} V")
    position.plot(run.time, 1e3 * run.position, label=preset)
    voltage.plot(run.time, run.voltage, linewidth=0.8)
position.axhline(1e3 * TARGET, color="k", linestyle="--", linewidth=0.8)
position.set_ylabel("position / mm")
position.legend(frameon=False)
voltage.set_xlabel("time / s")
voltage.set_ylabel("valve / V")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "step.png", dpi=110)
