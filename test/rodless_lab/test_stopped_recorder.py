# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A recorder that is stopped, as by Ctrl-Z, holds no rig in real time."""

import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from extent import extensive
from running import StartProcess, StartRig, until_it_says
from sensor_msgs.msg import JointState

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer

pytestmark = pytest.mark.slow

# Long enough for Fast DDS to give up a reader that has stopped, in plant s: it takes 1 s.
WHILE = 8.0

# Over shared memory, where it holds the plant for 2 s at a time, it is more than 4 as a rule.
MOST = 2.0

TIMEOUT = 120.0


@pytest.fixture
def recorder(
    start_rig: StartRig, start_process: StartProcess, tmp_path: Path
) -> Iterator[NodeProcess]:
    """Record a rig in real time, whose nodes have a process each."""
    verb = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()", "record"]
    with (
        start_rig(controller={}),
        start_process([*verb, "-o", str(tmp_path / "bag")], "recorder") as process,
    ):
        until_it_says(process, "/joint_states", TIMEOUT)
        yield process


@extensive
def test_a_stopped_recorder_holds_no_rig_in_real_time(
    recorder: NodeProcess, observer: Observer
) -> None:
    """Plant time passes as it did before, though the recorder takes nothing."""
    samples: list[JointState] = observer.collect(JointState, "/joint_states")

    def seconds_for(plant_time: float) -> float:
        observer.more(samples, 1, TIMEOUT)
        begin = time.monotonic()
        until = stamp_nanoseconds(samples[-1].header.stamp) + round(plant_time * 1e9)
        observer.wait(
            lambda: stamp_nanoseconds(samples[-1].header.stamp) >= until, "plant time", TIMEOUT
        )
        return time.monotonic() - begin

    before = seconds_for(WHILE)
    recorder.signal(signal.SIGSTOP)
    try:
        assert seconds_for(WHILE) < MOST * before
    finally:
        recorder.signal(signal.SIGCONT)
    seconds_for(1.0)
    recorder.ask_to_stop()
    assert recorder.wait(TIMEOUT) == 0
    assert "messages lost on the way" in recorder.output
