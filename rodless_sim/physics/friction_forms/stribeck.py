# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Eq. (29) as printed: the viscous force grows with the speed throughout."""

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet, declare
from rodless_sim.physics.friction_forms.direction import Direction, Drag, dry

NAME = "stribeck"
MEANING = "eq. (29) as printed"
PARAMETERS = declare()


def of(parameters: ParameterSet) -> tuple[()]:  # noqa: ARG001
    """Return no constants: Table 2 is all there is to it."""
    return ()


@kernel
def force(constants: tuple[()], side: Direction, speed: float) -> Drag:  # noqa: ARG001
    """Friction at ``speed`` >= 0 (m/s), eq. (29)."""
    found = dry(side, speed)
    return Drag(found.force + side.viscous * speed, found.by_speed + side.viscous)
