"""The rodless cylinder (SMC CY3R25-200): chamber volumes, pressure rates, end stops."""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_sim.physics.air import Air


class Cylinder(NamedTuple):
    """Constants of the cylinder, SI; ``locked`` holds the carriage."""

    locked: bool
    piston_area: float
    stroke: float
    moving_mass: float
    dead_volume_a: float
    dead_volume_b: float
    end_stop_stiffness: float
    end_stop_damping: float


@kernel
def volume_a(cylinder: Cylinder, position: float) -> float:
    """Volume of chamber A in m³, eq. (27); position 0 is at A's end."""
    return cylinder.dead_volume_a + cylinder.piston_area * position


@kernel
def volume_b(cylinder: Cylinder, position: float) -> float:
    """Volume of chamber B in m³, eq. (27)."""
    return cylinder.dead_volume_b + cylinder.piston_area * (cylinder.stroke - position)


@kernel
def pressure_rate(
    air: Air, volume: float, volume_rate: float, pressure: float, mass_flow: float
) -> float:
    """dP/dt of a chamber in Pa/s, eq. (26): adiabatic, inflow and outflow at supply temperature."""
    return (
        air.isentropic_index
        / volume
        * (air.gas_constant * air.temperature * mass_flow - pressure * volume_rate)
    )


@kernel
def end_stop_force(cylinder: Cylinder, position: float, velocity: float) -> float:
    """Force in N of the end cap in contact (Kelvin-Voigt), which pushes and never pulls."""
    if position < 0.0:
        push = -cylinder.end_stop_stiffness * position - cylinder.end_stop_damping * velocity
        return max(push, 0.0)
    if position > cylinder.stroke:
        depth = position - cylinder.stroke
        push = cylinder.end_stop_stiffness * depth + cylinder.end_stop_damping * velocity
        return -max(push, 0.0)
    return 0.0
