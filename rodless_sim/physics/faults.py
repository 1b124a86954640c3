# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is not a rig any more: a state that no rig has, or motion that cannot be followed."""

import math

from rodless_base.kernels import kernel_by_type
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import AnySpool, Memory, place_of
from rodless_sim.physics.state import AnyMotion, FullMotion, HeatedMotion, Motion

SOUND = 0
NOT_FINITE = 1
NO_PRESSURE = 2
NO_VOLUME = 3
TOO_MANY_STEPS = 4
NO_TEMPERATURE = 5

# What it is, and which parameters it is likely to come from.
MEANING = {
    NOT_FINITE: (
        "a state is not a finite number",
        "check the pressures given, cylinder.moving_mass and the values of friction.*",
    ),
    NO_PRESSURE: (
        "a pressure is not positive",
        "check the pressures given, valve.area_coefficients and valve.flow_coefficients",
    ),
    NO_VOLUME: (
        "a chamber has no volume",
        "check cylinder.dead_volume_a, cylinder.dead_volume_b and the position given",
    ),
    NO_TEMPERATURE: (
        "a temperature is not positive",
        "check the temperatures given and chambers.heat_transfer_coefficient",
    ),
    TOO_MANY_STEPS: (
        "the motion is too fast to follow",
        "raise time.tolerance, or check friction.*.stribeck_velocity, cylinder.moving_mass and "
        "the cylinder.dead_volume_*",
    ),
}
EMPTIED = (
    "tubes draw air from a chamber for the time of sound, here more than it has: raise "
    "cylinder.dead_volume_*, or shorten tubes.length"
)


class SimulationError(RuntimeError):
    """The simulation left what a rig can do; the text says when, what, and what to check.

    Examples
    --------
    >>> from rodless_sim import Rig, SimulationError
    >>> rig = Rig()
    >>> state = rig.reset(pressures=(1e-100, 1e100))
    >>> try:
    ...     rig.advance(voltage=10.0, duration=1.0)
    ... except SimulationError as error:
    ...     print(str(error).partition(":")[0])
    after 0 s
    """


@kernel_by_type
def fault_of(plant: Plant, state: Motion) -> int:
    """Return what is wrong with a state, as one of the codes above."""
    total = state.position + state.velocity + state.pressure_a + state.pressure_b
    if not math.isfinite(total):
        return NOT_FINITE
    if state.pressure_a <= 0.0 or state.pressure_b <= 0.0:
        return NO_PRESSURE
    cylinder = plant.cylinder
    if min(volume_a(cylinder, state.position), volume_b(cylinder, state.position)) <= 0.0:
        return NO_VOLUME
    return SOUND


def simulation_error(
    fault: int, time: float, state: AnyMotion, spool: AnySpool = ()
) -> SimulationError:
    """Return the error for a fault in the sample period that began at ``time`` (s)."""
    what, advice = MEANING[fault]
    if fault == NO_PRESSURE and isinstance(spool, Memory) and spool.tubes:
        advice = EMPTIED
    air = f"pressures {state.pressure_a:g} and {state.pressure_b:g} Pa"
    if isinstance(state, HeatedMotion | FullMotion):
        air += f", temperatures {state.temperature_a:g} and {state.temperature_b:g} K"
    place = place_of(spool)
    if place is not None:
        air += f", spool at {place:g} V"
    return SimulationError(
        f"after {time:g} s: {what} (position {state.position:g} m, "
        f"velocity {state.velocity:g} m/s, {air}); {advice}"
    )
