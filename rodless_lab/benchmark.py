"""`rodless bench`: what the kernels and the nodes cost on this machine."""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from rodless_base.start import Stop
from rodless_control import PidParameters, references
from rodless_lab.bench_nodes import bench_lockstep, bench_realtime
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters

SIMULATED_SECONDS = 10.0
REPEATS = 7


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Print a table and write it as JSON."""
    parser = argparse.ArgumentParser(prog="rodless bench", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("results/bench/metrics.json"))
    output = parser.parse_args(arguments).output
    figures = bench_closed_loop()
    for rate in (100.0, 500.0, 1000.0):
        figures |= bench_realtime(rate)
    for one_process in (False, True):
        figures |= bench_lockstep(one_process)
    for name, value in figures.items():
        print(f"{name:66} {value:10.4g}")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    return 0


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
    "from rodless_lab.benchmark import run_closed_loop, seconds;"
    "print(seconds(lambda: run_closed_loop(1.0)))"
)
