# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What ends a step of a :class:`FullMotion`: an instant at which its equations change.

Each event has a margin: a number that falls through zero there. :func:`margins` has all of them,
:func:`changed` is what happens to the state then. An option with events of its own adds both.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_sim.physics.bristles import Bristles
from rodless_sim.physics.coupling import Coupling
from rodless_sim.physics.end_stop import rebound
from rodless_sim.physics.full_numbers import (
    COMPRESSOR,
    COUPLED,
    PISTON_POSITION,
    PISTON_VELOCITY,
    POSITION,
    RECEIVER_PRESSURE,
    SUPPLY_PRESSURE,
    VELOCITY,
    numbers_of,
    restored,
)
from rodless_sim.physics.full_rates import Body, Modes, bodies
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import FullMotion

Array = npt.NDArray[np.float64]

# How far past the limit a push breaks a body away: at the limit itself rounding would decide.
PAST = 1e-6  # N

# What counts as much as 1 N in a margin.
NEWTON_SPEED = 1e-3  # m/s
NEWTON_GAP = 1e-3  # m
NEWTON_PRESSURE = 2e3  # Pa

# So small a margin is the event itself.
NEAR = 1e-9
CLEAR = 1e-8


class Limits(NamedTuple):
    """The least and the greatest push in N that a body at rest withstands."""

    low: float
    high: float


class Margins(NamedTuple):
    """What falls through zero at an event, in units of about the same weight."""

    carriage: float  # it stops, or breaks away
    piston: float
    carriage_cap: float  # it strikes an end cap
    piston_cap: float
    coupling: float  # the magnets part, or catch
    compressor: float  # it switches on or off


@kernel
def at_cap(plant: Plant, body: Body) -> bool:
    """Whether a body is at an end of the stroke."""
    return body.position <= 0.0 or body.position >= plant.cylinder.stroke


@kernel
def limits(plant: Plant, body: Body, locked: bool) -> Limits:
    """Return what a body at rest withstands; an end cap withstands any push into it."""
    share = 0.0 if plant.full.bristles.acting else body.share
    low = -share * body.friction.reverse.static - PAST
    high = share * body.friction.forward.static + PAST
    if locked or body.position <= 0.0:
        low = -math.inf
    if locked or body.position >= plant.cylinder.stroke:
        high = math.inf
    return Limits(low, high)


@kernel
def push_at_rest(plant: Plant, body: Body) -> float:
    """Push in N on a body at rest, less what its bristles hold."""
    bristles: Bristles = plant.full.bristles
    if bristles.acting:
        return body.push - body.share * bristles.stiffness * body.bristle_deflection
    return body.push


@kernel
def mode_of(plant: Plant, body: Body, locked: bool) -> int:
    """Return how a body moves, eq. (28) for friction without bristles."""
    if locked:
        return 0
    speed, bristles = abs(body.velocity), plant.full.bristles.acting
    captured = speed == 0.0 if bristles else speed <= plant.friction.capture_velocity
    if captured and (not bristles or at_cap(plant, body)):
        low, high = limits(plant, body, locked)
        push = push_at_rest(plant, body)
        if low + CLEAR <= push <= high - CLEAR:
            return 0
        if speed == 0.0 and not bristles:
            return 1 if push > high - CLEAR else -1
    if bristles:
        return 1
    return 1 if body.velocity > 0.0 else -1


@kernel
def modes_of(plant: Plant, state: FullMotion) -> Modes:
    """Return how both bodies move."""
    carriage, piston = bodies(plant, state)
    if plant.full.coupling.magnetic:
        return Modes(mode_of(plant, carriage, plant.cylinder.locked), mode_of(plant, piston, False))
    return Modes(mode_of(plant, carriage, plant.cylinder.locked), 0)


@kernel
def motion_margin(plant: Plant, body: Body, mode: int, locked: bool) -> float:
    """Return the margin of a body: until it breaks away, or until it stops."""
    if mode == 0:
        low, high = limits(plant, body, locked)
        push = push_at_rest(plant, body)
        return min(push - low, high - push)
    if plant.full.bristles.acting:
        return math.inf
    return mode * body.velocity / NEWTON_SPEED


@kernel
def cap_margin(plant: Plant, body: Body, mode: int) -> float:
    """Return the margin of a body that moves until it strikes a cap."""
    if mode == 0:
        return math.inf
    ahead, behind = plant.cylinder.stroke - body.position, body.position
    if not plant.full.bristles.acting:
        return (ahead if mode > 0 else behind) / NEWTON_GAP
    return min(ahead, behind) / NEWTON_GAP


@kernel
def coupling_margin(plant: Plant, state: FullMotion) -> float:
    """Return the margin of the magnets: until they part, or until they catch."""
    coupling: Coupling = plant.full.coupling
    if coupling.broken:
        return math.inf
    lag = abs(state.piston_position - state.position)
    if state.coupled > 0.5:
        return (coupling.slip_distance - lag) / NEWTON_GAP
    return (lag - coupling.catch_distance) / NEWTON_GAP


@kernel
def compressor_margin(plant: Plant, state: FullMotion) -> float:
    """Return the margin of the compressor: until its receiver is full, or all but empty."""
    supply = plant.full.supply
    if not supply.compressor:
        return math.inf
    if state.compressor > 0.5:
        return float(supply.switch_off - state.receiver_pressure) / NEWTON_PRESSURE
    return float(state.receiver_pressure - supply.switch_on) / NEWTON_PRESSURE


@kernel
def margins(plant: Plant, state: FullMotion, modes: Modes) -> Margins:
    """Return the margins of all events."""
    carriage, piston = bodies(plant, state)
    locked = plant.cylinder.locked
    one = motion_margin(plant, carriage, modes.carriage, locked)
    cap = cap_margin(plant, carriage, modes.carriage)
    switch = compressor_margin(plant, state)
    if not plant.full.coupling.magnetic:
        return Margins(one, math.inf, cap, math.inf, math.inf, switch)
    return Margins(
        one,
        motion_margin(plant, piston, modes.piston, False),
        cap,
        cap_margin(plant, piston, modes.piston),
        coupling_margin(plant, state),
        switch,
    )


@kernel
def is_crossed(found: Margins) -> bool:
    """Whether one of the margins is below zero."""
    least = math.inf
    for value in found:
        least = min(least, value)
    return least < 0.0


@kernel
def after_events(plant: Plant, state: FullMotion, modes: Modes) -> FullMotion:
    """Return the state after what happens at its instant: where a margin is all but nothing."""
    numbers = numbers_of(state)
    magnetic = plant.full.coupling.magnetic
    found = margins(plant, state, modes)
    if modes.carriage == 0 or found.carriage <= NEAR:
        numbers[VELOCITY] = 0.0
    if found.carriage_cap <= NEAR:
        strike(plant, numbers, POSITION, VELOCITY)
    if magnetic:
        if modes.piston == 0 or found.piston <= NEAR:
            numbers[PISTON_VELOCITY] = 0.0
        if found.piston_cap <= NEAR:
            strike(plant, numbers, PISTON_POSITION, PISTON_VELOCITY)
        if found.coupling <= NEAR:
            numbers[COUPLED] = 1.0 - numbers[COUPLED]
    if found.compressor <= NEAR:
        numbers[COMPRESSOR] = 1.0 - numbers[COMPRESSOR]
    return restored(numbers)


@kernel
def strike(plant: Plant, numbers: Array, position: int, velocity: int) -> None:
    """Let a body rebound from the cap that it has reached; one that leaves it already goes on."""
    stroke = plant.cylinder.stroke
    end = stroke if numbers[position] > 0.5 * stroke else 0.0
    numbers[position] = end
    if (numbers[velocity] > 0.0) == (end > 0.0):
        numbers[velocity] = rebound(plant.end_stop, numbers[velocity])


@kernel
def resumed(plant: Plant, state: FullMotion) -> tuple[FullMotion, Modes]:
    """Return the state after what happens at its instant, and how the bodies move from then on."""
    state = after_events(plant, state, modes_of(plant, state))
    modes = modes_of(plant, state)
    return after_events(plant, state, modes), modes


@kernel
def consistent(plant: Plant, state: FullMotion) -> FullMotion:
    """Return the state as the constants, which may have changed, leave it at the start of a run."""
    coupling = plant.full.coupling
    numbers = numbers_of(state)
    if not plant.full.supply.sags:
        numbers[SUPPLY_PRESSURE] = plant.supply_pressure
    if not plant.full.supply.compressor:
        numbers[RECEIVER_PRESSURE] = plant.supply_pressure
    if compressor_margin(plant, state) < 0.0:
        numbers[COMPRESSOR] = 1.0 - numbers[COMPRESSOR]
    if not coupling.magnetic:
        numbers[PISTON_POSITION] = numbers[POSITION]
        numbers[PISTON_VELOCITY] = numbers[VELOCITY]
        numbers[COUPLED] = 1.0
        return restored(numbers)
    lag = abs(numbers[PISTON_POSITION] - numbers[POSITION])
    if coupling.broken or lag > coupling.slip_distance:
        numbers[COUPLED] = 0.0
    elif lag <= coupling.catch_distance:
        numbers[COUPLED] = 1.0
    return restored(numbers)
