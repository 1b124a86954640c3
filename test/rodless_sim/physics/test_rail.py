# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A tilted rail against the inclined plane of the textbook."""

import math

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.equations import applied
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import Motion

SMOOTH = {
    f"friction.{side}.{name}": 0.0
    for side in ("forward", "reverse")
    for name in ("static", "coulomb", "viscous")
}
# Chambers so large and so open that the carriage feels no air: a fall in vacuum, all but.
VENTED = {
    "leak.a": 1e-5,
    "leak.b": 1e-5,
    "valve.gap_height": 0.0,
    "cylinder.dead_volume_a": 1e-2,
    "cylinder.dead_volume_b": 1e-2,
    "cylinder.bore": 5e-3,
    "cylinder.moving_mass": 20.0,
}


def test_the_weight_by_hand() -> None:
    """At 30°, 2 kg pull with 2 · 9.80665 / 2 N toward A's end, wherever the carriage is."""
    plant = Plant.of(RigParameters({"rail.tilt": math.pi / 6.0, "cylinder.moving_mass": 2.0}))
    for position, velocity in ((0.0, 0.0), (0.1, -0.3), (0.2, 0.5)):
        force = applied(plant, Motion(position, velocity, 3e5, 3e5))
        assert force == (pytest.approx(-9.80665, rel=1e-12), 0.0, 0.0)


@pytest.mark.parametrize(("tilt", "start"), [(0.4, 0.2), (-0.4, 0.0), (-math.pi / 2.0, 0.0)])
def test_without_friction_and_air_it_falls(tilt: float, start: float) -> None:
    """Position is that of ½ g sin θ t², within what the little air of the chambers takes."""
    run = simulate(
        RigParameters({**SMOOTH, **VENTED, "rail.tilt": tilt}), [5.08] * 150, 1e-3, start
    )
    fallen = -0.5 * 9.80665 * math.sin(tilt) * run.time**2
    assert abs(fallen[-1]) > 0.04
    assert run.position - start == pytest.approx(fallen, rel=2e-3, abs=1e-9)


def test_it_slides_where_the_weight_exceeds_the_breakaway_force() -> None:
    """Vertical and at equal pressures, 29 N hold 2.9 kg from breaking away downward, not 3.1 kg."""
    for mass, moves in ((2.9, False), (3.1, True)):
        # B's end down: its weight draws it forward.
        parameters = RigParameters({"rail.tilt": -math.pi / 2.0, "cylinder.moving_mass": mass})
        rig = Rig(parameters)
        rig.reset(0.1)
        assert (rig.advance(5.08, 0.01).position > 0.1) is moves


def test_level_it_is_the_rig_of_the_paper() -> None:
    """With a tilt of 0 nothing changes, to the last bit."""
    runs = [simulate(RigParameters(v), [6.0] * 300, 1e-3) for v in ({}, {"rail.tilt": 0.0})]
    assert np.array_equal(runs[0].position, runs[1].position)
