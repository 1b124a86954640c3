# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The compiled plant against the same functions run as plain Python."""

import json
import os
import subprocess
import sys

import pytest

PROGRAM = """
import json
from rodless_sim import RigParameters
from rodless_sim.physics.motion import advance
from rodless_sim.physics.state import HeatedMotion, Motion
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings

ends = []
for assembly in ("reconciled", "printed"):
    for form in ("stribeck", "saturating"):
        plant = Plant.of(RigParameters({"valve.assembly": assembly, "friction.form": form}))
        # breaks away forward, breaks away in reverse, bounces off the cap of chamber A
        for voltage, state in (
            (7.0, Motion(0.1, 0.0, 4.6e5, 4.1e5)),
            (3.0, Motion(0.1, 0.0, 4.0e5, 4.6e5)),
            (4.0, Motion(0.0005, -0.4, 3.0e5, 4.5e5)),
        ):
            ends.append(advance(plant, openings(plant, voltage), state, 0.01, 1.0)[0])
plant = Plant.of(RigParameters({"chambers.thermodynamics": "energy_balance"}))
for voltage, state in (
    (7.0, HeatedMotion(0.1, 0.0, 4.6e5, 4.1e5, 300.0, 280.0)),
    (4.0, HeatedMotion(0.0005, -0.4, 3.0e5, 4.5e5, 280.0, 300.0)),
):
    ends.append(advance(plant, openings(plant, voltage), state, 0.01, 1.0)[0])
print(json.dumps(ends))
"""


def run(disable: str) -> list[list[float]]:
    """Run the program in a process of its own, compiled or not."""
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": disable,
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
    }
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    result: list[list[float]] = json.loads(done.stdout)
    return result


@pytest.mark.slow
def test_plain_python_gives_the_compiled_numbers() -> None:
    """With NUMBA_DISABLE_JIT=1 every end state is the compiled one to within rounding."""
    compiled, plain = run("0"), run("1")
    assert len(compiled) == 14
    for one, other in zip(compiled, plain, strict=True):
        assert one == pytest.approx(other, rel=1e-10, abs=1e-12)
    assert any(abs(end[0] - 0.1) > 1e-6 for end in compiled)
