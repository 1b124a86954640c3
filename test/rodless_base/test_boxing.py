# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Ctrl-C that comes while compiled code runs is raised once it has returned."""

import subprocess
import sys

import pytest
from extent import also
from unmeasured import unmeasured

# An alarm stands for Ctrl-C, at many different instants of a step and of a closed loop.
PROGRAM = """
import signal
from rodless_control import PidParameters, references
from rodless_lab.simulation.closed_loop import Loop
from rodless_sim import Rig, RigParameters

class Interrupted(KeyboardInterrupt): pass

def interrupt(*_):
    raise Interrupted

calibrated = RigParameters.preset("calibrated")
rig = Rig(calibrated)
loop = Loop(PidParameters(), references.step(0.0, 0.05), 0.05, 1e-3)

def work():
    {work}

work()
signal.signal(signal.SIGALRM, interrupt)
caught = 0
for k in range(300):
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-3 + 1e-5 * k)
        while True:
            work()
    except Interrupted:
        caught += 1
print(caught)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "work",
    [
        also("rig.advance(5.5, 1e-3), rig.read()"),
        also("loop.run(calibrated)"),
        "loop.run(RigParameters())",
    ],
)
def test_an_interrupt_never_breaks_off_the_making_of_a_result(work: str) -> None:
    """Three hundred in a row, each caught as what it is; numba alone crashes within a few."""
    # Coverage's own tracing holds a lock when it is interrupted, and waits for it at exit forever.
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(work=work)],
        env=unmeasured(),
        capture_output=True,
        text=True,
        timeout=900.0,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (0, "300\n"), ended.stderr[-2000:]
