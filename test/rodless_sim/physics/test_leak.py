# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Leaks across the piston and to ambient against closed forms and balances."""

import math

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.equations import inflows, pressure_rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

KAPPA, GAS, TEMPERATURE, AMBIENT = 1.4, 287.05, 297.0, 101325.0
CHOKED = 0.684731
# Nothing but the leak passes any air, and the carriage stays where it is.
SEALED = {"valve.gap_height": 0.0, "cylinder.locked": True}
HALF = 15e-6 + math.pi / 4.0 * 0.025**2 * 0.1


def closed(leaks: dict[str, float], pressures: tuple[float, float], seconds: float) -> np.ndarray:
    """Pressures of both chambers, shape (n, 2), the valve closed, the carriage at mid-stroke."""
    parameters = RigParameters({**SEALED, **leaks})
    voltages = np.full(round(seconds / 1e-3), 5.08)
    run = simulate(parameters, voltages, 1e-3, 0.1, pressures)
    return np.column_stack([run.pressure_a, run.pressure_b])


@pytest.mark.parametrize("side", ["a", "b"])
def test_a_choked_leak_to_ambient_is_an_exponential(side: str) -> None:
    """dP/dt = -κ ψ S √(RT)/V · P until P is 1.9 times ambient: for 0.5 mm² by e in 0.46 s."""
    found = closed({f"leak.{side}": 0.5e-6}, (6e5, 6e5), 0.08)
    rate = KAPPA * CHOKED * 0.5e-6 * math.sqrt(GAS * TEMPERATURE) / HALF
    times = np.arange(len(found)) * 1e-3
    column, other = (0, 1) if side == "a" else (1, 0)
    expected = 6e5 * np.exp(-rate * times)
    assert expected[-1] > AMBIENT / 0.528
    assert found[:, column] == pytest.approx(expected, rel=1e-5)
    assert found[:, other] == pytest.approx(6e5, abs=1e-6)


def test_a_leak_across_the_piston_moves_air_and_loses_none() -> None:
    """P_a V_a + P_b V_b stays to 1e-9, and the chambers end at the same pressure."""
    found = closed({"leak.across": 1e-6}, (6e5, 2e5), 1.0)
    assert found.sum(axis=1) == pytest.approx(8e5, rel=1e-9)
    assert found[-1] == pytest.approx([4e5, 4e5], abs=1.0)
    assert np.all(np.diff(found[:, 0]) <= 1e-6)


def test_settled_pressures_balance_what_valve_and_leaks_pass() -> None:
    """At the pressures the rig starts with no net air enters either chamber; a leak lowers them."""
    sound = Rig().state
    for leaks in (
        {"leak.a": 2e-8},
        {"leak.across": 5e-8, "leak.b": 3e-8},
        {"leak.across": 1e-5, "leak.a": 1e-5},
    ):
        state = Rig(RigParameters(leaks)).state
        assert abs(state.mass_flow_a) < 1e-12
        assert abs(state.mass_flow_b) < 1e-12
        assert state.pressure_a < sound.pressure_a - 1e3
        assert AMBIENT < state.pressure_a < sound.pressure_a
        assert AMBIENT < state.pressure_b <= sound.pressure_b


def test_a_leak_across_the_piston_without_any_other_leaves_them_alike() -> None:
    """Chambers that settle alike have nothing to exchange."""
    state = Rig(RigParameters({"leak.across": 1e-6})).state
    assert state.pressure_a == pytest.approx(Rig().state.pressure_a, abs=1e-3)


def test_derivatives_by_both_pressures() -> None:
    """Each chamber's rate by its own pressure and by the other's, against central differences."""
    leaks = {"leak.across": 3e-7, "leak.a": 1e-7, "leak.b": 2e-7}
    plant = Plant.of(RigParameters(leaks))
    lands = openings(plant, 6.0)

    def both_rates(pressure_a: float, pressure_b: float) -> np.ndarray:
        state = Motion(0.07, 0.2, pressure_a, pressure_b)
        a, b = pressure_rates(plant, state, inflows(plant, lands, state), 0.2)
        return np.array([a.rate, b.rate])

    for one, two in np.random.default_rng(2).uniform(1.1e5, 6e5, (40, 2)).tolist():
        state = Motion(0.07, 0.2, one, two)
        a, b = pressure_rates(plant, state, inflows(plant, lands, state), 0.2)
        by_a = (both_rates(one + 5.0, two) - both_rates(one - 5.0, two)) / 10.0
        by_b = (both_rates(one, two + 5.0) - both_rates(one, two - 5.0)) / 10.0
        assert [a.by_pressure, b.by_other] == pytest.approx(by_a.tolist(), rel=1e-4, abs=1e-4)
        assert [a.by_other, b.by_pressure] == pytest.approx(by_b.tolist(), rel=1e-4, abs=1e-4)
        assert a.by_other >= 0.0
        assert b.by_other >= 0.0
