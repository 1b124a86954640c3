# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A rig whose samples go elsewhere runs well: what cannot see it says where it has looked."""

import pytest
from extent import extensive
from running import StartProcess, until_it_says

from rodless_lab.session.processes import node_command, write_parameters

pytestmark = pytest.mark.ros


@extensive
def test_samples_on_another_topic_are_not_called_a_plant_that_stands_still(
    rodless: StartProcess, start_process: StartProcess, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """`status` and `move` name the topic on which nobody publishes, and the way out."""
    folder = tmp_path_factory.mktemp("remapped")
    values = {"time.period": 0.01}
    file = write_parameters(folder / "both.yaml", {"plant": values, "controller": {}})
    to = ["-r", "joint_states:=carriage"]
    plant = [*node_command("plant", [file], "away"), *to]
    controller = [*node_command("controller", [file], "away"), *to]
    with start_process(plant, "plant") as first, start_process(controller, "controller") as second:
        until_it_says(first, "ready: ")
        until_it_says(second, "ready: ")
        with rodless("status", "--namespace", "away") as status:
            assert status.wait() == 1
        with rodless("move", "20", "--namespace", "away") as move:
            assert move.wait() == 2
    for output in (status.output, move.output):
        assert (
            "nobody publishes /away/joint_states, and the plant runs: its samples go elsewhere; "
            "start it without a remapping of joint_states" in output
        )
        assert "stands still" not in output
