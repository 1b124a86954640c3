# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The openings of the valve are computed once for each voltage that is applied."""

import json
import os
import subprocess
import sys

PROGRAM = """
import json
import numpy as np
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import Rig, RigParameters, trace
from rodless_sim.physics import valve_assembly

calls, original = [], valve_assembly.lands
valve_assembly.lands = lambda *arguments: calls.append(arguments[-1]) or original(*arguments)
found = {}

rig = Rig()
calls.clear()
rig.advance(6.0, 1e-4)
found["advance"] = len(calls)

calls.clear()
voltages = np.linspace(5.5, 6.5, 7)
trace.run_open_loop(rig.plant, voltages, rig.motion, (), 40_000, 1.0, 6)
found["open loop"] = calls == [*voltages.tolist(), voltages[-1]]

calls.clear()
reference = references.step(0.0, 0.058, at=0.0)
run = closed_loop(RigParameters(), PidParameters(), reference, 0.005, 1e-3)
found["closed loop"] = len(run.time), calls[-6:] == run.voltage.tolist()
found["before"] = len(calls) - 6
print(json.dumps(found))
"""


def test_once_for_each_voltage() -> None:
    """Counted in plain Python: by the rig, in an open and in a closed loop of six samples."""
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["advance"] == 1
    assert found["open loop"] is True
    assert found["closed loop"] == [6, True]
    # The same rig has settled before.
    assert found["before"] == 0
