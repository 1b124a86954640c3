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
``controller``, and prints messages per second of wall clock and its share of a core.
"""

import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import rclpy
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_base.constants import CARRIAGE, NANOSECONDS_PER_SECOND
from rodless_base.ros.process import SPIN_SECONDS, make_executor
from rodless_base.ros.topics import LOSSLESS, QUEUE_DEPTH
from rodless_base.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.domain import own_domain
from rodless_sim.node.pacing import Pacer

# How long is measured, after as long as Fast DDS takes at most to find the other (s).
MEASURED_SECONDS = 6.0
SETTLED_SECONDS = 4.0
LONGEST_SECONDS = 40.0

ROLES = ("plant", "controller")


def bench_bare(rate: float) -> dict[str, float]:
    """Return the figures at ``rate`` (Hz), or with 0 of nodes that answer each other at once."""
    with own_domain() as environment:
        runs = [
            subprocess.Popen(
                [sys.executable, "-m", __name__, role, str(rate)],
                env={**os.environ, **environment},
                stdout=subprocess.PIPE,
                text=True,
            )
            for role in ROLES
        ]
        try:
            said = [run.communicate(timeout=LONGEST_SECONDS)[0] for run in runs]
        finally:
            for run in runs:
                run.kill()
    for role, run in zip(ROLES, runs, strict=True):
        if run.returncode:
            raise RuntimeError(f"rclpy alone: the {role} ended with exit code {run.returncode}")
    (exchanges, plant), (_, controller) = (map(float, text.split()) for text in said)
    if not rate:
        return {"rclpy alone, two processes: answers per wall-clock ms": exchanges / 1e3}
    return {
        f"rclpy alone, realtime {rate:g} Hz: plant, share of a core": plant,
        f"rclpy alone, realtime {rate:g} Hz: controller, share of a core": controller,
    }


def main(role: str, rate: float) -> None:
    """Run one of the two nodes and print what it has done."""
    rclpy.init()
    node = Node(f"bare_{role}")
    count = 0

    def counted(answer: Callable[[], None]) -> Callable[[bytes], None]:
        def take(_message: bytes) -> None:
            nonlocal count
            count += 1
            answer()

        return take

    send: Callable[[], None]
    if role == "plant":
        send = _sender(node, JointState, JOINT_STATES, _sample())
        answer = send if not rate else lambda: None
        node.create_subscription(Float64, VALVE_VOLTAGE, counted(answer), QUEUE_DEPTH, raw=True)
    else:
        send = _sender(node, Float64, VALVE_VOLTAGE, Float64(data=5.0))
        node.create_subscription(JointState, JOINT_STATES, counted(send), QUEUE_DEPTH, raw=True)
    executor = make_executor()
    executor.add_node(node)

    def spin(seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            executor.spin_until_future_complete(Future(), SPIN_SECONDS)

    spin(SETTLED_SECONDS)
    if role == "plant":
        _begin(send, rate)
    while not count:
        spin(SPIN_SECONDS)
    before, used, began = count, time.process_time(), time.monotonic()
    spin(MEASURED_SECONDS)
    elapsed = time.monotonic() - began
    print((count - before) / elapsed, (time.process_time() - used) / elapsed, flush=True)
    # The other measures a moment longer, or does not: both have their answers till then.
    spin(SPIN_SECONDS)


def _sender(node: Node, kind: type, topic: str, message: object) -> Callable[[], None]:
    publisher = node.create_publisher(kind, topic, LOSSLESS if kind is JointState else QUEUE_DEPTH)
    data = serialize_message(message)
    return lambda: publisher.publish(data)


def _sample() -> JointState:
    return JointState(name=[CARRIAGE], position=[0.1], velocity=[0.0], effort=[0.0])


def _begin(send: Callable[[], None], rate: float) -> None:
    """Send the first sample, or in real time one after the other from a thread, as the plant."""
    if not rate:
        send()
        return
    pacer = Pacer(math.floor(NANOSECONDS_PER_SECOND / rate))

    def run() -> None:
        while pacer.wait(lambda: False):
            send()

    threading.Thread(target=run, daemon=True).start()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
