"""How fast the closed loop runs in this process, compiled and as plain Python."""

import os
import subprocess
import sys
import time
from collections.abc import Callable

from rodless_control import PidParameters, references
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters

SIMULATED_SECONDS = 10.0
REPEATS = 7


def run_closed_loop(duration: float) -> None:
    """Run the step of section 6.2 at 1 kHz for ``duration`` s of plant time."""
    closed_loop(
        RigParameters.preset("paper"),
        PidParameters.preset("paper"),
        references.step(0.0, 0.058, at=0.5),
        duration,
        1e-3,
    )


def seconds(function: Callable[[], object]) -> float:
    """Wall-clock time of one call in s."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def bench_closed_loop() -> dict[str, float]:
    """Time the closed loop, compiled (median of several runs after warm-up) and plain."""
    run_closed_loop(0.01)
    times = sorted(seconds(lambda: run_closed_loop(SIMULATED_SECONDS)) for _ in range(REPEATS))
    median = times[REPEATS // 2]
    plain = float(
        subprocess.run(
            [sys.executable, "-c", UNCOMPILED],
            env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    )
    return {
        "closed loop, 10 s at 1 kHz, wall-clock s (median)": median,
        "closed loop, plant seconds per wall-clock second": SIMULATED_SECONDS / median,
        "closed loop, plain Python's time per compiled time": plain * SIMULATED_SECONDS / median,
    }


UNCOMPILED = (
    "from rodless_lab.benchmark.closed_loop import run_closed_loop, seconds;"
    "print(seconds(lambda: run_closed_loop(1.0)))"
)
