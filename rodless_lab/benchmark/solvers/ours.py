# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The package itself, and the same scheme in C."""

from functools import cache

import numpy as np

from rodless_lab.benchmark.c_file import CFile, NoCompilerError
from rodless_lab.benchmark.solvers.solver import MissingError, Solver
from rodless_lab.benchmark.work import DURATION, PERIOD, Array, Run, Work
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import Trace, simulate

# Milliseconds each: the best of several rounds, in turn.
REPEATS = 15
TOLERANCES = (100.0, 10.0, 1.0, 0.1, 0.01)


def as_users_call_it(work: Work) -> Run:
    """Return ``closed_loop`` or ``simulate``, with all they do around the compiled loop."""

    def run(_tolerance: float) -> Array:
        trace: Trace
        if work.voltages is None:
            trace = closed_loop(
                work.parameters, work.law, work.reference, DURATION, PERIOD, work.start
            )
        else:
            trace = simulate(work.parameters, work.voltages, PERIOD, work.start)
        return np.column_stack([trace.position, trace.velocity, trace.pressure_a, trace.pressure_b])

    return run


@cache
def c_file() -> CFile:
    """Compile the C file once; raises NoCompilerError."""
    return CFile()


def in_c(work: Work) -> Run:
    """Return the loop in C."""
    try:
        compiled = c_file()
    except NoCompilerError as error:
        raise MissingError(str(error)) from error
    voltages = work.voltages
    if voltages is not None:
        return lambda tolerance: compiled.open_loop(
            work.plant, voltages, work.state, PERIOD, tolerance
        )
    return lambda tolerance: compiled.closed_loop(
        work.plant, work.gains, work.references, work.state, PERIOD, tolerance
    )[0]


COMPILED = Solver(
    "this package, compiled loop",
    "ROS3, errors of 10 nm, 10 µm/s and 2 Pa a step",
    lambda work: work.run,
    TOLERANCES,
    REPEATS,
)
CALLED = Solver(
    "this package, as called",
    "`closed_loop()`, `simulate()`",
    as_users_call_it,
    (1.0,),
    REPEATS,
)
IN_C = Solver(
    "C file",
    "the same scheme, `benchmarks/rig.c`, `cc -O3`",
    in_c,
    TOLERANCES,
    REPEATS,
)
