# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The instant of breakaway itself: a push that is F_s exactly, or a hair to either side."""

import math

import pytest

from rodless_sim import Rig, RigParameters
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

PLANT = Plant.of(RigParameters())
AREA = math.pi / 4.0 * 0.025**2


@pytest.mark.parametrize("voltage", [6.0, 4.0])
def test_a_rig_without_dry_friction_moves_as_soon_as_the_valve_opens(voltage: float) -> None:
    """With F_s = F_c = 0 the push at rest equals the limit, 0 = 0; any push must move it."""
    dry = {
        f"friction.{side}.{name}": 0.0
        for side in ("forward", "reverse")
        for name in ("static", "coulomb")
    }
    rig = Rig(RigParameters(dry))
    rig.reset(0.1)
    state = rig.advance(voltage, 0.5)
    assert (state.position - 0.1) * (voltage - 5.08) > 1e-3
    assert abs(state.pressure_a - state.pressure_b) > 1e4


@pytest.mark.parametrize("ulps", range(-20, 3))
def test_a_push_that_grows_past_the_limit_from_right_below_it_moves_the_carriage(ulps: int) -> None:
    """Starting within rounding of 29 N with the valve opening forward, it slides within 0.1 s."""
    pressure_a = 3e5 + 29.0 / AREA + ulps * math.ulp(3e5)
    state = advance(PLANT, openings(PLANT, 6.0), Motion(0.1, 0.0, pressure_a, 3e5), 0.1, 1.0)[0]
    assert state.position > 0.1 + 1e-4


@pytest.mark.parametrize("excess", [1e-3, 1e-4, 1e-6, 1e-9, 0.0, -1e-9])
def test_a_push_that_falls_from_right_above_the_limit_lets_the_air_go_on(excess: float) -> None:
    """Starting a hair above 29 N with the valve venting A, the carriage stays and A empties.

    Its pressures after 0.1 s are those of a carriage that starts well below the limit, shifted
    by no more than the difference of the starts.
    """
    state, below = (
        advance(
            PLANT,
            openings(PLANT, 4.0),
            Motion(0.1, 0.0, 3e5 + (29.0 + over) / AREA, 3e5),
            0.1,
            1.0,
        )[0]
        for over in (excess, -0.01)
    )
    assert state.position == pytest.approx(0.1, abs=1e-9)
    assert state.pressure_a == pytest.approx(below.pressure_a, abs=25.0)
    assert state.pressure_b == pytest.approx(below.pressure_b, abs=1.0)
