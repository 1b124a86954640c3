# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A :class:`FullMotion` as an array of its numbers, which compiled code can change one by one."""

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_sim.physics.state import DRIFTS, FullMotion

Array = npt.NDArray[np.float64]

COUNT = len(FullMotion._fields)

# Places of states.
POSITION, VELOCITY = map(FullMotion._fields.index, ("position", "velocity"))
PISTON_POSITION, PISTON_VELOCITY, COUPLED = map(
    FullMotion._fields.index, ("piston_position", "piston_velocity", "coupled")
)
SUPPLY_PRESSURE, RECEIVER_PRESSURE, COMPRESSOR = map(
    FullMotion._fields.index, ("supply_pressure", "receiver_pressure", "compressor")
)
CLOCK, DICE = map(FullMotion._fields.index, ("friction_clock", "friction_dice"))
FIRST_DRIFT, LAST_DRIFT = (FullMotion._fields.index(DRIFTS[k]) for k in (0, -1))
OF_CARRIAGE = (POSITION, VELOCITY, FullMotion._fields.index("bristle_deflection"))
OF_PISTON = (
    PISTON_POSITION,
    PISTON_VELOCITY,
    FullMotion._fields.index("piston_bristle_deflection"),
)


@kernel
def store(state: FullMotion, numbers: Array) -> None:
    """Write the numbers of a state, or of its rates."""
    for k in range(COUNT):
        numbers[k] = state[k]


@kernel
def numbers_of(state: FullMotion) -> Array:
    """Return the numbers of a state."""
    numbers = np.empty(COUNT)
    store(state, numbers)
    return numbers


@kernel
def restored(numbers: Array) -> FullMotion:
    """Return the state, or the rates, that these numbers are."""
    return FullMotion(
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        numbers[5],
        numbers[6],
        numbers[7],
        numbers[8],
        numbers[9],
        numbers[10],
        numbers[11],
        numbers[12],
        numbers[13],
        numbers[14],
        numbers[15],
        numbers[16],
        numbers[17],
        numbers[18],
    )
