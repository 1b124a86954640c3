# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""States that no rig has, each told by its code and in words."""

import math

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.faults import MEANING, SimulationError, fault_of, simulation_error
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import Motion
from rodless_sim.physics.timed import memory_of

PLANT = Plant.of(RigParameters())
# Where the volume of 15 cm³ behind each cap is used up: 15e-6 / 490.874e-6 m past it.
BEHIND_A, BEHIND_B = -0.030558, 0.230558
FIELDS = Motion._fields


@pytest.mark.parametrize(
    ("change", "words"),
    [
        *(({name: math.nan}, "a state is not a finite number") for name in FIELDS),
        *(({name: -math.inf}, "a state is not a finite number") for name in FIELDS),
        ({"pressure_a": 0.0}, "a pressure is not positive"),
        ({"pressure_b": 0.0}, "a pressure is not positive"),
        ({"pressure_a": -1.0}, "a pressure is not positive"),
        ({"pressure_b": -1.0}, "a pressure is not positive"),
        ({"position": BEHIND_A - 1e-6}, "a chamber has no volume"),
        ({"position": BEHIND_B + 1e-6}, "a chamber has no volume"),
    ],
)
def test_a_state_that_no_rig_has_is_told(change: dict[str, float], words: str) -> None:
    """One number of a sound state at a time; the error says what, when and where."""
    state = Motion(0.1, 0.0, 4e5, 3e5)._replace(**change)
    error = simulation_error(fault_of(PLANT, state), 1.5, state)
    assert isinstance(error, SimulationError)
    assert str(error).startswith(f"after 1.5 s: {words} (position {state.position:g} m, ")
    assert f"pressures {state.pressure_a:g} and {state.pressure_b:g} Pa); check " in str(error)


def test_a_chamber_that_tubes_have_emptied_is_told() -> None:
    """The tubes are named where there are some, and else what a vacuum comes from."""
    parameters = RigParameters({"tubes.model": "delay"})
    state = Motion(0.1, 0.0, -1.0, 3e5)
    memory = memory_of(Plant.of(parameters), Motion(0.1, 0.0, 4e5, 3e5), 5.0)
    fault = fault_of(PLANT, state)
    assert "raise cylinder.dead_volume_*, or shorten tubes.length" in str(
        simulation_error(fault, 0.0, state, memory)
    )
    assert "tubes" not in str(simulation_error(fault, 0.0, state))


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"velocity": -3.0},
        {"pressure_a": 1e-3},
        {"pressure_b": 0.5},
        {"position": BEHIND_A + 1e-6},
        {"position": BEHIND_B - 1e-6},
    ],
)
def test_a_sound_state_has_no_fault(change: dict[str, float]) -> None:
    """Up to the last of the air and of the room for it; and no meaning is given for no fault."""
    assert fault_of(PLANT, Motion(0.1, 0.0, 4e5, 3e5)._replace(**change)) == 0
    assert sorted(MEANING) == [1, 2, 3, 4, 5]
