# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Stick, slip and motion of the carriage in time."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from rodless_sim import Rig, RigParameters, Trace, simulate
from rodless_sim.physics.equations import inflows, sliding_rates
from rodless_sim.physics.integrator import sliding_step
from rodless_sim.physics.motion import advance
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion

STEP = 20e-6
FORMS = ("stribeck", "saturating")
PAPER_FRICTION_RUN = {"supply.pressure": 0.5e6 + 101325.0}


def slips(trace: Trace) -> int:
    """How many times the carriage leaves rest."""
    moving = (trace.velocity != 0.0).astype(int)
    return int(np.count_nonzero(np.diff(moving) == 1))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("voltage", "breakaway"), [(6.0, 29.0), (5.5, 29.0), (4.0, 36.0), (4.395, 36.0)]
)
def test_carriage_breaks_away_when_the_force_crosses_the_static_limit(
    form: str, voltage: float, breakaway: float
) -> None:
    """The first motion comes within one sample of the instant at which |F_e| passes F_s.

    That instant is read from the same rig with its carriage locked, whose force is the same
    until the free one moves.
    """
    parameters = RigParameters({"friction.form": form})
    voltages = np.full(40_000, voltage)
    free = simulate(parameters, voltages, STEP, 0.1)
    held = simulate(parameters.with_values({"cylinder.locked": True}), voltages, STEP, 0.1)
    crossing = float(np.interp(breakaway, np.abs(held.force), held.time))
    first = int(np.argmax(free.velocity != 0.0))
    assert first > 0
    assert 0.0 <= free.time[first] - crossing <= STEP * (1.0 + 1e-9)
    assert np.sign(free.velocity[first]) == np.sign(voltage - 5.08)


@pytest.mark.parametrize("voltage", [5.15, 5.02, 5.08])
def test_a_stuck_carriage_does_not_creep(voltage: float) -> None:
    """Pushed for a minute with less than F_s it stays where it was, to the last bit."""
    rig = Rig()
    rig.reset(0.1)
    for _ in range(60):
        state = rig.advance(voltage, 1.0)
        assert state.position == 0.1
        assert state.velocity == 0.0
    assert abs(state.force) < 29.0
    if voltage != 5.08:
        assert abs(state.force) > 3.0


@pytest.mark.parametrize("form", FORMS)
def test_stick_slip_does_not_chatter(form: str) -> None:
    """Creeping for a minute, the carriage slips about every 2.5 s and never moves backwards.

    One slip and one stop per cycle: chatter would show as many short ones.
    """
    parameters = RigParameters({"friction.form": form, **PAPER_FRICTION_RUN})
    trace = simulate(parameters, np.full(60_000, 5.24), 1e-3, 0.02)
    assert trace.velocity.min() == 0.0
    assert 5 < slips(trace) < 60
    edges = np.flatnonzero(np.diff((trace.velocity != 0.0).astype(int)))
    assert np.diff(edges).min() > 100


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("voltage", "position"), [(5.24, 0.02), (5.6, 0.02), (4.8, 0.18)])
def test_capture_velocity_does_not_matter(form: str, voltage: float, position: float) -> None:
    """α of 10, 1 and 0 µm/s give the same motion within a nanometre, stick-slip included."""
    traces = [
        simulate(
            RigParameters({"friction.form": form, "friction.capture_velocity": capture}),
            np.full(15_000, voltage),
            1e-3,
            position,
        )
        for capture in (1e-5, 1e-6, 0.0)
    ]
    for other in traces[1:]:
        assert np.abs(other.position - traces[0].position).max() < 1e-9


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "voltages",
    [(5.24,) * 12, (5.6, 5.6, 5.08, 4.5, 4.5), (4.8, 4.8, 4.8, 4.8), (0.0, 10.0, 0.0, 10.0)],
    ids=["stick-slip", "there and back", "creep in reverse", "slammed"],
)
def test_a_thousandth_of_the_tolerance_changes_nothing_that_shows(
    form: str, voltages: tuple[float, ...]
) -> None:
    """Positions stay within 0.5 µm of each other, through stick and slip."""
    coarse, fine = (
        simulate(
            RigParameters({"friction.form": form, "time.tolerance": tolerance}),
            np.repeat(voltages, 1000),
            1e-3,
            0.1,
        )
        for tolerance in (1.0, 1e-3)
    )
    assert slips(fine) >= 1
    assert np.abs(coarse.position - fine.position).max() < 5e-7


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("voltage", [6.0, 4.2])
def test_integration_is_of_third_order(form: str, voltage: float) -> None:
    """On smooth sliding, half the step makes an eighth of the error: observed order 3 ± 0.15."""
    parameters = RigParameters({"friction.form": form})
    plant = Plant.of(parameters)
    rig = Rig(parameters)
    rig.reset(0.1)
    rig.advance(voltage, 0.3)
    start = rig.motion
    assert abs(start.velocity) > 0.01
    lands, direction = openings(plant, voltage), 1 if voltage > 5.08 else -1
    ends = []
    for steps in (20, 40, 80):
        state, step = start, 0.02 / steps
        for _ in range(steps):
            first = sliding_rates(plant, state, inflows(plant, lands, state), direction)
            state, _ = sliding_step(plant, lands, state, direction, first, step)
        ends.append(np.array(state))
    coarse, middle, fine = ends
    order = np.log2(np.abs(coarse - middle) / np.abs(middle - fine))
    assert order[0] == pytest.approx(3.0, abs=0.15)
    assert order[2] == pytest.approx(3.0, abs=0.15)
    assert order[3] == pytest.approx(3.0, abs=0.15)


def friction_by_hand(speed: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Forward saturating friction of Table 2 in N."""
    drop = 17.0 * np.exp(-((speed / 1.3e-3) ** 2))
    return 12.0 + drop + 80.0 * speed + 4420.0 * 5e-3 * (1.0 - np.exp(-speed / 5e-3))


def test_newtons_law_holds_along_a_trace() -> None:
    """Eq. (31) as used: m dv/dt = A (P_a - P_b) - F_f, with dv/dt taken from the velocities."""
    parameters = RigParameters({"friction.form": "saturating", "cylinder.moving_mass": 3.0})
    trace = simulate(parameters, np.full(15_000, 7.0), STEP, 0.05)
    sliding = slice(int(np.argmax(trace.velocity > 0.02)), None)
    acceleration = np.gradient(trace.velocity, STEP)[sliding]
    balance = trace.force[sliding] - friction_by_hand(trace.velocity[sliding])
    assert np.abs(acceleration).max() > 1.0
    assert np.abs(3.0 * acceleration - balance)[1:-1].max() < 0.02


@pytest.mark.parametrize(("voltage", "sign"), [(5.6, 1.0), (4.5, -1.0)])
def test_steady_sliding_balances_force_and_friction(voltage: float, sign: float) -> None:
    """Eq. (30): in slow even motion the air's force is F_c + B v of Table 2, within 0.5 N."""
    rig = Rig()
    rig.reset(0.1)
    state = rig.advance(voltage, 1.5)
    coulomb, viscous = (12.0, 4500.0) if sign > 0 else (12.5, 4800.0)
    speed = sign * state.velocity
    assert speed > 0.012
    assert sign * state.force == pytest.approx(coulomb + viscous * speed, abs=0.5)


def test_a_thrown_carriage_stops_where_friction_takes_its_energy() -> None:
    """With even air on both sides it slides the distance that ∫ F_f dx = ½ m v² gives.

    For F = F_c (no drop, no viscosity) and v = 0.05 m/s, ½·1·0.0025/12 = 104.17 µm.
    The air is 4000 N/m stiff at 100 kPa: ½ m v² = F_c x + ½ k x², k = 2 κ P A²/V.
    """
    dry = {
        f"friction.{side}.{name}": value
        for side in ("forward", "reverse")
        for name, value in (("static", 12.0), ("coulomb", 12.0), ("viscous", 0.0))
    }
    plant = Plant.of(RigParameters({"valve.gap_height": 0.0, **dry}))
    state = advance(plant, openings(plant, 5.08), Motion(0.1, 0.05, 1e5, 1e5), 0.02, 1.0)[0]
    area = math.pi / 4.0 * 0.025**2
    spring = 2.0 * 1.4 * 1e5 * area**2 / (15e-6 + area * 0.1)
    distance = (math.sqrt(12.0**2 + spring * 0.05**2) - 12.0) / spring
    assert state.velocity == 0.0
    assert state.position - 0.1 == pytest.approx(distance, rel=1e-3)
