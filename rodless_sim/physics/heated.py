# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The versions of the equations and of the integrator for :class:`HeatedMotion`.

Pressure and temperature of a chamber change with each other: one leaf of two states. With a leak
past the piston those of both chambers do.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel, outlined_kernel, version_for
from rodless_sim.physics import equations, faults, integrator
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.faults import NO_TEMPERATURE, NOT_FINITE
from rodless_sim.physics.heat import HeatedRate, NetInflow, Row, heated_rate
from rodless_sim.physics.integrator import GAMMA, Matrix, staged
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion, FullMotion, HeatedMotion, Motion
from rodless_sim.physics.streams import (
    leak_across,
    leak_out,
    less_at_1,
    stream_into_a,
    stream_into_b,
    turned,
)

# Error of a step that counts as 1, with time.tolerance 1: at 300 K as much of the temperature as
# the error of a pressure is of 0.3 MPa.
TEMPERATURE_ERROR = 2e-3  # K


class NetInflows(NamedTuple):
    """What flows into each chamber."""

    a: NetInflow
    b: NetInflow


class Square(NamedTuple):
    """Two by two: what pressure and temperature make of a pressure and a temperature."""

    pp: float
    pt: float  # of the pressure, by the temperature
    tp: float
    tt: float


class HeatedLeaf(NamedTuple):
    """The two rows of a chamber, solved for what position and velocity do to them."""

    pressure: Row
    temperature: Row
    inverse: Square  # of the rows' own part of d I − J, s
    by_velocity: float  # of the pressure, Pa·s/m
    temperature_by_velocity: float  # K·s/m


class HeatedExchange(NamedTuple):
    """What the chambers' rows, each solved by itself, leave of each other: a leak between them."""

    leaking: bool
    of_a: Square  # how A follows B
    of_b: Square


@version_for(HeatedMotion, equations.inflows)
def _inflows(plant: Plant, lands: Lands, state: HeatedMotion) -> NetInflows:
    supply = plant.supply_pressure
    a = stream_into_a(plant, supply, lands, state.pressure_a, state.temperature_a)
    b = stream_into_b(plant, supply, lands, state.pressure_b, state.temperature_b)
    if plant.leak.open:
        return less_leaks(plant, state, NetInflows(a, b))
    return NetInflows(a, b)


@outlined_kernel
def less_leaks(plant: Plant, state: HeatedMotion | FullMotion, flows: NetInflows) -> NetInflows:
    """``flows`` into both chambers less what leaks out of them."""
    leak, across = plant.leak, leak_across(plant, state)
    a = leak_out(plant, leak.a, state.pressure_a, state.temperature_a)
    b = leak_out(plant, leak.b, state.pressure_b, state.temperature_b)
    return NetInflows(less_at_1(flows.a, a, across), less_at_1(flows.b, b, turned(across)))


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
def times(square: Square, pressure: float, temperature: float) -> tuple[float, float]:
    """Apply ``square`` to a pressure and a temperature."""
    return (
        square.pp * pressure + square.pt * temperature,
        square.tp * pressure + square.tt * temperature,
    )


@kernel
def product(one: Square, other: Square) -> Square:
    """Return what ``other`` and then ``one`` make."""
    pp, tp = times(one, other.pp, other.tp)
    pt, tt = times(one, other.pt, other.tt)
    return Square(pp, pt, tp, tt)


@kernel
def inverse_of(square: Square) -> Square:
    """Return what undoes ``square``."""
    scale = 1.0 / (square.pp * square.tt - square.pt * square.tp)
    return Square(square.tt * scale, -square.pt * scale, -square.tp * scale, square.pp * scale)


@kernel
def exchanged(
    exchange: HeatedExchange, a: tuple[float, float], b: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Solve x_a = a + of_a x_b and x_b = b + of_b x_a for pressure and temperature of each."""
    if not exchange.leaking:
        return a, b
    both = product(exchange.of_a, exchange.of_b)
    undone = inverse_of(Square(1.0 - both.pp, -both.pt, -both.tp, 1.0 - both.tt))
    from_b = times(exchange.of_a, b[0], b[1])
    found = times(undone, a[0] + from_b[0], a[1] + from_b[1])
    from_a = times(exchange.of_b, found[0], found[1])
    return found, (b[0] + from_a[0], b[1] + from_a[1])


@kernel
def own_inverse(rate: HeatedRate, diagonal: float) -> Square:
    """Invert a chamber's own part of d I − J."""
    first, second = rate.pressure, rate.temperature
    return inverse_of(
        Square(
            diagonal - first.by_pressure,
            -first.by_temperature,
            -second.by_pressure,
            diagonal - second.by_temperature,
        )
    )


@kernel
def by_other(rate: HeatedRate) -> Square:
    """How a chamber's rates change with the other chamber."""
    first, second = rate.pressure, rate.temperature
    return Square(
        first.by_other_pressure,
        first.by_other_temperature,
        second.by_other_pressure,
        second.by_other_temperature,
    )


@kernel
def by_carriage(rate: HeatedRate, inverse: Square, diagonal: float) -> tuple[float, float]:
    """What a unit of velocity makes of a chamber by itself."""
    first, second = rate.pressure, rate.temperature
    return times(
        inverse,
        first.by_position / diagonal + first.by_velocity,
        second.by_position / diagonal + second.by_velocity,
    )


@version_for(HeatedRate, integrator.eliminated_chambers)
def _eliminated_chambers(
    first: HeatedRate, second: HeatedRate, diagonal: float
) -> tuple[HeatedLeaf, HeatedLeaf, HeatedExchange]:
    one, other = own_inverse(first, diagonal), own_inverse(second, diagonal)
    coupling_a, coupling_b = by_other(first), by_other(second)
    leaking = coupling_a.pp != 0.0 or coupling_b.pp != 0.0
    exchange = HeatedExchange(leaking, product(one, coupling_a), product(other, coupling_b))
    a, b = exchanged(
        exchange, by_carriage(first, one, diagonal), by_carriage(second, other, diagonal)
    )
    return (
        HeatedLeaf(first.pressure, first.temperature, one, a[0], a[1]),
        HeatedLeaf(second.pressure, second.temperature, other, b[0], b[1]),
        exchange,
    )


@version_for(HeatedMotion, integrator.solved)
def _solved(matrix: Matrix, right: HeatedMotion) -> HeatedMotion:
    a, b = matrix.a, matrix.b
    shift = right.position * matrix.inverse
    (rest_a, rest_of_temperature_a), (rest_b, rest_of_temperature_b) = exchanged(
        matrix.exchange,
        times(
            a.inverse,
            right.pressure_a + a.pressure.by_position * shift,
            right.temperature_a + a.temperature.by_position * shift,
        ),
        times(
            b.inverse,
            right.pressure_b + b.pressure.by_position * shift,
            right.temperature_b + b.temperature.by_position * shift,
        ),
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
    chambers = integrator.eliminated_chambers(a, b, diagonal)
    matrix = Matrix(0.0, 0.0, 0.0, 0.0, chambers[0], chambers[1], chambers[2])
    return staged(plant, lands, state, 0, matrix, equations.motion_rate(0.0, 0.0, a, b), step)


@version_for(HeatedMotion, faults.fault_of)
def _fault_of(plant: Plant, state: HeatedMotion) -> int:
    if not math.isfinite(state.temperature_a + state.temperature_b):
        return NOT_FINITE
    if state.temperature_a <= 0.0 or state.temperature_b <= 0.0:
        return NO_TEMPERATURE
    others = Motion(state.position, state.velocity, state.pressure_a, state.pressure_b)
    return faults.fault_of(plant, others)
