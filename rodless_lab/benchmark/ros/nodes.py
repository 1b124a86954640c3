# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the nodes cost and how well they keep time, measured over DDS on this machine."""

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.ros.message_info import Info
from rodless_base.ros.topics import QUEUE_DEPTH, stamp_nanoseconds
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.benchmark.statistics import answer_times, milliseconds, statistics
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, SessionProcesses, run_rig

# Wall-clock seconds: of a measurement in real time, and of waiting for the nodes to appear.
MEASURED_SECONDS = 8.0
START_SECONDS = 120.0

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
    record: Path | None = None,
) -> Iterator[Bench]:
    """Run the rig in a domain of its own; ``check`` is called all the while."""
    plan = ProcessPlan(plant=plant, controller=controller, one_process=one_process, record=record)
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


def bench_lockstep(check: Callable[[], object]) -> dict[str, float]:
    """Lock-step at 1 kHz: in one process, in one that records itself, and in two."""
    with tempfile.TemporaryDirectory(prefix="rodless_sim-") as folder:
        bag = Path(folder, "bag")
        return {
            **_lockstep("one process", check, one_process=True),
            **_lockstep("one process with recorder", check, one_process=True, record=bag),
            **_lockstep("two processes", check),
        }


def _lockstep(
    kind: str, check: Callable[[], object], one_process: bool = False, record: Path | None = None
) -> dict[str, float]:
    """Plant seconds per wall-clock second and, whatever else runs, processor time."""
    # Plant time, wall clock, processor time of all nodes, in s.
    seen: list[tuple[float, float, float]] = []
    with bench(check, {"time.mode": "lockstep"}, STEP, one_process, record) as rig:

        def take(message: DiagnosticArray) -> None:
            if message.status[0].name == "/plant":
                seconds = stamp_nanoseconds(message.header.stamp) * SECONDS_PER_NANOSECOND
                used = sum(rig.processor_seconds().values())
                seen.append((seconds, time.monotonic(), used))

        rig.observer.subscribe(DiagnosticArray, "/diagnostics", take)
        # The first report after the start is of a run that has just begun.
        rig.observer.wait(lambda: sum(one[0] > 0.0 for one in seen) > 1, "a run under way")
        first, start = seen[-1], time.monotonic()
        rig.observer.wait(lambda: time.monotonic() - start > MEASURED_SECONDS, "the measurement")
    advanced, elapsed, used = np.subtract(seen[-1], first)
    return {
        f"lockstep, {kind}: plant s per wall-clock s": advanced / elapsed,
        f"lockstep, {kind}: processor s per plant s": used / advanced,
    }
