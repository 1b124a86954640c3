# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant in open loop by scipy's Radau at 1e-10, with stick, slip and end caps as its events.

It shares the plant's rates of change with the package (a test holds those against a second reading
of the paper), but nothing of how they become motion: neither the method nor its control of the
error, nor the search for events.
"""

import math
import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from rodless_base.kernels import outlined_kernel, specialise
from rodless_sim import RigParameters
from rodless_sim.physics.end_stop import rebound
from rodless_sim.physics.equations import breakaway_limits, net_force, rates, sliding_direction
from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import AnyMotion, HeatedMotion, Motion
from rodless_sim.rig import starting_motion

Array = npt.NDArray[np.float64]

RELATIVE = 1e-10
ABSOLUTE = (1e-13, 1e-12, 1e-5, 1e-5, 1e-8, 1e-8)  # m, m/s, Pa, Pa, K, K
LONGEST_STEP = 1e-3  # s
# By how much the push exceeds the breakaway force when the carriage moves: at the force itself,
# rounding alone would decide which way it goes.
MARGIN = 1e-9  # N


@outlined_kernel
def _rates(plant: Plant, lands: Lands, state: AnyMotion, direction: int) -> AnyMotion:
    return rates(plant, lands, state, direction)


@outlined_kernel
def _until_change(plant: Plant, state: AnyMotion, direction: int) -> float:
    """What falls through zero where a sliding carriage stops, and where one at rest moves."""
    if direction != 0:
        return state.velocity * direction
    low, high = breakaway_limits(plant, state.position)
    force = net_force(plant, state)
    return min(force - low, high - force) + MARGIN


def motion_of(state: Array) -> AnyMotion:
    """Return the state that an array of its numbers is."""
    kind = Motion if len(state) == len(Motion._fields) else HeatedMotion
    return kind(*state.tolist())


def by_radau(
    parameters: RigParameters,
    voltages: Array,
    period: float,
    position: float,
    timeout: float = math.inf,
) -> Array:
    """Return the state at each sample: shape (n + 1, 4), or 6 where chambers have temperatures.

    ``voltages``, shape (n,), V, apply for ``period`` s each. The carriage starts at rest at
    ``position`` (m), the chambers settled. Raises RuntimeError where Radau gives up, and
    TimeoutError where it takes longer than ``timeout`` s. Raises ValueError for a valve whose spool
    does not follow at once, and for options with further states.
    """
    plant = Plant.of(parameters)
    if plant.drive:
        raise ValueError("by_radau() keeps the openings constant: it knows no spool that moves")
    if plant.full:
        raise ValueError("by_radau() knows neither bristles nor a piston of its own nor drift")
    if plant.tubes or plant.ripple:
        raise ValueError("by_radau() knows neither tubes.model nor supply.ripple_amplitude")
    deadline = time.monotonic() + timeout
    state: Array = np.array(starting_motion(plant, parameters, position), dtype=np.float64)
    rows: list[Array] = [state[None]]
    changes = np.flatnonzero(np.diff(voltages)) + 1
    for held in np.split(voltages, changes):
        samples = np.arange(1, held.size + 1, dtype=np.float64) * period
        rows.append(
            _held(plant, openings(plant, float(held[0])), rows[-1][-1].copy(), samples, deadline)
        )
    return np.concatenate(rows)


def _held(plant: Plant, lands: Lands, state: Array, samples: Array, deadline: float) -> Array:
    """Return the state at ``samples`` (s) while the valve keeps its openings."""
    start = motion_of(state)
    compiled = specialise(_rates, plant, lands, start, 1)
    found: list[Array] = []
    now, end = 0.0, float(samples[-1])
    direction = sliding_direction(plant, start)
    while now < end:
        if direction == 0:
            state[1] = 0.0

        def rate(_: float, s: Array, direction: int = direction) -> AnyMotion:
            if time.monotonic() > deadline:
                raise TimeoutError("takes too long")
            return compiled(plant, lands, motion_of(s), direction)

        events = _events(plant, start, direction)
        run = solve_ivp(
            rate,
            (now, end),
            state,
            method="Radau",
            rtol=RELATIVE,
            atol=ABSOLUTE[: len(state)],
            max_step=LONGEST_STEP,
            events=events,
            dense_output=True,
        )
        if run.status < 0:
            raise RuntimeError(run.message)
        assert run.sol is not None
        assert run.t_events is not None
        within = samples[(samples > now) & (samples <= run.t[-1])]
        if within.size:
            found.append(run.sol(within).T)
        now, state = float(run.t[-1]), run.y[:, -1].copy()
        if run.status == 1:
            state, direction = _after(plant, state, direction, len(run.t_events[1]) > 0)
            if found and now == samples[sum(map(len, found)) - 1]:
                found[-1][-1] = state
    return np.concatenate(found)


def _after(plant: Plant, state: Array, direction: int, struck: bool) -> tuple[Array, int]:
    """Return the state just after an event, and the direction of sliding from then on."""
    if direction == 0:
        return state, 1 if net_force(plant, motion_of(state)) > 0.0 else -1
    if struck:
        state[0] = plant.cylinder.stroke if direction > 0 else 0.0
        state[1] = rebound(plant.end_stop, float(state[1]))
    else:
        state[1] = 0.0
    return state, sliding_direction(plant, motion_of(state))


def _events(
    plant: Plant, example: AnyMotion, direction: int
) -> tuple[Callable[[float, Array], float], ...]:
    """Return what falls through zero at a change between stick and slip, and at a cap."""
    until_change = specialise(_until_change, plant, example, 1)

    def change(_: float, s: Array) -> float:
        return until_change(plant, motion_of(s), direction)

    def strike(_: float, s: Array) -> float:
        if direction == 0:
            return 1.0
        return float(plant.cylinder.stroke - s[0] if direction > 0 else s[0])

    for event in (change, strike):
        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
    return change, strike
