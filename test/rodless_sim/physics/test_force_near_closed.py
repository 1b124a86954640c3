# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where the gap flow was not fitted the force near the closed valve is wrong: docs/limits.md."""

import numpy as np
import pytest

from rodless_base.constants import absolute
from rodless_sim import RigParameters, simulate
from rodless_sim.physics.cylinder import piston_area


@pytest.mark.parametrize(
    ("preset", "supply", "beyond", "wrong"),
    [
        ("paper", 0.9e6, 0.0875, 2.5),
        ("paper", 1.0e6, 0.1125, 7.0),
        ("calibrated", 0.65e6, 0.1, 0.7),
        ("calibrated", 0.8e6, 0.1375, 6.5),
        ("calibrated", 1.0e6, 0.175, 21.0),
    ],
)
def test_the_force_goes_the_wrong_way_as_the_limits_say(
    preset: str, supply: float, beyond: float, wrong: float
) -> None:
    """On a piston that its friction holds at 0.1 m, once the pressures have settled (40 s).

    In N, with the valve ``beyond`` (V) the closed position; more supply than the gap was fitted at.
    To a fifth: the page gives a digit or two.
    """
    rig = RigParameters.preset(preset).with_values({"supply.pressure": absolute(supply)})
    for way in (1.0, -1.0):
        voltage = rig.number("valve.closed_voltage") + way * beyond
        run = simulate(rig, np.full(4000, voltage), 1e-2, 0.1)
        force = piston_area(rig) * (run.pressure_a[-1] - run.pressure_b[-1])
        assert run.position[-1] == pytest.approx(0.1, abs=1e-6)
        assert -way * force == pytest.approx(wrong, rel=0.2)
