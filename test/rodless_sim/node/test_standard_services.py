# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The standard simulation_interfaces services: there where the package is, else no trace.

What each of them does is tested without ROS too, with stand-ins for the messages.
"""

from importlib.util import find_spec

import pytest
from running import StartProcess
from sensor_msgs.msg import JointState

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.observer import Observer

NAMES = (
    "get_simulator_features",
    "get_simulation_state",
    "set_simulation_state",
    "step_simulation",
    "reset_simulation",
)


def test_services_are_offered_where_the_package_is_installed(
    start_node: StartProcess, observer: Observer
) -> None:
    """All five are there or none is, as the package is; the plant says nothing of it either way."""
    with start_node("plant") as plant:
        observer.wait(
            lambda: "/plant/reset" in dict(observer.node.get_service_names_and_types()),
            "the plant's services",
        )
        offered = {name for name, _ in observer.node.get_service_names_and_types()}
        there = {name for name in NAMES if f"/plant/{name}" in offered}
        assert there == (set(NAMES) if find_spec("simulation_interfaces") else set())
        assert "simulation_interfaces" not in plant.output


@pytest.mark.skipif(not find_spec("simulation_interfaces"), reason="it is not on PyPI")
def test_a_running_plant_is_paused_stepped_reset_and_played(
    start_node: StartProcess, observer: Observer
) -> None:
    """With the package's own messages: the samples move as each service says."""
    from simulation_interfaces import msg, srv  # noqa: PLC0415

    with start_node("plant", namespace="standard"):
        samples = observer.collect(JointState, "/standard/joint_states")
        observer.more(samples, 10)
        features = observer.call(srv.GetSimulatorFeatures, "/standard/plant/get_simulator_features")
        assert sorted(features.features.features) == [20, 24, 25, 26, 31, 32]
        paused = msg.SimulationState(state=msg.SimulationState.STATE_PAUSED)
        observer.call(srv.SetSimulationState, "/standard/plant/set_simulation_state", state=paused)
        observer.call(srv.GetSimulationState, "/standard/plant/get_simulation_state")
        held = len(samples)
        before = stamp_nanoseconds(samples[-1].header.stamp)
        observer.call(srv.StepSimulation, "/standard/plant/step_simulation", steps=5)
        observer.wait(lambda: len(samples) >= held + 5, "five steps")
        assert stamp_nanoseconds(samples[-1].header.stamp) == before + 5_000_000
        observer.call(srv.ResetSimulation, "/standard/plant/reset_simulation", scope=0)
        observer.wait(lambda: stamp_nanoseconds(samples[-1].header.stamp) == 0, "sample 0")
        assert len(samples) == held + 6
        playing = msg.SimulationState(state=msg.SimulationState.STATE_PLAYING)
        observer.call(srv.SetSimulationState, "/standard/plant/set_simulation_state", state=playing)
        observer.more(samples, 10)
