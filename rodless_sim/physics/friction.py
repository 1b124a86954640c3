"""Seal and guide friction: Stribeck curve, eqs. (28)-(29), one set of values per direction."""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel


class Direction(NamedTuple):
    """Magnitudes for one direction of motion: N, N, m/s, N·s/m."""

    static: float
    coulomb: float
    stribeck_velocity: float
    viscous: float


class Friction(NamedTuple):
    """Friction constants, SI; ``saturating`` bends the viscous term at creep speed."""

    saturating: bool
    forward: Direction
    reverse: Direction
    high_speed_viscous: float
    saturation_velocity: float
    capture_velocity: float


@kernel
def static_limit(friction: Friction, net_force: float) -> float:
    """Breakaway force F_s in N against motion in the direction of ``net_force``, eq. (28)."""
    return friction.forward.static if net_force >= 0.0 else friction.reverse.static


@kernel
def viscous_force(friction: Friction, side: Direction, speed: float) -> float:
    """Viscous part F_v in N at ``speed`` >= 0: B v, or B falling to its high-speed value."""
    if not friction.saturating:
        return side.viscous * speed
    knee = friction.saturation_velocity
    bend = knee * (1.0 - math.exp(-speed / knee))
    return friction.high_speed_viscous * speed + (side.viscous - friction.high_speed_viscous) * bend


@kernel
def sliding_friction(friction: Friction, velocity: float, direction: int) -> float:
    """Friction force in N on a sliding carriage, eq. (29), signed like ``direction`` (+1 or -1)."""
    side = friction.forward if direction > 0 else friction.reverse
    speed = velocity * direction
    drop = (side.static - side.coulomb) * math.exp(-((speed / side.stribeck_velocity) ** 2))
    return direction * (side.coulomb + drop + viscous_force(friction, side, speed))
