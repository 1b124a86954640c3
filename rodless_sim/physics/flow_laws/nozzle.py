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
