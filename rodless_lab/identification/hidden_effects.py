# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Rigs with an effect that whoever identifies them leaves out, and what the verdict makes of them.

Each effect is on alone, in a size drawn over the range a rig may have. A draw is silently wrong
where an interval misses the truth and the verdict says that the model fits.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rodless_base.parameters import Value

Draw = Callable[[np.random.Generator], dict[str, Value]]


def any_size(generator: np.random.Generator, low: float, high: float) -> float:
    """Draw a size, its logarithm anywhere alike."""
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def _between(name: str, low: float, high: float, **others: Value) -> Draw:
    """Return a draw of a parameter by :func:`any_size`, with ``others`` as they are."""

    def draw(generator: np.random.Generator) -> dict[str, Value]:
        size = any_size(generator, low, high)
        return {**{key.replace("__", "."): value for key, value in others.items()}, name: size}

    return draw


def _drift(generator: np.random.Generator) -> dict[str, Value]:
    """Draw how fast friction drifts, and which course of it."""
    seed = int(generator.integers(1, 2**31))
    return {"friction.drift": any_size(generator, 0.005, 0.1), "friction.drift_seed": seed}


# By the effect's name; the parameters' own defaults lie within these ranges.
EFFECTS: dict[str, Draw] = {
    "heat": _between(
        "chambers.heat_transfer_coefficient", 20.0, 200.0, chambers__thermodynamics="energy_balance"
    ),
    "polytropic": _between(
        "chambers.polytropic_index", 1.05, 1.3, chambers__thermodynamics="polytropic"
    ),
    "leak across": _between("leak.across", 2e-9, 2e-8),
    "leak a": _between("leak.a", 2e-9, 2e-8),
    "leak b": _between("leak.b", 2e-9, 2e-8),
    "iso_6358": _between("valve.sonic_conductance", 3.5e-9, 4.3e-9, valve__flow_law="iso_6358"),
    "discharge": _between("valve.discharge_coefficient", 0.85, 0.95, valve__discharge="constant"),
    "spool": _between(
        "valve.natural_frequency",
        80.0,
        150.0,
        valve__dynamics="second_order",
    ),
    "hysteresis": _between("valve.hysteresis", 1e-3, 4e-3),
    "dead time": _between("valve.dead_time", 5e-4, 5e-3),
    "saturating": _between("friction.high_speed_viscous", 40.0, 160.0, friction__form="saturating"),
    "tilt": _between("rail.tilt", 0.005, 0.05),
    "lugre": _between("friction.bristle_stiffness", 1e5, 5e5, friction__dynamics="lugre"),
    "drift": _drift,
    "magnets": _between("coupling.slip_distance", 2e-3, 5e-3, coupling__kind="magnetic"),
    "tubes": _between("tubes.length", 0.2, 0.6, tubes__model="delay"),
    "droop": _between("supply.droop", 2e6, 2e7),
    "supply's lag": _between("supply.time_constant", 0.01, 0.5, supply__droop=1.2e7),
    "ripple": _between("supply.ripple_amplitude", 1e3, 2e4),
    "compressor": _between(
        "supply.receiver_volume",
        1e-3,
        0.024,
        supply__kind="compressor",
        supply__switch_on_pressure=0.5e6,
        supply__switch_off_pressure=0.71e6,
    ),
    "sensors' lag": _between("sensors.pressure_lag", 1e-3, 0.01),
}


@dataclass(frozen=True)
class Outcome:
    """Of so many draws: in how many the verdict says misfit, all intervals cover, neither."""

    draws: int
    refused: int
    covered: int
    silent: int


def outcome(trials: list[tuple[bool, bool]]) -> Outcome:
    """Count pairs of: the verdict says that the model fits, all informed intervals cover."""
    return Outcome(
        len(trials),
        sum(not fits for fits, _ in trials),
        sum(covered for _, covered in trials),
        sum(fits and not covered for fits, covered in trials),
    )
