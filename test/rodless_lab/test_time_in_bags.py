# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags of the running plant say when its valve held what, whatever clock dates their messages."""

from pathlib import Path

import numpy as np
import pytest
from busy import busy_cores
from extent import some_of

from rodless_lab.bags.reader import read_bag
from rodless_lab.runs.from_bag import read_commands, read_run
from rodless_lab.runs.resimulate import replay
from rodless_lab.session.session import RigSession
from rodless_sim import RigParameters

pytestmark = [pytest.mark.ros, pytest.mark.slow]

TIMEOUT = 180.0


@pytest.mark.parametrize("clock", some_of([False, True], 2))
def test_a_bag_of_a_loaded_machine_at_half_speed_replays(tmp_path: Path, clock: bool) -> None:
    """In wall time (without /clock) and in plant time, commands early, late or left out.

    Every sample has its valve state, from sample 0 on, in the same stamp.
    """
    with (
        RigSession(
            "realtime",
            duration=1.5,
            # Fewer samples than a queue holds: however crowded the machine is, none is lost.
            plant={"time.period": 2e-3, "time.speed": 0.5, "time.publish_clock": clock},
            controller={"reference.type": "step", "reference.at": 0.1},
            timeout=TIMEOUT,
            bag=tmp_path / "bag",
        ) as rig,
        busy_cores(TIMEOUT),
    ):
        rig.run()
    bag = read_bag(tmp_path / "bag")
    joint, valve = bag["/joint_states"], bag["/valve/state"]
    assert np.allclose(joint.time, joint.stamp, atol=1e-9) == clock
    np.testing.assert_array_equal(valve.stamp, joint.stamp)
    recorded = read_run(bag.path)
    assert recorded.doubt == ""
    assert np.ptp(recorded.position) > 0.05
    replayed = replay(RigParameters.preset("paper"), recorded)
    assert np.abs(replayed.position - recorded.position).max() < 5e-5
    commands = read_commands(bag.path)
    assert len(commands.time) == len(bag["/valve/voltage"])
    held = commands.held_from[np.isfinite(commands.held_from)]
    assert len(held) > 100
    assert np.all(held >= commands.time[np.isfinite(commands.held_from)] - 1e-9)
