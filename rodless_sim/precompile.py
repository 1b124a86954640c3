# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compile the equations of rigs before a plant needs them, here or in a process of its own.

Run as a program, with Python's path and its niceness as arguments, it reads one line of JSON from
standard input: a list of parameter sets, the first that of a rig and the others what it is to
change to. It ends early where standard input does, with the process that started it.
"""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress

from rodless_base.kernels import keeps
from rodless_base.one_line import in_one_line
from rodless_base.start import Stop, StoppedError
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.motion import advance_at_voltage
from rodless_sim.rig import Rig, equations_are_kept

# Of a process beside one that keeps time.
NICENESS = 5

# How often to look whether the wait is over, in wall-clock s.
LOOK_SECONDS = 0.1

COMPILING = "compiling the equations of these parameters, which takes about a minute"

STANDARD_INPUT = 0

# With the modules of the process that starts it: compiled code is kept by their place.
START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from rodless_sim.precompile import main
main(int(sys.argv[2]))
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


def compile_unless_stopped(
    before: RigParameters,
    changed: Iterable[RigParameters],
    stop: Stop | None,
    say: Callable[[str], object],
) -> None:
    """Have another process compile what is not kept of the equations of ``changed``, and wait.

    This process could not end in the midst of it: an exception would get lost in the compiler, and
    an end on the spot leaves DDS's shared memory half written. Raises StoppedError where ``stop``
    is requested. What cannot be compiled elsewhere is left to this process, as all is without
    ``stop``; ``say`` is told.
    """
    lacking = [values for values in changed if not equations_are_kept(values)]
    if stop is None or not lacking or not keeps(advance_at_voltage):
        return
    say(f"{COMPILING}; the next start finds the result")
    try:
        failure = _wait(compile_elsewhere(before, lacking, niceness=0), stop)
    except OSError as error:
        failure = error.strerror
    # Ctrl-C in a terminal reaches a process that is just being started, too.
    if stop.requested:
        raise StoppedError
    if failure:
        say(f"no other process could compile them ({failure}): {COMPILING}, and nothing ends that")


def _wait(process: "subprocess.Popen[str]", stop: Stop) -> str | None:
    """Return why ``process`` has failed, if so, also where a request to stop ends it."""
    with process:
        while process.poll() is None:
            if stop.requested:
                process.kill()
            with suppress(subprocess.TimeoutExpired):
                process.wait(LOOK_SECONDS)
        return last_words(process) if process.returncode else None


def last_words(process: "subprocess.Popen[str]") -> str:
    """Return the last line that a process which has ended wrote to standard error."""
    _, said = process.communicate()
    *_, last = said.splitlines() or [f"exit code {process.returncode}"]
    return in_one_line(last)


def compile_elsewhere(
    before: RigParameters, changed: Iterable[RigParameters], niceness: int = NICENESS
) -> "subprocess.Popen[str]":
    """Start a process that does :func:`compile_changes` for others; raises OSError."""
    process = subprocess.Popen(
        [sys.executable, "-c", START, json.dumps(sys.path), str(niceness)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # Ctrl-C in a terminal is for the one that waits.
        start_new_session=True,
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


def main(niceness: int) -> None:
    """Do what the line says."""
    os.nice(niceness)
    given: list[Mapping[str, object]] = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_standard_input, daemon=True).start()
    before, *changed = map(RigParameters, given)
    compile_changes(before, changed)
