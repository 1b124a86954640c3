# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Mirror symmetry: with the chambers swapped and both directions alike, the rig runs backwards.

The measured valve curve is not even about its centre, so a mirrored *voltage* is no mirrored rig;
the land edges are therefore swapped by hand.
"""

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

STEP = 20e-6
STROKE = 0.2


def even_plant(form: str, volume_a: float, volume_b: float) -> Plant:
    """A rig whose friction is the same both ways."""
    reverse = {
        "friction.reverse.static": 29.0,
        "friction.reverse.coulomb": 12.0,
        "friction.reverse.stribeck_velocity": 1.3e-3,
        "friction.reverse.viscous": 4500.0,
    }
    volumes = {"cylinder.dead_volume_a": volume_a, "cylinder.dead_volume_b": volume_b}
    return Plant.of(RigParameters({"friction.form": form, **reverse, **volumes}))


def mirrored(state: Motion) -> Motion:
    return Motion(STROKE - state.position, -state.velocity, state.pressure_b, state.pressure_a)


def assert_close(state: Motion, other: Motion) -> None:
    assert state.position == pytest.approx(other.position, abs=1e-12)
    assert state.velocity == pytest.approx(other.velocity, abs=1e-9)
    assert state.pressure_a == pytest.approx(other.pressure_a, rel=1e-9)
    assert state.pressure_b == pytest.approx(other.pressure_b, rel=1e-9)


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
def test_a_rig_driven_through_the_other_edges_is_its_mirror_image(form: str) -> None:
    """Opening at 6 V toward A, or the same edges toward B with dead volumes swapped: mirrored."""
    plant, swapped = even_plant(form, 15e-6, 30e-6), even_plant(form, 30e-6, 15e-6)
    forward = openings(plant, 6.0)
    backward = forward._replace(forward=False)
    state = start = Motion(0.06, 0.0, 4e5, 4.2e5)
    other = mirrored(start)
    for _ in range(15_000):
        state = advance(plant, forward, state, STEP, 1.0)[0]
        other = advance(swapped, backward, other, STEP, 1.0)[0]
    assert state.position > start.position + 1e-3
    assert_close(state, mirrored(other))


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
@pytest.mark.parametrize("position", [0.05, 0.199])
def test_a_carriage_thrown_with_the_valve_closed_is_its_mirror_image(
    form: str, position: float
) -> None:
    """At 5.08 V all edges are alike: throws to either side mirror, into an end cap included."""
    plant = even_plant(form, 15e-6, 15e-6)
    start = Motion(position, 0.6, 4.6e5, 4.4e5)
    state = advance(plant, openings(plant, 5.08), start, 5000 * STEP, 1.0)[0]
    other = advance(plant, openings(plant, 5.08), mirrored(start), 5000 * STEP, 1.0)[0]
    assert abs(state.position - position) > 1e-5
    assert_close(state, mirrored(other))
