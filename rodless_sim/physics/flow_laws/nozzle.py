# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The ideal nozzle of eq. (6): isentropic to the throat, nothing recovered behind it."""

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet, declare
from rodless_sim.physics import flow
from rodless_sim.physics.air import Air

NAME = "nozzle"
MEANING = "the ideal nozzle of eq. (6)"
PARAMETERS = declare()


def of(parameters: ParameterSet) -> tuple[()]:  # noqa: ARG001
    """Return no constants: those of the air are all there is to it."""
    return ()


@kernel
def function(constants: tuple[()], air: Air, ratio: float) -> tuple[float, float]:  # noqa: ARG001
    """Dimensionless flow ψ at ``ratio``, and dψ/dr."""
    return flow.nozzle(air, ratio)
