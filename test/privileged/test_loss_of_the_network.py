# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A network that is cut and healed: plant and controller in a network namespace each.

Needs root: `make reliability` runs it, CI does not.
"""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from running import StartProcess, until_it_says

from rodless_base.ros.profiles import PROFILE_VARIABLES
from rodless_base.ros.shared_memory import RANGE
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.processes import node_command

# For what must happen, on a crowded machine, in wall-clock s.
TIMEOUT = 120.0

# Prints what the nodes say when it changes, a gap in plant time, and once a second what the valve
# held since then.
WATCHER = """
import time
from rodless_base.ros.topics import LOSSLESS, stamp_nanoseconds
from rodless_lab.session.observer import Observer
from sensor_msgs.msg import JointState
said, held, last = {}, [], None
def take(message):
    global last
    stamp = stamp_nanoseconds(message.header.stamp)
    if last is not None and stamp not in (last, last + 2_000_000):
        print("gap", last, stamp, flush=True)
    last = stamp
with Observer() as observer:
    observer.node.create_subscription(JointState, "/joint_states", take, LOSSLESS)
    observer.subscribe(JointState, "/valve/state", lambda m: held.append(m.effort[0]))
    reports, due = observer.diagnostics, time.monotonic()
    while True:
        observer.spin()
        for name, report in list(reports.items()):
            if said.get(name) != report.message:
                said[name] = report.message
                print(f"{name}: {report.message}", flush=True)
        if time.monotonic() > due:
            due = time.monotonic() + 1.0
            if held:
                print("held closed" if set(held) == {5.08} else "held open", flush=True)
            held.clear()
"""

Link = Callable[[bool], None]


def ip(*arguments: str) -> None:
    """Call ``ip``; raises where it fails."""
    subprocess.run(["ip", *arguments], check=True, timeout=TIMEOUT)


@pytest.fixture
def link() -> Iterator[Link]:
    """Make two namespaces, ``rodless_a`` and ``rodless_b``, and the cable between them."""
    assert shutil.which("ip"), "iproute2 is missing"
    with ExitStack() as stack:
        for side in "ab":
            ip("netns", "add", f"rodless_{side}")
            stack.callback(ip, "netns", "del", f"rodless_{side}")
        ip("link", "add", "rodless_a", "type", "veth", "peer", "name", "rodless_b")
        for side, address in (("a", "10.77.0.1/24"), ("b", "10.77.0.2/24")):
            name = f"rodless_{side}"
            ip("link", "set", name, "netns", name)
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "addr", "add", address, "dev", name)
            ip("-n", name, "link", "set", name, "up")
        yield lambda up: ip("-n", "rodless_a", "link", "set", "rodless_a", "up" if up else "down")


@pytest.fixture
def inside(start_process: StartProcess) -> Callable[..., object]:
    """Return a context manager that runs a command in a namespace, with ROS's own settings."""
    settings = {RANGE: "SUBNET", **dict.fromkeys(PROFILE_VARIABLES.values(), "")}

    def running(side: str, command: list[str], name: str) -> object:
        everything = ["ip", "netns", "exec", f"rodless_{side}", *command]
        return start_process(everything, name, environment=settings)

    return running


def then_says(process: NodeProcess, text: str, before: int) -> None:
    """Wait until the output of a process holds ``text`` more often than ``before``."""
    deadline = time.monotonic() + TIMEOUT
    while process.output.count(text) <= before:
        assert time.monotonic() < deadline, f"no further {text!r} in:\n{process.output}"
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("mode", "plant_says", "controller_says"),
    [
        ("realtime", "no valid command: valve closed", "no position: valve closed"),
        ("lockstep", "no command for 2 s of wall time from /controller: holding", "no position"),
    ],
)
def test_a_cut_network_stops_the_rig_safely_and_healed_it_goes_on(
    link: Link, inside: Callable[..., object], mode: str, plant_says: str, controller_says: str
) -> None:
    """In real time the valve closes, in lock-step time stands; both sides blame the other.

    Healed, the run goes on where it is; in lock-step no sample is missing.
    """
    options = [
        *("-p", f"time.mode:={mode}", "-p", "time.period:=0.002"),
        *("-p", "time.command_timeout:=2.0"),
    ]
    controller = ["-p", "reference.type:=sine", "-p", f"use_sim_time:={mode == 'realtime'}"]
    watcher = [sys.executable, "-c", WATCHER]
    with (
        inside("a", node_command("plant") + options, "plant"),
        inside("b", node_command("controller") + controller, "controller"),
        inside("a", watcher, "watcher_a") as at_the_plant,
        inside("b", watcher, "watcher_b") as at_the_controller,
    ):
        for watch in (at_the_plant, at_the_controller):
            until_it_says(watch, "/controller: controlling", TIMEOUT)
        until_it_says(at_the_plant, "held open", TIMEOUT)
        blamed = at_the_plant.output.count(f"/plant: {plant_says}")
        missed = at_the_controller.output.count(f"/controller: {controller_says}")
        closed = at_the_plant.output.count("held closed")
        link(False)
        then_says(at_the_plant, f"/plant: {plant_says}", blamed)
        then_says(at_the_controller, f"/controller: {controller_says}", missed)
        if mode == "realtime":
            then_says(at_the_plant, "held closed", closed)
        opened = at_the_plant.output.count("held open")
        link(True)
        then_says(at_the_plant, "held open", opened)
        then_says(at_the_plant, "held open", opened + 1)
        if mode == "lockstep":
            assert "gap" not in at_the_plant.output
