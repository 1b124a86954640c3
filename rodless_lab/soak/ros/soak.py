# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller for an hour of real time, and for ten million steps in lock-step."""

import time
from array import array
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from sensor_msgs.msg import JointState

from rodless_base.constants import NANOSECONDS_PER_SECOND
from rodless_base.ros.topics import LOSSLESS, stamp_nanoseconds
from rodless_base.topics import JOINT_STATES
from rodless_control import PidParameters, references
from rodless_control.controller_parameters import ControllerParameters
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, SessionProcesses, run_rig
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_lab.soak.balance import Balance, balance
from rodless_lab.soak.memory import growth, resident
from rodless_sim import RigParameters

PERIOD = 1e-3  # s
NANOSECONDS = round(PERIOD * NANOSECONDS_PER_SECOND)
SINE = {"reference.type": "sine"}

# From one reading of memory and one word on progress to the next, in wall-clock s.
READING = 5.0

# For the nodes to start, and for the next sample to come, in wall-clock s.
START = 240.0


@dataclass
class Soak:
    """What a long run has shown."""

    mode: str
    seconds: float = 0.0  # of wall clock
    samples: int = 0
    lost: int = 0  # samples that are missing between two that came
    differing: int = 0  # samples whose position is not that of the run without nodes
    memory: dict[str, list[tuple[float, float]]] = field(default_factory=dict)  # s, MB
    faults: dict[str, str] = field(default_factory=dict)
    balance: Balance | None = None

    @property
    def growth(self) -> dict[str, float]:
        """How fast the memory of each process grows, in MB/h."""
        return {name: growth(readings) for name, readings in self.memory.items()}


@dataclass
class _Listener:
    """Counts samples, and those missing between them; keeps positions where asked to."""

    positions: "array[float] | None" = None
    count: int = 0
    lost: int = 0
    first: int | None = None  # ns
    last: int = 0

    def take(self, message: JointState) -> None:
        stamp = stamp_nanoseconds(message.header.stamp)
        if self.first is None:
            # What came before this listener is none of its.
            self.first, self.last = stamp, stamp - NANOSECONDS
        if stamp == self.last:  # offered again
            return
        self.lost += (stamp - self.last) // NANOSECONDS - 1
        self.last = stamp
        self.count += 1
        if self.positions is not None:
            self.positions.append(message.position[0])


def soak_realtime(seconds: float, tell: Callable[[str], None], check: Callable[[], object]) -> Soak:
    """Run for so many s of wall clock; ``check`` is called all the while and may raise."""
    found = Soak("realtime")
    with _rig({"time.period": PERIOD}, check) as (processes, observer):
        listener = _Listener()
        observer.subscribe(JointState, JOINT_STATES, listener.take)
        observer.wait(lambda: listener.count, "the first sample", START)
        _watch(found, processes, observer, lambda: found.seconds >= seconds, listener, tell)
    return found


def soak_lockstep(steps: int, tell: Callable[[str], None], check: Callable[[], object]) -> Soak:
    """Run so many steps, and compare each sample with the run without nodes."""
    found = Soak("lockstep")
    plant = {
        "time.mode": "lockstep",
        "time.period": PERIOD,
        "time.duration": steps * PERIOD,
    }
    listener = _Listener(array("d"))
    # First: where so many samples have no room, that is known before the hours of the run.
    parameters = RigParameters.preset("paper")
    run = closed_loop(parameters, PidParameters.preset("paper"), _sine(), steps * PERIOD, PERIOD)
    with _rig(plant, check) as (processes, observer):
        observer.node.create_subscription(JointState, JOINT_STATES, listener.take, LOSSLESS)
        observer.wait(lambda: listener.count, "the first sample", START)
        end = steps * NANOSECONDS
        _watch(found, processes, observer, lambda: listener.last >= end, listener, tell)
    assert listener.positions is not None
    assert listener.first is not None
    seen = np.array(listener.positions)
    # With a sample missing, all after it differ.
    expected = run.position[listener.first // NANOSECONDS :][: seen.size]
    found.differing = int(np.count_nonzero(seen != expected))
    found.balance = balance(parameters, run, PERIOD)
    return found


def _sine() -> references.Reference:
    values = ControllerParameters(SINE)
    names = ("centre", "amplitude", "frequency", "at")
    centre, amplitude, frequency, at = (values.number(f"reference.{name}") for name in names)
    return references.sine(centre, amplitude, frequency, at=at)


@contextmanager
def _rig(
    plant: Mapping[str, object], check: Callable[[], object]
) -> Iterator[tuple[SessionProcesses, Observer]]:
    """Run a rig in a domain of its own, and an observer beside it."""
    plan = ProcessPlan(plant=plant, controller=SINE)
    with own_domain() as environment, run_rig(plan, environment) as processes:

        def check_all() -> None:
            processes.check()
            check()

        with Observer(environment, timeout=START, check=check_all) as observer:
            yield processes, observer


def _watch(
    found: Soak,
    processes: SessionProcesses,
    observer: Observer,
    is_over: Callable[[], bool],
    listener: _Listener,
    tell: Callable[[str], None],
) -> None:
    """Let the rig run until ``is_over``, and write down what is seen."""
    began = due = time.monotonic()
    found.memory = {name: [] for name in processes.names}

    def look() -> bool:
        nonlocal due
        found.seconds = time.monotonic() - began
        if time.monotonic() >= due:
            due += READING
            for name, pid in processes.pids.items():
                found.memory[name].append((found.seconds, resident(pid)))
            found.samples, found.lost = listener.count, listener.lost
            sizes = ", ".join(f"{name} {all_[-1][1]:.1f} MB" for name, all_ in found.memory.items())
            tell(f"{found.seconds:.0f} s: {found.samples} samples, {found.lost} lost; {sizes}")
        return is_over()

    _ = observer.diagnostics
    seen = -1

    def goes_on() -> bool:
        return look() or listener.count > seen

    while not look():
        seen = listener.count
        observer.wait(goes_on, "samples", START)
    found.samples, found.lost = listener.count, listener.lost
    for node in ("/plant", "/controller"):
        said = observer.diagnostic(node)
        counts = {key: value for key, value in said.values.items() if "lost" in key}
        found.faults |= {f"{node} {key}": value for key, value in counts.items()}
