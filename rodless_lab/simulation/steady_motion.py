# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Steady motion: the velocity and the pressures at which a voltage keeps the carriage going."""

import math

import numpy as np
from scipy.optimize import brentq

from rodless_sim.physics.equations import breakaway_limits, net_force, rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.state import Motion

# Between these pressures, as logarithms of Pa, any chamber settles.
LOGARITHMS = (math.log(1e-3), math.log(1e10))

# Each chamber in turn: once is enough, unless a leak joins them.
MOST_ROUNDS = 1000

# Faster than any cylinder: no steady motion up to here means that there is none.
FASTEST = 100.0  # m/s


class NoSteadyMotionError(ValueError):
    """At this voltage the carriage does not go on at any velocity."""


def steady_pressures(
    plant: Plant, position: float, voltage: float, velocity: float, direction: int
) -> Motion:
    """Return the state in which the pressures stay as they are while the carriage moves.

    ``position`` in m, ``voltage`` in V, ``velocity`` in m/s, of which ``direction`` is the sign.
    """
    lands = openings(plant, voltage)

    def settled(state: Motion, name: str) -> Motion:
        """Settle one pressure: the more air a chamber holds, the less it takes."""

        def at(logarithm: float) -> Motion:
            return state._replace(**{name: math.exp(logarithm)})

        def rate(logarithm: float) -> float:
            return float(getattr(rates(plant, lands, at(logarithm), direction), name))

        try:
            return at(brentq(rate, *LOGARITHMS, xtol=1e-14, rtol=8.9e-16))
        except ValueError as error:
            raise NoSteadyMotionError(
                f"{name} does not settle at {voltage:g} V and {velocity:g} m/s"
            ) from error

    state = Motion(position, velocity, plant.supply_pressure, plant.supply_pressure)
    for _ in range(MOST_ROUNDS):
        before, state = state, settled(settled(state, "pressure_a"), "pressure_b")
        if np.allclose(before, state, rtol=1e-12, atol=0.0):
            return state
    raise NoSteadyMotionError(
        f"the pressures do not settle at {voltage:g} V and {velocity:g} m/s; check leak.across"
    )


def steady_motion(plant: Plant, position: float, voltage: float) -> Motion:
    """Return the state in which the carriage goes on as it is, without any load.

    Parameters
    ----------
    plant
        Constants of the rig.
    position
        Where the carriage passes, m.
    voltage
        At the valve, V.

    Raises
    ------
    NoSteadyMotionError
        Where friction holds the carriage.
    """
    held = Motion(position, 0.0, *settled_pressures(plant, voltage))
    force = net_force(plant, held)
    low, high = breakaway_limits(plant, position)
    if low <= force <= high:
        raise NoSteadyMotionError(
            f"at {voltage:g} V the carriage sticks at {position:g} m: {force:.3g} N do not "
            f"overcome friction; take a voltage farther from {plant.valve.closed_voltage:g} V, "
            "or give the velocity"
        )
    direction = 1 if force > 0.0 else -1
    lands = openings(plant, voltage)

    def push(speed: float) -> float:
        """Acceleration in the direction of motion, m/s²."""
        state = steady_pressures(plant, position, voltage, direction * speed, direction)
        return direction * rates(plant, lands, state, direction).velocity

    fastest = 0.01
    while push(fastest) > 0.0:
        fastest *= 2.0
        if fastest > FASTEST:
            raise NoSteadyMotionError(f"at {voltage:g} V the carriage goes ever faster")
    speed = brentq(push, 0.0, fastest, xtol=1e-12, rtol=8.9e-16)
    return steady_pressures(plant, position, voltage, math.copysign(speed, direction), direction)
