# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which options need the states of :class:`FullMotion`, and which of these act.

An option that needs a state of its own adds the state in :mod:`state`, its constants here, what it
does in :mod:`full_rates`, and what happens at an instant in :mod:`full_events`. As soon as one of
them is on, the plant moves as a full motion. Which of its states act is known when it runs: the
others have no rate and cost nothing in :mod:`full_step`.
"""

from typing import NamedTuple

from rodless_base.parameters import ParameterSet
from rodless_sim.physics.bristles import Bristles
from rodless_sim.physics.coupling import Coupling
from rodless_sim.physics.drift import Drift
from rodless_sim.physics.heat import ENERGY_BALANCE
from rodless_sim.physics.sagging_supply import Supply
from rodless_sim.physics.state import DRIFTS, FURTHER, TEMPERATURES, FullMotion, Motion

STATES = FullMotion._fields


class Full(NamedTuple):
    """Constants of the options that need further states."""

    heated: bool  # whether the chambers have temperatures of their own
    bristles: Bristles
    coupling: Coupling
    supply: Supply
    drift: Drift
    # Places of states in FullMotion, in its order; what is behind the first ``…_count`` is filler.
    moving: tuple[int, ...]  # those that have a rate
    moving_count: int
    shown: tuple[int, ...]  # those that a recorded sample has behind what every rig has
    shown_count: int


def of(parameters: ParameterSet) -> Full | tuple[()]:
    """Return the constants for ``parameters``; none where no option needs further states."""
    bristles, coupling = Bristles.of(parameters), Coupling.of(parameters)
    drift, supply = Drift.of(parameters), Supply.of(parameters)
    if not (bristles.acting or coupling.magnetic or drift.acting or supply.acting):
        return ()
    heated = parameters.text("chambers.thermodynamics") == ENERGY_BALANCE
    moving = [*Motion._fields]
    # What is shown, too, though it only changes at instants.
    stepping: list[str] = []
    if heated:
        moving += TEMPERATURES
    if bristles.acting:
        moving.append("bristle_deflection")
    if coupling.magnetic:
        moving += ["piston_position", "piston_velocity"]
        stepping.append("coupled")
        if bristles.acting:
            moving.append("piston_bristle_deflection")
    if drift.acting:
        stepping += DRIFTS
    if supply.sags:
        moving.append("supply_pressure")
    if supply.compressor:
        moving.append("receiver_pressure")
        stepping.append("compressor")
    shown = [name for name in (*moving, *stepping) if name in FURTHER]
    return Full(heated, bristles, coupling, supply, drift, *_places(moving), *_places(shown))


def _places(names: list[str]) -> tuple[tuple[int, ...], int]:
    """Return the places of the states ``names``, in order and filled up, and their number."""
    places = sorted(STATES.index(name) for name in {*names})
    return (*places, *[0] * (len(STATES) - len(places))), len(places)


def further_of(full: Full) -> tuple[str, ...]:
    """Return the names of the states that are shown beside those every rig has."""
    return tuple(STATES[place] for place in full.shown[: full.shown_count])
