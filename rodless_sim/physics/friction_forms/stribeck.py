"""Eq. (29) as printed: the viscous force grows with the speed throughout."""

from rodless_base.kernels import kernel
from rodless_base.parameters import ParameterSet, declare
from rodless_sim.physics.friction_forms.direction import Direction, dry_force

NAME = "stribeck"
MEANING = "eq. (29) as printed"
PARAMETERS = declare()


def of(parameters: ParameterSet) -> tuple[()]:  # noqa: ARG001
    """Return no constants: Table 2 is all there is to it."""
    return ()


@kernel
def force(constants: tuple[()], side: Direction, speed: float) -> float:  # noqa: ARG001
    """Magnitude in N of the friction at ``speed`` >= 0 (m/s), eq. (29)."""
    return dry_force(side, speed) + side.viscous * speed
