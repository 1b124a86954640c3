# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The carriage against its end caps."""

import math

import numpy as np
import pytest

from rodless_base.constants import absolute
from rodless_base.parameter_file import preset_names
from rodless_lab.bare_rigs import bare_rig
from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.end_stop import EndStop, rebound
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

STROKE, AREA, DEAD_VOLUME, KAPPA = 0.2, math.pi / 4.0 * 0.025**2, 15e-6, 1.4

# Bores of SMC's CY3R, m.
BORES = (6e-3, 10e-3, 15e-3, 20e-3, 25e-3, 32e-3, 40e-3, 50e-3, 63e-3)

SLIPPERY = {
    f"friction.{side}.{name}": 0.0
    for side in ("forward", "reverse")
    for name in ("static", "coulomb", "viscous")
}


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
@pytest.mark.parametrize("voltage", [10.0, 0.0])
def test_carriage_comes_to_rest_on_the_cap(form: str, voltage: float) -> None:
    """Pushed with all the supply has, it rests at the very end of the stroke."""
    rig = Rig(RigParameters({"friction.form": form}))
    rig.reset(0.1)
    state = rig.advance(voltage, 20.0)
    assert state.position == (STROKE if voltage > 5.08 else 0.0)
    assert state.velocity == 0.0
    assert abs(state.force) > 200.0


@pytest.mark.parametrize("preset", preset_names())
@pytest.mark.parametrize("bore", BORES)
def test_every_bore_of_the_catalogue_stays_within_its_stroke(preset: str, bore: float) -> None:
    """A minute at 0 V and one at 10 V with 0.7 MPa: both ends are reached, none is passed.

    The smallest pistons push with less than F_s and stay: 0.7 MPa on 28 mm² is 20 N.
    """
    parameters = RigParameters.preset(preset).with_values(
        {"cylinder.bore": bore, "supply.pressure": absolute(0.7e6)}
    )
    trace = simulate(parameters, np.repeat([0.0, 10.0], 60_000), 1e-3, 0.1)
    for values in trace.columns().values():
        assert np.isfinite(values).all()
    reached = (0.0, STROKE) if 0.7e6 * math.pi / 4.0 * bore**2 > 50.0 else (0.1, 0.1)
    assert (trace.position.min(), trace.position.max()) == reached
    assert trace.pressure_a.min() > 0.0
    assert trace.pressure_b.min() > 0.0


def test_carriage_slammed_end_to_end_strikes_both_caps() -> None:
    """Full voltage back and forth: it arrives fast, rebounds, and never leaves the stroke."""
    voltages = np.tile(np.repeat([10.0, 0.0], 15_000), 2)
    trace = simulate(bare_rig("saturating"), voltages, 1e-4, 0.1)
    assert trace.position.max() == STROKE
    assert trace.position.min() == 0.0
    assert trace.velocity.max() > 0.3
    # Samples just after an impact show the way back at a third of the speed of arrival.
    at_the_top = trace.position > STROKE - 2e-4
    assert trace.velocity[at_the_top].min() < -0.05


def test_a_pressed_carriage_leaves_the_cap_when_the_push_turns() -> None:
    """Held by 10 V at the far cap it stays there; at 0 V it breaks away at 36 N the other way."""
    trace = simulate(RigParameters(), np.repeat([10.0, 0.0], [2000, 5000]), 1e-4, STROKE)
    assert set(trace.position[:2000]) == {STROKE}
    first = int(np.argmax(trace.velocity != 0.0))
    assert trace.force[first - 1] == pytest.approx(-36.0, abs=1.0)
    assert trace.velocity[first] < 0.0


@pytest.mark.parametrize("restitution", [0.0, 0.33, 0.7, 1.0])
def test_free_flight_between_rebounds_by_hand(restitution: float) -> None:
    """Without friction or air, a throw at 2 m/s reaches both caps when x = v t says, at e of v.

    From 0.05 m to the far cap 0.15 m at 2 m/s: 75 ms; back over 0.2 m at e · 2 m/s. The little air
    left, 1 mPa, is not felt.
    """
    plant = Plant.of(
        RigParameters({"valve.gap_height": 0.0, "end_stop.restitution": restitution, **SLIPPERY})
    )
    lands = openings(plant, 5.08)
    thrown = Motion(0.05, 2.0, 1e-3, 1e-3)
    before, _ = advance(plant, lands, thrown, 0.0749, 1.0)
    assert before.position == pytest.approx(0.05 + 2.0 * 0.0749, abs=1e-6)
    after, _ = advance(plant, lands, thrown, 0.0751, 1.0)
    assert after.velocity == pytest.approx(-2.0 * restitution, abs=1e-4)
    assert after.position == pytest.approx(STROKE - 2.0 * restitution * 1e-4, abs=1e-7)
    if restitution > 0.5:
        time = 0.075 + STROKE / (2.0 * restitution) + 0.01
        back, _ = advance(plant, lands, thrown, time, 1.0)
        assert back.velocity == pytest.approx(2.0 * restitution**2, abs=1e-4)
        assert back.position == pytest.approx(0.01 * 2.0 * restitution**2, abs=2e-6)


def energy(state: Motion) -> float:
    """Energy in J of a carriage of 1 kg and of the air in sealed chambers, P·V/(κ-1)."""
    air = state.pressure_a * (DEAD_VOLUME + AREA * state.position)
    air += state.pressure_b * (DEAD_VOLUME + AREA * (STROKE - state.position))
    return 0.5 * state.velocity**2 + air / (KAPPA - 1.0)


@pytest.mark.parametrize("velocity", [3.0, -1.5])
def test_elastic_rebounds_keep_their_energy(velocity: float) -> None:
    """With e = 1, no friction and equal pressures nothing takes energy: 2 s change < 0.1 % of it.

    That is of ½ m v², which is far less than the air's.
    """
    plant = Plant.of(
        RigParameters({"valve.gap_height": 0.0, "end_stop.restitution": 1.0, **SLIPPERY})
    )
    lands = openings(plant, 5.08)
    start = state = Motion(0.1, velocity, 2e4, 2e4)
    speeds = []
    for _ in range(2000):
        state, fault = advance(plant, lands, state, 1e-3, 1.0)
        assert fault == 0
        assert abs(energy(state) - energy(start)) < 1e-3 * 0.5 * velocity**2
        speeds.append(state.velocity)
    # It has struck caps: swinging on its air alone it would turn more slowly.
    assert np.count_nonzero(np.diff(np.sign(speeds))) > 8


def test_a_rebound_keeps_its_share_of_the_speed_or_rests() -> None:
    """-e v by hand; a rebound too slow to see is none."""
    assert rebound(EndStop(0.25), 0.8) == -0.2
    assert rebound(EndStop(0.25), -0.8) == 0.2
    assert rebound(EndStop(1.0), 1e-5) == 0.0
    assert rebound(EndStop(0.0), 3.0) == 0.0


def test_the_default_is_that_of_a_damped_spring() -> None:
    """2e5 N/m and 300 N·s/m under 1 kg leave 0.33 of the speed: m x'' + c x' + k x = 0 solved.

    x = e^(-σt) sin(ωt)/ω leaves contact at t = π/ω with velocity -e^(-σπ/ω).
    """
    decay = 300.0 / 2.0
    frequency = math.sqrt(2e5 - decay**2)
    kept = math.exp(-decay * math.pi / frequency)
    assert RigParameters()["end_stop.restitution"] == pytest.approx(kept, abs=0.005)
