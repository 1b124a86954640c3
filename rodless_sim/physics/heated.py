"""The versions of the equations and of the integrator for :class:`HeatedMotion`.

Pressure and temperature of a chamber change with each other: one leaf of two states.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, version_for
from rodless_sim.physics import equations, faults, integrator
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.faults import NO_TEMPERATURE, NOT_FINITE
from rodless_sim.physics.heat import HeatedRate, NetInflow, Row, heated_rate
from rodless_sim.physics.integrator import GAMMA, Matrix, staged
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, HeatedMotion, Motion
from rodless_sim.physics.streams import stream_into_a, stream_into_b

# Error of a step that counts as 1, with time.tolerance 1: at 300 K as much of the temperature as
# the error of a pressure is of 0.3 MPa.
TEMPERATURE_ERROR = 2e-3  # K


class NetInflows(NamedTuple):
    """What flows into each chamber."""

    a: NetInflow
    b: NetInflow


class HeatedLeaf(NamedTuple):
    """The two rows of a chamber, solved for what position and velocity do to them."""

    pressure: Row  # the first row of d I − J and its right-hand sides
    temperature: Row
    inverse: float  # s², of the determinant
    diagonal: float  # 1/s
    by_velocity: float  # of the pressure, Pa·s/m
    temperature_by_velocity: float  # K·s/m


@version_for(HeatedMotion, equations.inflows)
def _inflows(plant: Plant, lands: Lands, state: HeatedMotion) -> NetInflows:
    return NetInflows(
        stream_into_a(plant, lands, state.pressure_a, state.temperature_a),
        stream_into_b(plant, lands, state.pressure_b, state.temperature_b),
    )


@version_for(HeatedMotion, equations.pressure_rates)
def _pressure_rates(
    plant: Plant, state: HeatedMotion, flows: NetInflows, velocity: float
) -> tuple[HeatedRate, HeatedRate]:
    air, heat, cylinder = plant.air, plant.heat, plant.cylinder
    area = cylinder.piston_area
    first = volume_a(cylinder, state.position)
    second = volume_b(cylinder, state.position)
    return (
        heated_rate(
            air, heat, first, area, velocity, state.pressure_a, state.temperature_a, flows.a
        ),
        heated_rate(
            air, heat, second, -area, velocity, state.pressure_b, state.temperature_b, flows.b
        ),
    )


@version_for(HeatedRate, equations.motion_rate)
def _motion_rate(
    velocity: float, acceleration: float, a: HeatedRate, b: HeatedRate
) -> HeatedMotion:
    return HeatedMotion(
        velocity,
        acceleration,
        a.pressure.rate,
        b.pressure.rate,
        a.temperature.rate,
        b.temperature.rate,
    )


@kernel
def both_rows(leaf: HeatedLeaf, pressure: float, temperature: float) -> tuple[float, float]:
    """Solve the two rows of a chamber for their right-hand sides."""
    first, second = leaf.pressure, leaf.temperature
    own_pressure = leaf.diagonal - first.by_pressure
    own_temperature = leaf.diagonal - second.by_temperature
    return (
        (own_temperature * pressure + first.by_temperature * temperature) * leaf.inverse,
        (second.by_pressure * pressure + own_pressure * temperature) * leaf.inverse,
    )


@version_for(HeatedRate, integrator.leaf)
def _leaf(rate: HeatedRate, diagonal: float) -> HeatedLeaf:
    first, second = rate.pressure, rate.temperature
    own_pressure, own_temperature = diagonal - first.by_pressure, diagonal - second.by_temperature
    inverse = 1.0 / (own_pressure * own_temperature - first.by_temperature * second.by_pressure)
    found = HeatedLeaf(first, second, inverse, diagonal, 0.0, 0.0)
    of_pressure, of_temperature = both_rows(
        found,
        first.by_position / diagonal + first.by_velocity,
        second.by_position / diagonal + second.by_velocity,
    )
    return HeatedLeaf(first, second, inverse, diagonal, of_pressure, of_temperature)


@version_for(HeatedMotion, integrator.solved)
def _solved(matrix: Matrix, right: HeatedMotion) -> HeatedMotion:
    a, b = matrix.a, matrix.b
    shift = right.position * matrix.inverse
    rest_a, rest_of_temperature_a = both_rows(
        a,
        right.pressure_a + a.pressure.by_position * shift,
        right.temperature_a + a.temperature.by_position * shift,
    )
    rest_b, rest_of_temperature_b = both_rows(
        b,
        right.pressure_b + b.pressure.by_position * shift,
        right.temperature_b + b.temperature.by_position * shift,
    )
    push = matrix.by_pressure * (rest_a - rest_b) + matrix.by_position * shift
    velocity = (right.velocity + push) * matrix.pivot
    return HeatedMotion(
        shift + velocity * matrix.inverse,
        velocity,
        rest_a + a.by_velocity * velocity,
        rest_b + b.by_velocity * velocity,
        rest_of_temperature_a + a.temperature_by_velocity * velocity,
        rest_of_temperature_b + b.temperature_by_velocity * velocity,
    )


@version_for(HeatedMotion, integrator.error_size)
def _error_size(error: HeatedMotion) -> float:
    warm = max(abs(error.temperature_a), abs(error.temperature_b)) / TEMPERATURE_ERROR
    total = error.temperature_a + error.temperature_b
    others = Motion(error.position, error.velocity, error.pressure_a, error.pressure_b)
    return max(integrator.error_size(others), warm) + 0.0 * total


@version_for(HeatedMotion, integrator.sticking_step)
def _sticking_step(
    plant: Plant, lands: Lands, state: HeatedMotion, a: HeatedRate, b: HeatedRate, step: float
) -> tuple[AnyMotion, float]:
    diagonal = 1.0 / (GAMMA * step)
    # A pivot of nothing: whatever pushes, the carriage stays.
    matrix = Matrix(0.0, 0.0, 0.0, 0.0, integrator.leaf(a, diagonal), integrator.leaf(b, diagonal))
    return staged(plant, lands, state, 0, matrix, equations.motion_rate(0.0, 0.0, a, b), step)


@version_for(HeatedMotion, faults.fault_of)
def _fault_of(plant: Plant, state: HeatedMotion) -> int:
    if not math.isfinite(state.temperature_a + state.temperature_b):
        return NOT_FINITE
    if state.temperature_a <= 0.0 or state.temperature_b <= 0.0:
        return NO_TEMPERATURE
    others = Motion(state.position, state.velocity, state.pressure_a, state.pressure_b)
    return faults.fault_of(plant, others)
