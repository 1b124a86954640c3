# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lock-step outlives those who listen and those who command: killed, stopped, started again."""

import itertools
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from extent import some_of
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from running import StartProcess, StartRig, until_it_says
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from rodless_base.ros.message_info import take_waiting, with_info
from rodless_base.ros.topics import LOSSLESS, stamp_nanoseconds
from rodless_base.topics import PRESSURES
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import SessionProcesses

pytestmark = pytest.mark.slow

PERIOD = 1_000_000

LOCKSTEP = {"time.mode": "lockstep", "time.command_timeout": 2.0}
SINE = {"reference.type": "sine"}

# From the signal to the end of the process, in wall-clock s.
STOP_SECONDS = 2.0

# Of a reader that the middleware has to give up, 20 s, and a crowded machine.
TIMEOUT = 120.0

# Reads every sample and says whether one is missing.
LISTENER = """
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from rodless_base.ros.topics import LOSSLESS, stamp_nanoseconds
last = None
def take(message):
    global last
    stamp = stamp_nanoseconds(message.header.stamp)
    if last is None:
        print("listening", flush=True)
    elif stamp not in (last, last + 1_000_000):
        print("gap", last, stamp, flush=True)
    last = stamp
    if stamp % 1_000_000_000 == 0:
        print("second", flush=True)
rclpy.init()
node = Node("listener")
node.create_subscription(JointState, "/joint_states", take, LOSSLESS)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


@pytest.fixture
def rig(start_rig: StartRig) -> Iterator[SessionProcesses]:
    """Run plant and controller in lock-step, in a process each."""
    with start_rig(plant=LOCKSTEP, controller=SINE) as processes:
        yield processes


@pytest.fixture
def listener(start_rig: StartRig, start_process: StartProcess) -> Iterator[NodeProcess]:
    """Run somebody who wants every sample and whom the plant has not been told to wait for.

    Plant and controller share a process: before the middleware misses a stopped listener, its
    queue of 5000 messages is full on a crowded machine, too.
    """
    with (
        start_rig(plant=LOCKSTEP, controller=SINE, one_process=True),
        listening(start_process) as process,
    ):
        yield process


@contextmanager
def listening(start_process: StartProcess) -> Iterator[NodeProcess]:
    """Run the reader of every sample, from its first on."""
    with start_process([sys.executable, "-c", LISTENER], "listener") as process:
        until_it_says(process, "listening")
        yield process


class Stamps:
    """Plant times that the observer has seen."""

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._seen: list[JointState] = observer.collect(JointState, "/joint_states")

    def go_on(self, seconds: float = 0.5) -> None:
        """Wait until plant time has advanced by that much from now on."""
        self._observer.more(self._seen, 1, TIMEOUT)
        end = self.last + round(seconds * 1e9)
        self._observer.wait(lambda: self.last >= end, "plant time to advance", TIMEOUT)

    @property
    def last(self) -> int:
        """Plant time of the newest sample in ns."""
        return stamp_nanoseconds(self._seen[-1].header.stamp)

    @property
    def steps(self) -> set[int]:
        """What the stamps differ by from one to the next."""
        stamps = [stamp_nanoseconds(message.header.stamp) for message in self._seen]
        return {later - former for former, later in itertools.pairwise(stamps)}


def wait_for(observer: Observer, text: str) -> str:
    """Wait until the plant says ``text`` in its diagnostics; return all it says there."""

    def said() -> str:
        message = observer.diagnostic("/plant", fresh=True).message
        return message if text in message else ""

    return observer.wait(said, text, TIMEOUT)


def test_a_stopped_listener_holds_the_plant_and_misses_nothing(
    listener: NodeProcess, observer: Observer
) -> None:
    """The plant names it and not the controller; thawed, it has every sample."""
    stamps = Stamps(observer)
    # It has samples before others have its name, some 3 s, and frozen it tells them nothing.
    for _ in range(4):
        observer.diagnostic("/plant", fresh=True)
    listener.freeze()
    message = wait_for(observer, "has stopped reading")
    assert "/listener" in message
    assert "no command" not in message
    seconds = listener.output.count("second")
    listener.thaw()
    observer.wait(lambda: listener.output.count("second") > seconds + 7, "the listener", TIMEOUT)
    assert "gap" not in listener.output
    assert stamps.steps <= {0, PERIOD}
    assert observer.counter("/plant", "messages lost to a stopped subscriber") == 0


@pytest.mark.parametrize("one_process", some_of([True, False], 2))
def test_a_plant_that_a_stopped_listener_holds_ends_on_request(
    start_rig: StartRig, start_process: StartProcess, observer: Observer, one_process: bool
) -> None:
    """Each try to publish takes longer than the time to the next, so it never has nothing to do."""
    with (
        start_rig(plant=LOCKSTEP, controller=SINE, one_process=one_process) as processes,
        listening(start_process) as listener,
    ):
        listener.freeze()
        wait_for(observer, "has stopped reading")
        for name in processes.names:
            processes[name].signal(signal.SIGINT)
        for name in processes.names:
            assert processes[name].wait(STOP_SECONDS) == 0


def test_a_killed_listener_does_not_hold_the_plant_for_good(
    listener: NodeProcess, observer: Observer
) -> None:
    """Once the middleware has given it up the run goes on, and nobody else has missed a sample."""
    stamps = Stamps(observer)
    listener.kill()
    wait_for(observer, "has stopped reading")
    wait_for(observer, "running")
    stamps.go_on()
    assert stamps.steps <= {0, PERIOD}
    assert observer.counter("/plant", "messages lost to a stopped subscriber") == 0


def test_a_killed_controller_that_is_started_again_goes_on(
    rig: SessionProcesses, observer: Observer
) -> None:
    """Whether or not the middleware still lists the dead one: one answers, so there is one."""
    stamps = Stamps(observer)
    stamps.go_on()
    rig["controller"].kill()
    rig["controller"].start()
    until_it_says(rig["controller"], "ready: lockstep")
    stamps.go_on()
    assert stamps.steps <= {0, PERIOD}


def test_a_second_publisher_of_another_name_holds_the_plant(
    rig: SessionProcesses,  # noqa: ARG001  runs
    observer: Observer,
) -> None:
    """The plant names both and waits; when it is gone, the run goes on where it was."""
    stamps = Stamps(observer)
    stamps.go_on()
    second = observer.publisher(Float64, "/valve/voltage")
    assert "/controller, /observer" in wait_for(observer, "/observer")
    observer.node.destroy_publisher(second)
    stamps.go_on()
    assert stamps.steps <= {0, PERIOD}


@pytest.mark.parametrize("one_process", some_of([False, True], 2))
def test_answers_wait_for_a_slow_reader_as_samples_do(
    start_rig: StartRig, observer: Observer, one_process: bool
) -> None:
    """A recorder that is 8000 samples behind: its queue takes 5000, the rest wait, none is lost."""
    numbers: list[int] = []
    node = Node("slow", context=observer.context, use_global_arguments=False)
    take = with_info(lambda _, info: numbers.append(info["publication_sequence_number"]))
    answers = node.create_subscription(Float64, "/valve/voltage", take, LOSSLESS)
    # It begins once somebody hears all of it, and that is when the slow one is known.
    plant = {**LOCKSTEP, "time.duration": 8.0, "time.recorders": 1}
    try:
        with start_rig(plant=plant, controller=SINE, one_process=one_process):
            observer.wait(answers.get_publisher_count, "the controller to be found", TIMEOUT)
            for topic in PRESSURES.values():
                observer.subscribe(FluidPressure, f"/{topic}", lambda _: None)
            observer.subscribe(Clock, "/clock", lambda _: None)
            observer.subscribe(JointState, "/joint_states", lambda _: None)
            observer.wait(
                lambda: observer.diagnostic("/plant", fresh=True).message.startswith("ended"),
                "the end of the run",
                TIMEOUT,
            )

            def all_is_taken() -> bool:
                take_waiting(answers)
                # To each of the 8000 steps there is one; the first may go before it listens.
                return bool(numbers) and numbers[-1] >= 8000

            observer.wait(all_is_taken, "the last answers", TIMEOUT)
    finally:
        node.destroy_node()
    assert set(np.diff(numbers)) == {1}
