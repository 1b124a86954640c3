"""`rodless bench`: what the kernels and the nodes cost on this machine."""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import psutil
import rclpy
from rclpy.executors import Executor
from sensor_msgs.msg import JointState

from rodless_base.ros_names import JOINT_STATES, QUEUE_DEPTH
from rodless_base.ros_process import make_executor
from rodless_base.start import Stop
from rodless_control import PidParameters, references
from rodless_lab.closed_loop import closed_loop
from rodless_lab.domain import own_domain
from rodless_lab.processes import RigProcesses
from rodless_sim import RigParameters

SIMULATED_SECONDS = 10.0
REPEATS = 7
NODE_SECONDS = 10.0
START_SECONDS = 60.0


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Print a table and write it as JSON."""
    parser = argparse.ArgumentParser(prog="rodless bench", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("results/bench/metrics.json"))
    output = parser.parse_args(arguments).output
    figures = {**bench_closed_loop(), **bench_nodes()}
    for name, value in figures.items():
        print(f"{name:58} {value:10.4g}")
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
    "from rodless_lab.bench import run_closed_loop, seconds;"
    "print(seconds(lambda: run_closed_loop(1.0)))"
)


def bench_nodes() -> dict[str, float]:
    """Run plant and controller over DDS at 1 kHz; share of a core and memory of each."""
    with own_domain() as environment, RigProcesses(environment=environment) as rig:
        os.environ.update(environment)
        rclpy.init()
        arrivals: list[float] = []
        node = rclpy.create_node("bench")
        node.create_subscription(
            JointState, JOINT_STATES, lambda _: arrivals.append(time.monotonic()), QUEUE_DEPTH
        )
        executor = make_executor()
        executor.add_node(node)
        _spin_until(executor, lambda: len(arrivals) > QUEUE_DEPTH, START_SECONDS)
        arrivals.clear()
        processes = {name: psutil.Process(pid) for name, pid in rig.pids.items()}
        before = {name: _cpu(process) for name, process in processes.items()}
        start = time.monotonic()
        _spin_until(executor, lambda: time.monotonic() - start > NODE_SECONDS, 2 * NODE_SECONDS)
        elapsed = time.monotonic() - start
        figures = {"plant node, samples per second (1000 wanted)": len(arrivals) / elapsed}
        for name, process in processes.items():
            figures[f"{name} node, share of a core"] = (_cpu(process) - before[name]) / elapsed
            figures[f"{name} node, memory in MB"] = process.memory_info().rss / 1e6
        node.destroy_node()
        rclpy.shutdown()
    return figures


def _spin_until(executor: Executor, done: Callable[[], bool], longest: float) -> None:
    end = time.monotonic() + longest
    while not done():
        if time.monotonic() > end:
            raise TimeoutError("the rig did not answer")
        executor.spin_once(timeout_sec=0.1)


def _cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)
