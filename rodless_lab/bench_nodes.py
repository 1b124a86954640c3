"""What the nodes cost and how well they keep time, measured over DDS on this machine."""

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt
import psutil
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import Executor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.ros.message_info import Info, with_info
from rodless_base.ros.process import make_executor
from rodless_base.ros.topics import JOINT_STATES, QUEUE_DEPTH, VALVE_VOLTAGE
from rodless_lab.session.domain import own_domain
from rodless_lab.session.processes import RigProcesses

# Wall-clock seconds: of a measurement in real time, and of waiting for the nodes to appear.
MEASURED_SECONDS = 8.0
START_SECONDS = 120.0

# Plant time of a lock-step measurement, long enough for several diagnostics.
LOCKSTEP_SECONDS = 90.0

STEP = {"reference.type": "step", "reference.at": 0.5, "reference.target": 0.058}


class Watcher:
    """A node beside the rig that counts what it hears."""

    def __init__(self, rig: RigProcesses) -> None:
        """Listen for nothing yet."""
        self.rig = rig
        self.node: Node = rclpy.create_node("bench")
        self._executor: Executor = make_executor()
        self._executor.add_node(self.node)

    def listen(self, kind: type, topic: str, times: list[tuple[int, int]]) -> None:
        """Append to ``times`` when each message on ``topic`` was sent and received, in ns."""

        def take(_message: object, info: Info) -> None:
            times.append((info["source_timestamp"], time.time_ns()))

        self.node.create_subscription(kind, topic, with_info(take), QUEUE_DEPTH)

    def wait(self, done: Callable[[], bool], longest: float) -> None:
        """Run callbacks until ``done``; raises TimeoutError after ``longest`` s."""
        end = time.monotonic() + longest
        while not done():
            if time.monotonic() > end:
                raise TimeoutError("the rig did not answer")
            self.rig.check()
            self._executor.spin_once(timeout_sec=0.1)

    def close(self) -> None:
        """Destroy the node."""
        self._executor.remove_node(self.node)
        self.node.destroy_node()


@contextmanager
def watched_rig(
    plant: Mapping[str, object], controller: Mapping[str, object], one_process: bool = False
) -> Iterator[Watcher]:
    """Run the rig in a domain of its own, with a watcher."""
    with (
        own_domain() as environment,
        RigProcesses(
            plant=plant,
            controller=controller,
            environment=environment,
            one_process=one_process,
        ) as rig,
    ):
        os.environ.update(environment)
        rclpy.init()
        watcher = Watcher(rig)
        try:
            yield watcher
        finally:
            watcher.close()
            rclpy.shutdown()


def bench_realtime(rate: float) -> dict[str, float]:
    """Period of the samples at ``rate`` (Hz), latency of the loop, cost of the nodes."""
    samples: list[tuple[int, int]] = []
    commands: list[tuple[int, int]] = []
    with watched_rig({"time.period": 1.0 / rate}, {}) as watcher:
        watcher.listen(JointState, JOINT_STATES, samples)
        watcher.listen(Float64, VALVE_VOLTAGE, commands)
        watcher.wait(lambda: min(len(samples), len(commands)) > rate, START_SECONDS)
        samples.clear()
        commands.clear()
        processes = {name: psutil.Process(pid) for name, pid in watcher.rig.pids.items()}
        before = {name: _cpu(process) for name, process in processes.items()}
        start = time.monotonic()
        watcher.wait(lambda: time.monotonic() - start > MEASURED_SECONDS, 60.0)
        elapsed = time.monotonic() - start
        costs = {
            name: ((_cpu(process) - before[name]) / elapsed, process.memory_info().rss / 1e6)
            for name, process in processes.items()
        }
    label = f"realtime {rate:g} Hz"
    sent, received = np.array(samples).T
    figures = {f"{label}: samples per second": len(samples) / elapsed}
    figures |= statistics(f"{label}: period at a subscriber", milliseconds(np.diff(received)))
    figures |= statistics(f"{label}: sample sent to sample received", milliseconds(received - sent))
    answers = answer_times(sent, np.array(commands))
    figures |= statistics(f"{label}: sample sent to command received", milliseconds(answers))
    for name, (share, memory) in costs.items():
        figures[f"{label}: {name} node, share of a core"] = share
        figures[f"{label}: {name} node, memory (MB)"] = memory
    return figures


def milliseconds(nanoseconds: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Return times in ms."""
    return np.asarray(nanoseconds * 1e-6, dtype=np.float64)


def statistics(what: str, values: npt.NDArray[np.float64]) -> dict[str, float]:
    """Mean, quantiles and worst of ``values`` (ms, shape (n,)), by name."""
    return {
        f"{what}, mean (ms)": float(values.mean()),
        f"{what}, p50 (ms)": float(np.percentile(values, 50)),
        f"{what}, p99 (ms)": float(np.percentile(values, 99)),
        f"{what}, p99.9 (ms)": float(np.percentile(values, 99.9)),
        f"{what}, worst (ms)": float(values.max()),
    }


def answer_times(
    sent: npt.NDArray[np.int64], commands: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return how long after its sample each command was received, in ns, shape (m,).

    ``sent`` (ns, shape (n,)) is when samples were, ``commands`` (shape (k, 2)) when commands were
    sent and received. Each sample has one command, and most commands are sent before the next
    sample: that tells which sample the first command belongs to.
    """
    latest = np.searchsorted(sent, commands[:, 0], side="right") - 1
    offset = int(np.median(latest - np.arange(len(commands))))
    place = np.arange(len(commands)) + offset
    inside = (place >= 0) & (place < len(sent))
    return np.asarray(commands[inside, 1] - sent[place[inside]])


def bench_lockstep(one_process: bool) -> dict[str, float]:
    """Plant seconds per wall-clock second in lock-step at 1 kHz."""
    plant = {"time.mode": "lockstep", "time.duration": LOCKSTEP_SECONDS}
    # In one process the controller needs no clock: it is told not to mind a pause.
    controller = {**STEP, **(ONE_PROCESS if one_process else {})}
    seen: list[tuple[float, float]] = []

    def take(message: DiagnosticArray) -> None:
        if message.status[0].name == "/plant":
            stamp = message.header.stamp
            seen.append((time.monotonic(), stamp.sec + stamp.nanosec * 1e-9))

    with watched_rig(plant, controller, one_process) as watcher:
        watcher.node.create_subscription(DiagnosticArray, "/diagnostics", take, 100)
        watcher.wait(lambda: bool(seen) and seen[-1][1] >= LOCKSTEP_SECONDS, START_SECONDS)
    under_way = [(wall, plant) for wall, plant in seen if 0.0 < plant < LOCKSTEP_SECONDS]
    (first_wall, first), (last_wall, last) = under_way[0], under_way[-1]
    kind = "one process" if one_process else "two processes"
    return {
        f"lockstep, {kind}: plant s per wall-clock s": (last - first) / (last_wall - first_wall)
    }


ONE_PROCESS = {"use_sim_time": False, "controller.position_timeout": 0.0}


def _cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)
