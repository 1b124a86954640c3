# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Compile the equations of rigs before a plant needs them, here or in a process of its own.

Run as a program, with Python's path and by how much nicer it is to be as arguments, it reads one
line of JSON from standard input: a list of parameter sets, the first that of a rig and the others
what it is to change to. It ends early where standard input does, with the process that started it.
"""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress

from rodless_base.kernel_cache import COMPILING
from rodless_base.kernels import is_kept, keeps, outlined_kernel
from rodless_base.one_line import in_one_line
from rodless_base.start import Stop, StoppedError
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.plant import Plant
from rodless_sim.rig import Rig, equations_are_kept, kinds_of

# Of a process beside one that keeps time.
NICENESS = 5

# How often to look whether the wait is over, in wall-clock s.
LOOK_SECONDS = 0.1

STANDARD_INPUT = 0

# With the modules of the process that starts it: compiled code is kept by their place.
START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from rodless_sim.precompile import main
main(int(sys.argv[2]))
"""


# Each kind of equations gives it another type, for which :func:`_mark` is compiled.
Kind = tuple[float | None, ...]


@outlined_kernel
def _mark(_kind: Kind) -> float:
    return 0.0


def kind_of(values: RigParameters) -> Kind:
    """Return what decides which compiled equations a rig has."""
    return tuple(0.0 if kind else None for kind in kinds_of(Plant.of(values)))


def is_compiled(values: RigParameters) -> bool:
    """Whether all that :func:`compile_changes` compiles for a rig is kept, to the last."""
    return is_kept(_mark, kind_of(values))


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
            _ = rig.free_air_flow
            rig.reset()
        _mark(kind_of(values))


def compile_unless_stopped(
    before: RigParameters,
    changed: Iterable[RigParameters],
    stop: Stop,
    say: Callable[[str], object],
) -> None:
    """Have another process compile what is lacking of the equations of ``changed``, and wait.

    This process could not end in the midst of it: an exception would get lost in the compiler, and
    an end on the spot leaves DDS's shared memory half written. Raises StoppedError where ``stop``
    is requested. What cannot be compiled elsewhere is left to this process, and ``say`` is told.
    """
    lacking = {kind_of(values): values for values in changed if not is_compiled(values)}
    if not lacking or not keeps(_mark):
        return
    if not all(map(equations_are_kept, lacking.values())):
        say(f"{COMPILING}; the next start finds the result")
    try:
        failure = _wait(compile_elsewhere(before, lacking.values(), niceness=0), stop)
    except OSError as error:
        failure = str(error.strerror)
    # Ctrl-C in a terminal reaches a process that is just being started, too: then that has failed.
    if stop.requested:
        raise StoppedError
    if not all(map(is_compiled, lacking.values())):
        say(
            f"no other process could compile the equations of these parameters ({failure}): this "
            "one does, for about a minute, and does not end before that"
        )


def _wait(process: "subprocess.Popen[str]", stop: Stop) -> str:
    """Wait for ``process``, or kill it once ``stop`` is requested; return its last words."""
    with process:
        while process.poll() is None:
            if stop.requested:
                process.kill()
            with suppress(subprocess.TimeoutExpired):
                process.wait(LOOK_SECONDS)
        return last_words(process)


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
        # Ctrl-C in a terminal is for the process that starts this one, and ends it.
        start_new_session=True,
    )
    # It stays open: where it ends, so does the process.
    assert process.stdin is not None
    # One that has ended already says why where it is waited for.
    with suppress(BrokenPipeError):
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
