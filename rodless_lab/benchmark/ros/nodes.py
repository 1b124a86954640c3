"""What the nodes cost and how well they keep time, measured over DDS on this machine."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import psutil
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.ros.message_info import Info
from rodless_base.ros.topics import QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.benchmark.statistics import answer_times, milliseconds, statistics
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, SessionProcesses, run_rig

# Wall-clock seconds: of a measurement in real time, and of waiting for the nodes to appear.
MEASURED_SECONDS = 8.0
START_SECONDS = 120.0

# Plant time of a lock-step measurement, long enough for several diagnostics.
LOCKSTEP_SECONDS = 90.0

STEP = {"reference.type": "step", "reference.at": 0.5, "reference.target": 0.058}


@dataclass
class Bench:
    """A rig and an observer beside it, which subscribes to nothing but what is measured."""

    processes: SessionProcesses
    observer: Observer

    def listen(self, kind: type, topic: str, times: list[tuple[int, int]]) -> None:
        """Append to ``times`` when each message on ``topic`` was sent and received, in ns."""

        def take(_message: object, info: Info) -> None:
            times.append((info["source_timestamp"], time.time_ns()))

        self.observer.subscribe(kind, topic, take, info=True, depth=QUEUE_DEPTH)

    def processor_seconds(self) -> dict[str, float]:
        """Processor time that each process has used, in s."""
        times = {name: psutil.Process(pid).cpu_times() for name, pid in self.processes.pids.items()}
        return {name: float(used.user + used.system) for name, used in times.items()}

    def megabytes(self) -> dict[str, float]:
        """Memory that each process occupies, in MB."""
        pids = self.processes.pids
        return {name: psutil.Process(pid).memory_info().rss / 1e6 for name, pid in pids.items()}


@contextmanager
def bench(
    check: Callable[[], object],
    plant: Mapping[str, object],
    controller: Mapping[str, object],
    one_process: bool = False,
) -> Iterator[Bench]:
    """Run the rig in a domain of its own; ``check`` is called all the while."""
    plan = ProcessPlan(plant=plant, controller=controller, one_process=one_process)
    with own_domain() as environment, run_rig(plan, environment) as processes:

        def check_all() -> None:
            processes.check()
            check()

        with Observer(environment, timeout=START_SECONDS, check=check_all) as observer:
            yield Bench(processes, observer)


def bench_realtime(rate: float, check: Callable[[], object]) -> dict[str, float]:
    """Period of the samples at ``rate`` (Hz), latency of the loop, cost of the nodes."""
    samples: list[tuple[int, int]] = []
    commands: list[tuple[int, int]] = []
    with bench(check, {"time.period": 1.0 / rate}, {}) as rig:
        rig.listen(JointState, JOINT_STATES, samples)
        rig.listen(Float64, VALVE_VOLTAGE, commands)
        rig.observer.wait(lambda: min(len(samples), len(commands)) > rate, "samples and commands")
        samples.clear()
        commands.clear()
        before = rig.processor_seconds()
        start = time.monotonic()
        rig.observer.wait(lambda: time.monotonic() - start > MEASURED_SECONDS, "the measurement")
        elapsed = time.monotonic() - start
        used, memory = rig.processor_seconds(), rig.megabytes()
    label = f"realtime {rate:g} Hz"
    sent, received = np.array(samples).T
    figures = {f"{label}: samples per second": len(samples) / elapsed}
    figures |= statistics(f"{label}: period at a subscriber", milliseconds(np.diff(received)))
    figures |= statistics(f"{label}: sample sent to sample received", milliseconds(received - sent))
    answers = answer_times(sent, np.array(commands))
    figures |= statistics(f"{label}: sample sent to command received", milliseconds(answers))
    for name in used:
        figures[f"{label}: {name} node, share of a core"] = (used[name] - before[name]) / elapsed
        figures[f"{label}: {name} node, memory (MB)"] = memory[name]
    return figures


def bench_lockstep(one_process: bool, check: Callable[[], object]) -> dict[str, float]:
    """Plant seconds per wall-clock second in lock-step at 1 kHz."""
    plant = {"time.mode": "lockstep", "time.duration": LOCKSTEP_SECONDS}
    seen: list[tuple[float, float]] = []

    def take(message: DiagnosticArray) -> None:
        if message.status[0].name == "/plant":
            stamp = message.header.stamp
            seconds = stamp.sec + stamp.nanosec * SECONDS_PER_NANOSECOND
            seen.append((time.monotonic(), seconds))

    with bench(check, plant, STEP, one_process) as rig:
        rig.observer.subscribe(DiagnosticArray, "/diagnostics", take)
        rig.observer.wait(lambda: seen and seen[-1][1] >= LOCKSTEP_SECONDS, "the end of the run")
    under_way = [(wall, plant) for wall, plant in seen if 0.0 < plant < LOCKSTEP_SECONDS]
    (first_wall, first), (last_wall, last) = under_way[0], under_way[-1]
    kind = "one process" if one_process else "two processes"
    return {
        f"lockstep, {kind}: plant s per wall-clock s": (last - first) / (last_wall - first_wall)
    }
