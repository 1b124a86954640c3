# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Conservation along motion: the air of each chamber, and the energy of a sealed rig."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from rodless_sim import RigParameters, Trace, simulate
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

KAPPA, GAS, SUPPLY_TEMPERATURE = 1.4, 287.05, 297.0
AREA, STROKE, DEAD_VOLUME = math.pi / 4.0 * 0.025**2, 0.2, 15e-6
STEP = 20e-6
FORMS = ("stribeck", "saturating")

Array = npt.NDArray[np.float64]


def residual(volume: Array, pressure: Array, mass_flow: Array) -> float:
    """Largest relative gap between P·V^κ and its start plus ∫ κ R T_s V^(κ-1) ṁ dt."""
    content = pressure * volume**KAPPA
    inflow = KAPPA * GAS * SUPPLY_TEMPERATURE * volume ** (KAPPA - 1.0) * mass_flow
    gained = np.concatenate([[0.0], np.cumsum(0.5 * (inflow[1:] + inflow[:-1]) * STEP)])
    return float(np.max(np.abs(content - content[0] - gained) / content))


def moving_trace(form: str, voltage: float, position: float) -> Trace:
    parameters = RigParameters({"friction.form": form})
    return simulate(parameters, np.full(20_000, voltage), STEP, position)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("voltage", "position"), [(6.0, 0.05), (4.2, 0.15), (8.5, 0.02)])
def test_chamber_contents_follow_the_air_let_in(form: str, voltage: float, position: float) -> None:
    """Eq. (26) integrated: P·V^κ changes by what flows in, to 1e-6, filling and venting, moving."""
    trace = moving_trace(form, voltage, position)
    assert np.ptp(trace.position) > 4e-3
    volume_a = DEAD_VOLUME + AREA * trace.position
    volume_b = DEAD_VOLUME + AREA * (STROKE - trace.position)
    assert residual(volume_a, trace.pressure_a, trace.mass_flow_a) < 1e-6
    assert residual(volume_b, trace.pressure_b, trace.mass_flow_b) < 1e-6


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("velocity", [0.4, -0.4])
def test_sealed_chambers_keep_pressure_times_volume_to_the_kappa(
    form: str, velocity: float
) -> None:
    """With every opening shut and the carriage thrown, P·V^κ of both chambers stays as it was."""
    plant = Plant.of(RigParameters({"friction.form": form, "valve.gap_height": 0.0}))
    start = state = Motion(0.1, velocity, 4e5, 4e5)
    for _ in range(500):
        state = advance(plant, openings(plant, 5.08), state, 5 * STEP, 1.0)[0]
        volume_a = DEAD_VOLUME + AREA * state.position
        volume_b = DEAD_VOLUME + AREA * (STROKE - state.position)
        middle = DEAD_VOLUME + AREA * 0.1
        assert state.pressure_a * volume_a**KAPPA == pytest.approx(4e5 * middle**KAPPA, rel=1e-7)
        assert state.pressure_b * volume_b**KAPPA == pytest.approx(4e5 * middle**KAPPA, rel=1e-7)
    assert abs(state.position - start.position) > 5e-5


def energy(state: Motion) -> float:
    """Energy of a sealed rig in J: of the carriage, ½ m v², and of the air, P·V/(κ-1)."""
    air = state.pressure_a * (DEAD_VOLUME + AREA * state.position)
    air += state.pressure_b * (DEAD_VOLUME + AREA * (STROKE - state.position))
    return 0.5 * state.velocity**2 + air / (KAPPA - 1.0)


@pytest.mark.parametrize(
    ("position", "velocity"), [(1e-3, -0.5), (0.199, 0.5), (1e-3, -2.0), (0.1, 0.5)]
)
def test_energy_of_a_sealed_rig_never_grows(position: float, velocity: float) -> None:
    """Bouncing off a cap or off its own air, a slippery sealed rig only loses energy.

    The first three throws strike a cap, the last only swings on the air; each loses at least the
    0.5 N of friction over the distance it moved.
    """
    slippery = {
        f"friction.{side}.{name}": value
        for side in ("forward", "reverse")
        for name, value in (("static", 0.5), ("coulomb", 0.5), ("viscous", 0.0))
    }
    plant = Plant.of(RigParameters({"valve.gap_height": 0.0, **slippery}))
    state = Motion(position, velocity, 2e5, 2e5)
    energies, travelled = [energy(state)], 0.0
    for _ in range(10_000):
        before, state = state, advance(plant, openings(plant, 5.08), state, STEP, 1.0)[0]
        energies.append(energy(state))
        travelled += abs(state.position - before.position)
    assert np.max(np.diff(energies)) < 1e-8
    assert energies[0] - energies[-1] > 0.5 * travelled * (1.0 - 1e-3)
