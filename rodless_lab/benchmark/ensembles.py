# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""How many rigs run at once: on one core and on all of them, and in how much memory.

The C file's loop, spread over the cores in the same way, shows what the cores of the machine share.
"""

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from statistics import median

import psutil

from rodless_control import PidParameters, references
from rodless_lab.benchmark.c_file import NoCompilerError
from rodless_lab.benchmark.solvers.ours import c_file
from rodless_lab.benchmark.work import PERIOD, Work
from rodless_lab.simulation.draw import draw
from rodless_lab.simulation.ensemble import ensemble
from rodless_lab.simulation.in_order import cores
from rodless_sim import RigParameters

DURATION = 6.0  # s
PRESETS = ("paper", "calibrated")

# Rigs of a round, on one core and on all; of the long run, whose memory is looked at; and how often
# the C file runs in a round.
FEW = 400
MANY = 10_000
OF_C = 800

# One core and all in turn, so that what else the machine does hits both; many and short, because a
# core's own speed differs by a third from one second to the next where others share the machine.
ROUNDS = 9

STEP = references.step(0.0, 0.058, at=0.1)
DRAWN = {"cylinder.moving_mass": (0.7, 2.0), "supply.pressure": (501325.0, 701325.0)}
FACTORS = {"friction.*.static": (0.7, 1.3), "friction.*.coulomb": (0.7, 1.3)}


def bench_ensembles(
    check: Callable[[], object], few: int = FEW, many: int = MANY, of_c: int = OF_C
) -> dict[str, float]:
    """Return rig-seconds per second, how they grow with the cores, and memory (MB), by name."""
    figures: dict[str, float] = {}
    for preset in PRESETS:
        figures |= _of_preset(preset, check, few, many)
    try:
        run = _in_c()
    except NoCompilerError as error:
        print(f"C file: left out: {error}", file=sys.stderr)
        return figures
    alone, together = in_turn(lambda workers: _of_c_seconds(run, of_c, workers or cores()), check)
    return figures | {f"C file, {cores()} cores ÷ one": alone / together}


def _of_preset(preset: str, check: Callable[[], object], few: int, many: int) -> dict[str, float]:
    law = PidParameters.preset(preset)

    def rigs(count: int) -> Iterator[RigParameters]:
        base = RigParameters.preset(preset)
        for rig in draw(DRAWN, count, base, factors=FACTORS):
            check()
            yield rig

    def control(count: int, workers: int | None = None) -> float:
        return _seconds(lambda: ensemble(rigs(count), law, STEP, DURATION, PERIOD, workers=workers))

    control(1)  # compiles
    alone, together = in_turn(lambda workers: control(few, workers), check)
    before = _megabytes()
    long = control(many)
    return {
        f"{preset}, {few} rigs on one core, rig-seconds per second": few * DURATION / alone,
        f"{preset}, {few} rigs, {cores()} cores ÷ one": alone / together,
        f"{preset}, {many} rigs, rig-seconds per second": many * DURATION / long,
        f"{preset}, memory after {few} rigs (MB)": before,
        f"{preset}, memory after {many} rigs (MB)": _megabytes(),
    }


def in_turn(
    seconds: Callable[[int | None], float], check: Callable[[], object]
) -> tuple[float, float]:
    """Return the seconds of the work on one core and on all: of the round with the median ratio."""
    rounds = []
    for _ in range(ROUNDS):
        check()
        rounds.append((seconds(1), seconds(None)))
    middle = median(alone / together for alone, together in rounds)
    return min(rounds, key=lambda one: abs(one[0] / one[1] - middle))


def _in_c() -> Callable[[object], object]:
    """Return six seconds of the paper's step by the C file."""
    work, compiled = Work("paper", "step"), c_file()
    constants = work.plant, work.gains, work.references, work.state, PERIOD, 1.0
    return lambda _: compiled.closed_loop(*constants)


def _of_c_seconds(run: Callable[[object], object], count: int, workers: int) -> float:
    """Return how long ``count`` runs take, in as many threads as there are ``workers``.

    Each thread has its share at once: a run is so short that handing it over would be measured.
    All shares are as long as the longest, so that no thread is waited for.
    """
    each = -(-count // workers)

    def share(_: object) -> None:
        for _ in range(each):
            run(None)

    with ThreadPoolExecutor(workers) as pool:
        timed = _seconds(lambda: list(pool.map(share, range(workers))))
    return timed * count / (each * workers)


def _seconds(work: Callable[[], object]) -> float:
    """Return how long ``work`` takes by the clock on the wall (s)."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def _megabytes() -> float:
    """Return the memory that this process occupies, in MB."""
    return float(psutil.Process().memory_info().rss) / 1e6
