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
