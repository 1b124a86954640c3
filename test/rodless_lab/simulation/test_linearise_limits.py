# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Linear models at the limits of the command, and what their supply is."""

import numpy as np
import pytest

from rodless_lab import linearise
from rodless_sim import RigParameters
from rodless_sim.physics.equations import inflows, sliding_rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion


def pressure_rates(parameters: RigParameters, voltage: float, motion: Motion) -> np.ndarray:
    """The rates of both pressures in Pa/s, as the rig's equations have them."""
    plant = Plant.of(parameters)
    flows = inflows(plant, openings(plant, voltage), motion)
    found = sliding_rates(plant, motion, flows, 1 if motion.velocity > 0.0 else -1)
    return np.array([found.a.rate, found.b.rate])


@pytest.mark.parametrize(("limit", "inward"), [(10.0, -1.0), (0.0, 1.0)])
def test_at_the_commands_limits_the_model_is_that_within(
    limit: float, inward: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No voltage beyond them is looked at; the slope is that of a parabola through three within."""
    asked: list[float] = []

    def watched(plant: Plant, voltage: float) -> object:
        asked.append(voltage)
        return openings(plant, voltage)

    monkeypatch.setattr("rodless_lab.simulation.linearise.openings", watched)
    parameters = RigParameters()
    found = linearise(parameters, 0.1, limit)
    assert 0.0 <= min(asked) < max(asked) <= 10.0
    step = 1e-3 * inward
    at, near, far = (
        pressure_rates(parameters, limit + place * step, found.point.motion) for place in range(3)
    )
    expected = (-3.0 * at + 4.0 * near - far) / (2.0 * step)
    assert found.B[2:, 0] == pytest.approx(expected, rel=1e-4)


def test_the_supply_of_the_model_is_that_at_the_valve() -> None:
    """What a supply that has lost 0.2 passes on of a change of its set pressure is 0.8."""
    parameters = RigParameters({"fault.supply.loss": 0.2})
    found = linearise(parameters, 0.1, 6.0)
    (supply,) = (one for one in found.inputs if one.name == "supply_pressure")
    assert "at the valve" in supply.meaning
    set_pressure = parameters.number("supply.pressure")
    low, high = (
        pressure_rates(
            parameters.with_values({"supply.pressure": set_pressure + change}),
            6.0,
            found.point.motion,
        )
        for change in (-50.0, 50.0)
    )
    assert (high - low) / 100.0 == pytest.approx(0.8 * found.B[2:, 2], rel=1e-4)
