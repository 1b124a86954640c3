# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The forces on the carriage besides those of the air and of friction.

Each is one module with ``PARAMETERS``, its constants ``of(parameters)``, and a kernel
``force(constants, state)`` that returns a :class:`~rodless_sim.physics.force.Force`. Where a module
has ``check(parameters)``, that raises ParameterError for values that contradict each other.
"""

from collections.abc import Callable
from typing import Any

from rodless_base.kernels import total
from rodless_base.parameters import ParameterSet, collect
from rodless_base.sockets import check_kernel, modules
from rodless_sim.physics.force import NO_FORCE, Force, together
from rodless_sim.physics.state import Motion

FORCES = modules(
    "rodless_sim.physics",
    ("rail",),
)

PARAMETERS = collect(*(member.PARAMETERS for member in FORCES))

# The sum of all forces: other_forces(constants, state), constants as of() returns them.
other_forces: Callable[..., Force] = total([member.force for member in FORCES], NO_FORCE, together)


def of(parameters: ParameterSet) -> tuple[Any, ...]:
    """Return the constants of each of ``FORCES``."""
    constants = tuple(member.of(parameters) for member in FORCES)
    for member, own in zip(FORCES, constants, strict=True):
        check_kernel(member, "force", NO_FORCE, own, Motion(0.1, 0.01, 3e5, 3e5))
    return constants
