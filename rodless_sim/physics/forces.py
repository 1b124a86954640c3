"""The forces on the carriage besides those of the air and of friction.

Each is one module with ``PARAMETERS``, its constants ``of(parameters)``, and a kernel
``force(constants, state)`` in N, positive toward chamber B's end. Where a module has
``check(parameters)``, that raises ParameterError for values that contradict each other.
"""

from typing import Any

from rodless_base.kernels import total
from rodless_base.parameters import ParameterSet, collect
from rodless_base.sockets import modules

FORCES = modules(
    "rodless_sim.physics",
    ("end_stop",),
)

PARAMETERS = collect(*(member.PARAMETERS for member in FORCES))

# The sum of all forces in N: other_forces(constants, state), constants as of() returns them.
other_forces = total([member.force for member in FORCES])


def of(parameters: ParameterSet) -> tuple[Any, ...]:
    """Return the constants of each of ``FORCES``."""
    return tuple(member.of(parameters) for member in FORCES)
