# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig as other people's solvers want it: numba functions of arrays, for one rig each.

The rig's constants are compiled in. What changes with each sample is in ``held``,
shape (6,): whether A's supply opens, area and gap of the opening edge and of the closing one, and
the direction of sliding (+1, -1, 0 for a carriage at rest).
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt

from rodless_sim.physics.equations import (
    breakaway_limits,
    inflows,
    net_force,
    pressure_rates,
    sliding_direction,
    sliding_rates,
)
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

Array = npt.NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., object])

STATES = len(Motion._fields)
HELD = 6
DIRECTION = 5


class RightHandSide(NamedTuple):
    """Compiled functions of one rig; each array is filled, not returned."""

    rates: Callable[[float, Array, Array, Array], None]  # t, y, dy/dt to fill, held
    jacobian: Callable[[float, Array, Array, Array], None]  # t, y, J to fill, shape (4, 4), held
    event: Callable[[float, Array, Array], float]  # t, y, held: falls below 0 where motion changes
    hold: Callable[[Array, float, Array], None]  # y, voltage, held to fill: a period begins
    changed: Callable[[Array, Array], None]  # y, held: the event has come


def compiled(function: Function) -> Function:
    """Compile a function that has constants in its closure; nothing is kept between processes."""
    return cast(Function, numba.njit(error_model="numpy")(function))


@cache
def right_hand_side(plant: Plant) -> RightHandSide:
    """Compile the functions for one rig."""

    @compiled
    def lands_of(held: Array) -> Lands:
        return Lands(held[0] > 0.0, Edge(held[1], held[2]), Edge(held[3], held[4]))

    @compiled
    def motion_of(y: Array) -> Motion:
        return Motion(y[0], y[1], y[2], y[3])

    @compiled
    def rates(_time: float, y: Array, change: Array, held: Array) -> None:
        state, lands = motion_of(y), lands_of(held)
        flows = inflows(plant, lands, state)
        if held[DIRECTION] == 0.0:
            a, b = pressure_rates(plant, state, flows, 0.0)
            change[0], change[1], change[2], change[3] = 0.0, 0.0, a.rate, b.rate
        else:
            found = sliding_rates(plant, state, flows, int(held[DIRECTION]))
            change[0], change[1] = found.velocity, found.acceleration
            change[2], change[3] = found.a.rate, found.b.rate

    @compiled
    def jacobian(_time: float, y: Array, found: Array, held: Array) -> None:
        state, lands = motion_of(y), lands_of(held)
        flows = inflows(plant, lands, state)
        found[:] = 0.0
        if held[DIRECTION] == 0.0:
            a, b = pressure_rates(plant, state, flows, 0.0)
        else:
            by = sliding_rates(plant, state, flows, int(held[DIRECTION]))
            a, b = by.a, by.b
            found[0, 1] = 1.0
            found[1, 0], found[1, 1] = by.by_position, by.by_velocity
            found[1, 2], found[1, 3] = by.by_pressure, -by.by_pressure
            found[2, 1], found[3, 1] = a.by_velocity, b.by_velocity
        found[2, 0], found[3, 0] = a.by_position, b.by_position
        found[2, 2], found[3, 3] = a.by_pressure, b.by_pressure

    @compiled
    def event(_time: float, y: Array, held: Array) -> float:
        if held[DIRECTION] != 0.0:
            return float(held[DIRECTION] * y[1])
        force = net_force(plant, motion_of(y))
        low, high = breakaway_limits(plant, y[0])
        return min(force - low, high - force)

    @compiled
    def hold(y: Array, voltage: float, held: Array) -> None:
        lands = openings(plant, voltage)
        held[0] = 1.0 if lands.forward else 0.0
        held[1], held[2] = lands.opening.orifice_area, lands.opening.gap
        held[3], held[4] = lands.closing.orifice_area, lands.closing.gap
        held[DIRECTION] = sliding_direction(plant, motion_of(y))
        if held[DIRECTION] == 0.0:
            y[1] = 0.0

    @compiled
    def changed(y: Array, held: Array) -> None:
        if held[DIRECTION] == 0.0:
            held[DIRECTION] = 1.0 if net_force(plant, motion_of(y)) > 0.0 else -1.0
        else:
            y[1] = 0.0
            held[DIRECTION] = sliding_direction(plant, motion_of(y))

    # What a run seldom calls is compiled now.
    changed(np.array([0.0, 0.0, 1e5, 1e5]), np.zeros(HELD))
    return RightHandSide(rates, jacobian, event, hold, changed)
