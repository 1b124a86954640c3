# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compile the equations of rigs before a plant needs them, here or in a process of its own.

Run as a program, with Python's path as its argument, it reads one line of JSON from standard input:
a list of parameter sets, the first that of a rig and the others what it is to change to. It ends
early where standard input does, with the process that started it.
"""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterable, Mapping
from contextlib import suppress

from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.rig import Rig

# Of a process beside one that keeps time.
NICENESS = 5

STANDARD_INPUT = 0

# With the modules of the process that starts it: compiled code is kept by their place.
START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from rodless_sim.precompile import main
main()
"""


def compile_changes(before: RigParameters, changed: Iterable[RigParameters]) -> None:
    """Compile, or load, what a rig needs to change from one set of parameters to each other."""
    for values in changed:
        # What such a rig cannot do is said when it is to do it.
        with suppress(SimulationError):
            rig = Rig(before)
            rig.reset(position=0.0)  # within every stroke
            rig.configure(values)
            rig.advance(rig.state.voltage, 1e-3)
            rig.read()
            rig.reset()


def compile_elsewhere(
    before: RigParameters, changed: Iterable[RigParameters]
) -> "subprocess.Popen[str]":
    """Start a process that does :func:`compile_changes` for others; raises OSError."""
    process = subprocess.Popen(
        [sys.executable, "-c", START, json.dumps(sys.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    # It stays open: where it ends, so does the process.
    assert process.stdin is not None
    print(json.dumps([dict(one) for one in (before, *changed)]), file=process.stdin, flush=True)
    return process


def _end_with_standard_input() -> None:
    # Not by sys.stdin, which a thread that waits for it keeps from being closed at the end.
    while os.read(STANDARD_INPUT, 1):
        pass
    os._exit(1)


def main() -> None:
    """Do what the line says."""
    os.nice(NICENESS)
    given: list[Mapping[str, object]] = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_standard_input, daemon=True).start()
    before, *changed = map(RigParameters, given)
    compile_changes(before, changed)
