"""The end caps: stiff, damped contacts at both ends of the stroke."""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT
from rodless_sim.physics.state import Motion

PARAMETERS = declare(
    Parameter(
        "end_stop.stiffness", 2e5, "N/m", "contact stiffness of the end caps", JUDGEMENT, 1e3, 1e7
    ),
    Parameter(
        "end_stop.damping", 300.0, "N·s/m", "contact damping of the end caps", JUDGEMENT, 0.0, 1e5
    ),
)


class EndStop(NamedTuple):
    """Constants of both end caps."""

    stiffness: float  # N/m
    damping: float  # N·s/m
    stroke: float  # m


def of(parameters: ParameterSet) -> EndStop:
    """Return the constants for ``parameters``."""
    return EndStop(
        stiffness=parameters.number("end_stop.stiffness"),
        damping=parameters.number("end_stop.damping"),
        stroke=parameters.number("cylinder.stroke"),
    )


@kernel
def force(end_stop: EndStop, state: Motion) -> float:
    """Force in N of the end cap in contact (Kelvin-Voigt), which pushes and never pulls."""
    if state.position < 0.0:
        push = -end_stop.stiffness * state.position - end_stop.damping * state.velocity
        return max(push, 0.0)
    if state.position > end_stop.stroke:
        depth = state.position - end_stop.stroke
        push = end_stop.stiffness * depth + end_stop.damping * state.velocity
        return -max(push, 0.0)
    return 0.0
