# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant against scipy's Radau: rigs that once gave nonsense, and some of the campaign's."""

import math

import numpy as np
import pytest

from rodless_lab.accuracy.judge import columns
from rodless_lab.accuracy.radau import by_radau
from rodless_lab.accuracy.random_rigs import PERIOD, case
from rodless_lab.bare_rigs import bare_rig
from rodless_sim import RigParameters, simulate

pytestmark = pytest.mark.slow

ONCE_WRONG: dict[str, dict[str, object]] = {
    "saturating friction with B2 of 1e5": {
        "friction.form": "saturating",
        "friction.high_speed_viscous": 1e5,
    },
    "100 mm with 2 cm³": {
        "cylinder.bore": 0.1,
        "cylinder.dead_volume_a": 2e-6,
        "cylinder.dead_volume_b": 2e-6,
    },
    "printed with a 7 mm sleeve": {
        "valve.assembly": "printed",
        "valve.sleeve_diameter": 7e-3,
    },
    "63 mm": {"cylinder.bore": 0.063},
}


@pytest.mark.parametrize("changes", ONCE_WRONG.values(), ids=ONCE_WRONG.keys())
def test_rigs_that_once_gave_nonsense(changes: dict[str, object]) -> None:
    """There and back, within 1 µm and 0.1 kPa of Radau at 1e-10."""
    parameters = RigParameters(changes)
    voltages = np.repeat([7.0, 5.08, 3.0], 60)
    found = columns(simulate(parameters, voltages, PERIOD, 0.1))
    expected = by_radau(parameters, voltages, PERIOD, 0.1)
    assert np.abs(found[:, 0] - expected[:, 0]).max() < 1e-6
    assert np.abs(found[:, 1:] - expected[:, 2:]).max() < 100.0
    assert np.ptp(expected[:, 2]) > 1e3


@pytest.mark.parametrize("number", [0, 1, 8, 26])
def test_rigs_of_the_campaign(number: int) -> None:
    """Around both bare rigs and from the whole range: within 1 µm at the default tolerance."""
    chosen = case(number)
    assert chosen.voltages is not None
    voltages = chosen.voltages[:300]
    found = simulate(chosen.parameters, voltages, PERIOD, chosen.position)
    expected = by_radau(chosen.parameters, voltages, PERIOD, chosen.position)
    assert np.abs(found.position - expected[:, 0]).max() < 1e-6


def test_a_spool_that_moves_is_refused() -> None:
    """Not computed as if the openings were constant."""
    parameters = RigParameters({"valve.dynamics": "second_order"})
    with pytest.raises(ValueError, match="knows no spool that moves"):
        by_radau(parameters, np.full(4, 6.0), PERIOD, 0.1)


def test_radau_finds_an_impact_by_hand() -> None:
    """A push of 10 V onto the cap ends there at rest, and time out means what it says."""
    parameters = bare_rig("saturating")
    rows = by_radau(parameters, np.full(400, 10.0), PERIOD, 0.19)
    assert rows[-1, 0] == parameters["cylinder.stroke"]
    assert rows[-1, 1] == 0.0
    assert rows[:, 1].max() > 0.05
    with pytest.raises(TimeoutError):
        by_radau(parameters, np.full(400, 10.0), PERIOD, 0.1, timeout=-math.inf)
