# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""All solvers on the same work: how long they take, and how far from the converged solution."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from rodless_lab.benchmark.solvers.casadi_cvodes import CVODES_BY_CASADI
from rodless_lab.benchmark.solvers.ours import CALLED, COMPILED, IN_C
from rodless_lab.benchmark.solvers.scipy_solvers import LSODA, RADAU, RK45
from rodless_lab.benchmark.solvers.solver import MissingError, Solver
from rodless_lab.benchmark.solvers.sundae import CVODE_BY_SUNDAE
from rodless_lab.benchmark.work import DURATION, Array, Errors, Run, Work, all_work

QUICK = (IN_C, COMPILED, CALLED)
OTHERS = (CVODES_BY_CASADI, CVODE_BY_SUNDAE, RK45, LSODA, RADAU)

# What this package promises of a run. Of each other solver the tables show the quickest tolerance
# that keeps it in every closed loop, or else the smallest.
PROMISED = Errors(1e-6, 100.0)


class Measured(NamedTuple):
    """One solver at one tolerance on one work."""

    solver: Solver
    work: Work
    tolerance: float
    seconds: float  # of processor time, the best of the repeats
    errors: Errors

    @property
    def speed(self) -> float:
        """Simulated seconds per second of processor time."""
        return DURATION / self.seconds


@dataclass
class SideBySide:
    """What has been measured, and what is missing: its solver and how to get it."""

    work: list[Work]
    measured: list[Measured] = field(default_factory=list)
    missing: dict[str, str] = field(default_factory=dict)

    def of(self, solver: Solver, work: Work) -> list[Measured]:
        """Return what there is of one solver on one work, loosest tolerance first."""
        return [found for found in self.measured if found[:2] == (solver, work)]

    def tolerance(self, solver: Solver) -> float | None:
        """Return the tolerance that the tables show of a solver; None where it is missing."""
        rungs: dict[float, list[Measured]] = {}
        for found in self.measured:
            if found.solver is solver and found.work.is_closed:
                rungs.setdefault(found.tolerance, []).append(found)
        if solver in QUICK or not rungs:
            return 1.0 if rungs else None
        times = {
            tolerance: sum(found.seconds for found in rung)
            for tolerance, rung in rungs.items()
            if all(map(keeps_the_promise, rung))
        }
        return min(times, key=times.__getitem__) if times else min(rungs)

    def shown(self, solver: Solver, work: Work) -> Measured | None:
        """Return what the tables show of a solver on one work."""
        tolerance = self.tolerance(solver)
        there = (found for found in self.of(solver, work) if found.tolerance == tolerance)
        return next(there, None)

    def to_measure(self, solver: Solver, work: Work) -> Sequence[float]:
        """Return the tolerances to try: all in closed loop, then the one that is shown."""
        tolerance = self.tolerance(solver)
        return solver.tolerances if work.is_closed or tolerance is None else (tolerance,)

    def ratio(self, found: Measured) -> float:
        """Return its time in units of this package's compiled loop on the same work."""
        (ours,) = (one for one in self.of(COMPILED, found.work) if one.tolerance == 1.0)
        return found.seconds / ours.seconds

    def figures(self) -> dict[str, float]:
        """Return all numbers of the tables by name."""
        numbers = {}
        for solver in (*QUICK, *OTHERS):
            for found in filter(None, (self.shown(solver, work) for work in self.work)):
                name = f"{found.work.name}: {solver.name.replace('`', '')}"
                numbers[f"{name}, × real time"] = found.speed
                numbers[f"{name}, time ÷ this package's"] = self.ratio(found)
                numbers[f"{name}, position error (µm)"] = found.errors.position * 1e6
                numbers[f"{name}, pressure error (Pa)"] = found.errors.pressure
        return numbers


def keeps_the_promise(found: Measured) -> bool:
    """Whether its errors are within ``PROMISED``."""
    return found.errors.position <= PROMISED.position and found.errors.pressure <= PROMISED.pressure


class Timed(NamedTuple):
    """One run."""

    seconds: float  # of processor time
    rows: Array


def timed(run: Run, tolerance: float) -> Timed:
    """Run once."""
    start = time.process_time()
    rows = run(tolerance)
    return Timed(time.process_time() - start, rows)


def measured(
    solvers: Mapping[Solver, Sequence[float]], work: Work, missing: dict[str, str]
) -> Iterator[Measured]:
    """Measure solvers at their tolerances on one work.

    At each tolerance they take turns, so that all meet the same disturbances.
    """
    runs: dict[Solver, Run] = {}
    for solver in solvers:
        try:
            runs[solver] = solver.prepare(work)
        except MissingError as error:
            missing[solver.name] = str(error)
    for tolerance in sorted({t for solver in runs for t in solvers[solver]}, reverse=True):
        taking = {solver: run for solver, run in runs.items() if tolerance in solvers[solver]}
        done: dict[Solver, list[Timed]] = {solver: [] for solver in taking}
        for turn in range(max(solver.repeats for solver in taking)):
            for solver, run in taking.items():
                if turn < solver.repeats:
                    done[solver].append(timed(run, tolerance))
        for solver, found in done.items():
            seconds = min(one.seconds for one in found)
            yield Measured(solver, work, tolerance, seconds, work.errors(found[-1].rows))


def bench_side_by_side(check: Callable[[], object]) -> SideBySide:
    """Measure everything; ``check`` is called after each solver.

    All tolerances are tried in closed loop, and those that the tables show open loop.
    """
    found = SideBySide(all_work())
    for work in found.work:
        for solvers in (QUICK, *((other,) for other in OTHERS)):
            tolerances = {solver: found.to_measure(solver, work) for solver in solvers}
            found.measured += measured(tolerances, work, found.missing)
            check()
    return found
