"""From named parameters to the constants of the compiled equations."""

import math
from typing import Any

from rodless_sim.parameters import RigParameters
from rodless_sim.physics.air import Air, choked_nozzle_function
from rodless_sim.physics.cylinder import Cylinder
from rodless_sim.physics.friction import Direction, Friction
from rodless_sim.physics.motion import Plant
from rodless_sim.physics.valve import Valve


def plant_constants(parameters: RigParameters) -> Plant:
    """Return the constants of all equations for one set of parameters."""
    return Plant(
        air=_air(parameters),
        valve=_valve(parameters),
        cylinder=_cylinder(parameters),
        friction=_friction(parameters),
        supply_pressure=parameters.number("supply.pressure"),
        ambient_pressure=parameters.number("atmosphere.pressure"),
    )


def _air(parameters: RigParameters) -> Air:
    index = parameters.number("air.isentropic_index")
    return Air(
        gas_constant=parameters.number("air.gas_constant"),
        isentropic_index=index,
        critical_ratio=parameters.number("air.critical_ratio"),
        viscosity=parameters.number("air.viscosity"),
        temperature=parameters.number("supply.temperature"),
        choked_function=choked_nozzle_function(index),
    )


def _valve(parameters: RigParameters) -> Valve:
    area: Any = parameters.numbers("valve.area_coefficients")
    coefficient: Any = parameters.numbers("valve.flow_coefficients")
    return Valve(
        printed=parameters.text("valve.assembly") == "printed",
        closed_voltage=parameters.number("valve.closed_voltage"),
        curve_centre=parameters.number("valve.curve_centre"),
        area_coefficients=area,
        flow_coefficients=coefficient,
        spool_diameter=parameters.number("valve.spool_diameter"),
        sleeve_diameter=parameters.number("valve.sleeve_diameter"),
        gap_length=parameters.number("valve.gap_length"),
        gap_height=parameters.number("valve.gap_height"),
        gap_fade_voltage=parameters.number("valve.gap_fade_voltage"),
    )


def piston_area(parameters: RigParameters) -> float:
    """Area of the piston in m²: the same on both sides, there is no rod."""
    return math.pi / 4.0 * parameters.number("cylinder.bore") ** 2


def _cylinder(parameters: RigParameters) -> Cylinder:
    return Cylinder(
        locked=bool(parameters["cylinder.locked"]),
        piston_area=piston_area(parameters),
        stroke=parameters.number("cylinder.stroke"),
        moving_mass=parameters.number("cylinder.moving_mass"),
        dead_volume_a=parameters.number("cylinder.dead_volume_a"),
        dead_volume_b=parameters.number("cylinder.dead_volume_b"),
        end_stop_stiffness=parameters.number("end_stop.stiffness"),
        end_stop_damping=parameters.number("end_stop.damping"),
    )


def _friction(parameters: RigParameters) -> Friction:
    return Friction(
        saturating=parameters.text("friction.form") == "saturating",
        forward=_direction(parameters, "friction.forward"),
        reverse=_direction(parameters, "friction.reverse"),
        high_speed_viscous=parameters.number("friction.high_speed_viscous"),
        saturation_velocity=parameters.number("friction.saturation_velocity"),
        capture_velocity=parameters.number("friction.capture_velocity"),
    )


def _direction(parameters: RigParameters, prefix: str) -> Direction:
    return Direction(
        static=parameters.number(f"{prefix}.static"),
        coulomb=parameters.number(f"{prefix}.coulomb"),
        stribeck_velocity=parameters.number(f"{prefix}.stribeck_velocity"),
        viscous=parameters.number(f"{prefix}.viscous"),
    )
