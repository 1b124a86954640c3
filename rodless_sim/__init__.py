# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant: a pneumatic servo rig's physics, free of ROS, and one ROS node around it."""

from rodless_base.parameters import ParameterError
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.faults import SimulationError
from rodless_sim.physics.state import HeatedState, State
from rodless_sim.rig import Rig, simulate
from rodless_sim.scenario import Scenario, ScenarioError
from rodless_sim.trace import Trace

__all__ = [
    "HeatedState",
    "ParameterError",
    "Rig",
    "RigParameters",
    "Scenario",
    "ScenarioError",
    "SimulationError",
    "State",
    "Trace",
    "simulate",
]


def __dir__() -> list[str]:
    return __all__
