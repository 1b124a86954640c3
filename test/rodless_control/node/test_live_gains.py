# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A controller that runs compiles nothing: the valve would hold its voltage meanwhile."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHANGE = """
from pathlib import Path
from rodless_control import ControllerParameters, Measurement, ReferencePoint
from rodless_control.loop import ControlLoop
from rodless_control.node.controller_node import load

def compiled():
    return {path.name for path in Path(CACHE).rglob("*.nbc")}

load()
before = compiled()
assert before
for error, speed, parked in ((0.0, 1.0, 0.0), (1e-4, 0.0, 1.0)):
    parameters = ControllerParameters({"controller.parking_error": error})
    loop = ControlLoop(parameters)
    for k in range(500):
        loop.sample(Measurement(k * 1_000_000, 1e-3 * k * speed))
    assert loop.law.memory.parked == parked
    loop.configure(parameters.with_values({"controller.kp": 500.0}))
    loop.sample(Measurement(500_000_000, 0.5 * speed))
    loop.hold()
    loop.reset()
    loop.sample(Measurement(501_000_000, 0.501 * speed))
print(sorted(compiled() - before))
"""


@pytest.mark.slow
def test_new_gains_hold_and_reset_wait_for_no_compiler(tmp_path: Path) -> None:
    """With an empty cache, all that the PID needs is there once the node has loaded it.

    While the carriage moves, and where it is parked, too.
    """
    done = subprocess.run(
        [sys.executable, "-c", f"CACHE = {str(tmp_path)!r}\n{CHANGE}"],
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "[]\n"
