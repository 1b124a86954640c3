# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig whose frames and joint have a prefix: published, controlled, moved, read from a bag."""

from pathlib import Path

import pytest
from running import StartProcess, StartRig
from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.topics import PRESSURES
from rodless_lab import read_bag, read_run
from rodless_lab.harness import RigSession
from rodless_lab.session.observer import Observer

PREFIX = {"frame_prefix": "left/"}


def test_frames_and_joint_have_the_prefix(
    start_rig: StartRig, observer: Observer, rodless: StartProcess
) -> None:
    """Every frame_id and the joint's name begin with it, and `rodless move` finds the carriage."""
    plant = {**PREFIX, "time.period": 0.005}
    with start_rig(preset="calibrated", plant=plant, controller=PREFIX):
        samples = observer.collect(JointState, "/joint_states")
        assert list(observer.more(samples, 1)[-1].name) == ["left/carriage"]
        for topic in PRESSURES.values():
            messages = observer.collect(FluidPressure, f"/{topic}")
            expected = "left/" + topic.partition("/")[0]
            assert observer.more(messages, 1)[-1].header.frame_id == expected
        with rodless("move", "20") as move:
            assert move.wait(60.0) == 0, move.output


@pytest.mark.ros
def test_its_bags_are_read_like_any_other(tmp_path: Path) -> None:
    """A session hears the carriage, and the run of its bag is the session's."""
    with RigSession(
        "lockstep", plant=PREFIX, controller=PREFIX, duration=0.5, bag=tmp_path / "bag"
    ) as rig:
        rig.setpoint(0.01)
        positions = rig.run().position
    recorded = read_bag(tmp_path / "bag")["/joint_states"]
    assert list(recorded.messages[0].name) == ["left/carriage"]
    run = read_run(tmp_path / "bag")
    assert run.position.max() == positions.max() > 1e-4
