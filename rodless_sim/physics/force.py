"""A force on the carriage, and how it changes with the motion."""

from typing import NamedTuple

from rodless_base.kernels import kernel


class Force(NamedTuple):
    """A force, positive toward chamber B's end, with its derivatives."""

    force: float  # N
    by_position: float  # N/m
    by_velocity: float  # N·s/m


NO_FORCE = Force(0.0, 0.0, 0.0)


@kernel
def together(one: Force, other: Force) -> Force:
    """The sum of two forces."""
    return Force(
        one.force + other.force,
        one.by_position + other.by_position,
        one.by_velocity + other.by_velocity,
    )
