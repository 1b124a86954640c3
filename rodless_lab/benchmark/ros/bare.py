# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What rclpy alone costs: two nodes that hand each other messages as large as the rig's.

The limit for the nodes of this package in two processes: no plant, no law, nothing else published.
Each runs in a process of its own, ``python -m rodless_lab.benchmark.ros.bare plant`` or
``controller``, and prints messages taken per second of wall clock and its share of a core.
"""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import CARRIAGE, NANOSECONDS_PER_SECOND
from rodless_base.ros.process import SPIN_SECONDS, leave_ros, make_executor
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.domain import own_domain
from rodless_sim.node.pacing import Pacer

MEASURED_SECONDS = 6.0

# Until the nodes have found each other, on a crowded machine (s).
FIND_SECONDS = 60.0

ROLES = ("plant", "controller")


def bench_bare(rate: float, check: Callable[[], object]) -> dict[str, float]:
    """Return the figures at ``rate`` (Hz), or with 0 of nodes that answer each other at once.

    ``check`` is called all the while. Raises RuntimeError where one of the two fails.
    """
    with own_domain() as environment, ExitStack() as stack:
        runs = {
            role: stack.enter_context(_started(role, rate, {**os.environ, **environment}))
            for role in ROLES
        }
        # All of them in each turn: both may have ended by the first.
        while None in [_code(role, run) for role, run in runs.items()]:
            check()
            time.sleep(SPIN_SECONDS)
        said = {role: run.communicate()[0].split() for role, run in runs.items()}
    (answers, plant), (_, controller) = (map(float, said[role]) for role in ROLES)
    if not rate:
        return {"rclpy alone, two processes: answers per wall-clock ms": answers / 1e3}
    return {
        f"rclpy alone, realtime {rate:g} Hz: answers per second": answers,
        f"rclpy alone, realtime {rate:g} Hz: plant, share of a core": plant,
        f"rclpy alone, realtime {rate:g} Hz: controller, share of a core": controller,
    }


def _code(role: str, run: "subprocess.Popen[str]") -> int | None:
    """Return 0 for a node that has ended, None for one that runs; raises RuntimeError."""
    if run.poll():
        raise RuntimeError(f"rclpy alone: the {role} ended with code {run.returncode}")
    return run.returncode


@contextmanager
def _started(
    role: str, rate: float, environment: dict[str, str]
) -> Iterator["subprocess.Popen[str]"]:
    line = [sys.executable, "-m", __name__, role, str(rate)]
    with subprocess.Popen(line, env=environment, stdout=subprocess.PIPE, text=True) as run:
        try:
            yield run
        finally:
            run.kill()


def main(role: str, rate: float) -> None:
    """Run one of the two nodes and print what it has done."""
    rclpy.init()
    node = Node(f"bare_{role}")
    executor = make_executor()
    executor.add_node(node)
    try:
        print(*(_plant(node, executor, rate) if role == "plant" else _controller(node, executor)))
    finally:
        executor.remove_node(node)
        node.destroy_node()
        leave_ros()


class _Answers:
    """Takes messages, counts them, and has each answered."""

    def __init__(self, answer: Callable[[], None]) -> None:
        """Call ``answer`` for each message."""
        self._answer = answer
        self.count = 0

    def take(self, _message: bytes) -> None:
        """Take a message."""
        self.count += 1
        self._answer()


def _plant(node: Node, executor: Executor, rate: float) -> tuple[float, float]:
    """Send samples: each as the answer to a command, or so many a second from another thread."""
    publisher = node.create_publisher(JointState, JOINT_STATES, LOSSLESS)
    sample = JointState(name=[CARRIAGE], position=[0.1], velocity=[0.0], effort=[0.0])
    send = _sender(publisher, sample)
    answers = _Answers(send if not rate else lambda: None)
    commands = node.create_subscription(Float64, VALVE_VOLTAGE, answers.take, QUEUE_DEPTH, raw=True)

    def matched() -> bool:
        return bool(publisher.get_subscription_count() and commands.get_publisher_count())

    _spin(executor, FIND_SECONDS, matched)
    if not matched():
        raise SystemExit("rclpy alone: the two nodes do not find each other")
    if not rate:
        send()
        return _measured(executor, answers)
    ended = threading.Event()
    pacer = Pacer(round(NANOSECONDS_PER_SECOND / rate))

    def pace() -> None:
        while pacer.wait(ended.is_set):
            send()

    thread = threading.Thread(target=pace, name="plant")
    thread.start()
    try:
        return _measured(executor, answers)
    finally:
        ended.set()
        thread.join()


def _controller(node: Node, executor: Executor) -> tuple[float, float]:
    """Answer each sample with a command."""
    publisher = node.create_publisher(Float64, VALVE_VOLTAGE, QUEUE_DEPTH)
    answers = _Answers(_sender(publisher, Float64(data=5.0)))
    node.create_subscription(JointState, JOINT_STATES, answers.take, QUEUE_DEPTH, raw=True)
    _spin(executor, FIND_SECONDS, lambda: answers.count > 0)
    if not answers.count:
        raise SystemExit("rclpy alone: no sample comes")
    found = _measured(executor, answers)
    # The plant began a moment later, and is to have its answers till its end.
    _spin(executor, 1.0)
    return found


def _sender(publisher: Publisher, message: object) -> Callable[[], None]:
    data = serialize_message(message)
    return lambda: publisher.publish(data)


def _spin(executor: Executor, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end and not until():
        executor.spin_until_future_complete(Future(), SPIN_SECONDS)


def _measured(executor: Executor, answers: _Answers) -> tuple[float, float]:
    """Return messages per second and the share of a core over some seconds."""
    count, used, began = answers.count, time.process_time(), time.monotonic()
    _spin(executor, MEASURED_SECONDS)
    elapsed = time.monotonic() - began
    return (answers.count - count) / elapsed, (time.process_time() - used) / elapsed


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
