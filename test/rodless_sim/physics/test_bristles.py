# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""LuGre friction against closed forms, and with magnets against a stiff solver.

The mechanics of the stiff solution are written here anew; what flows through the valve is the
plant's own, which test_against_radau.py checks.
"""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp

from rodless_base.parameters import ParameterError
from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics.bristles import Bristles, contact
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.friction import Friction
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled import settled_pressures
from rodless_sim.physics.state import Motion

Array = npt.NDArray[np.float64]

STIFFNESS, DAMPING, DAMPING_SPEED = 2e5, 600.0, 0.01
LUGRE = {"friction.dynamics": "lugre"}
MAGNETIC = {"coupling.kind": "magnetic"}
AREA, STROKE, DEAD_VOLUME = math.pi * 0.025**2 / 4.0, 0.2, 15e-6
SLOW = 1e-7  # m/s

plain = getattr(contact, "py_func", contact)


def drag(velocity: float, deflection: float, **values: object) -> tuple[float, float]:
    """Force (N) and rate of the deflection (m/s) by the plant's own function."""
    parameters = RigParameters({**LUGRE, **values})
    found = plain(Bristles.of(parameters), Friction.of(parameters), velocity, deflection)
    return float(found.force), float(found.rate)


def pulled(distances: Array, direction: int, start: float) -> Array:
    """The deflection over a slow motion by ``distances`` (m), from a deflection ``start``."""
    run = solve_ivp(
        lambda _, z: [drag(direction * SLOW, z[0])[1] / SLOW],
        (0.0, distances[-1]),
        [start],
        t_eval=distances,
        rtol=1e-9,
        atol=1e-15,
    )
    return np.asarray(run.y[0])


def test_presliding_is_an_exponential() -> None:
    """Pulled slowly from rest, z = F_s/σ₀ (1 − e^(−σ₀ x/F_s)): a spring first, then it slips."""
    for direction, static in ((1, 29.0), (-1, 36.0)):
        x = np.linspace(1e-6, 1e-3, 40)
        expected = static / STIFFNESS * (1.0 - np.exp(-STIFFNESS * x / static))
        assert pulled(x, direction, 0.0) == pytest.approx(direction * expected, rel=1e-4)


def test_hysteresis_is_that_of_two_exponentials() -> None:
    """Pulled forth and back by less than it slips, the force comes back on another branch."""
    x = np.linspace(1e-6, 1e-4, 30)
    forth = pulled(x, 1, 0.0)
    back = pulled(x, -1, float(forth[-1]))
    limit = 36.0 / STIFFNESS
    expected = -limit + (forth[-1] + limit) * np.exp(-STIFFNESS * x / 36.0)
    assert back == pytest.approx(expected, rel=1e-4)
    # It holds back less than it was pulled by, and the work that is lost is that of the loop.
    assert STIFFNESS * forth[-1] > 5.0
    assert back[-1] < -0.1 * forth[-1]


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
def test_steady_sliding_is_equation_29(form: str) -> None:
    """Once the bristles have settled, friction is what the form gives at that speed."""
    values: dict[str, object] = {"friction.form": form}
    for velocity in (1e-4, 2e-3, 0.05, 0.4, -1e-3, -0.3):
        speed = abs(velocity)
        forward = velocity > 0.0
        f_s, f_c, v_s, b = (29.0, 12.0, 1.3e-3, 4500.0) if forward else (36.0, 12.5, 3.6e-3, 4800.0)
        dry = f_c + (f_s - f_c) * math.exp(-((speed / v_s) ** 2))
        viscous = b * speed
        if form == "saturating":
            viscous = 80.0 * speed + (b - 80.0) * 5e-3 * (1.0 - math.exp(-speed / 5e-3))
        deflection = math.copysign(dry / STIFFNESS, velocity)
        force, rate = drag(velocity, deflection, **values)
        assert rate == pytest.approx(0.0, abs=1e-12)
        assert force == pytest.approx(math.copysign(dry + viscous, velocity), rel=1e-12)


def test_without_dry_friction_the_bristles_carry_nothing() -> None:
    """No division by a force of zero: they slip at once."""
    names = [f"friction.{side}.{what}" for side in ("forward", "reverse") for what in FORCES]
    force, rate = drag(0.1, 0.0, **dict.fromkeys(names, 0.0))
    assert math.isfinite(force)
    assert rate == pytest.approx(0.1)


FORCES = ("static", "coulomb")


def friction(velocity: float, deflection: float) -> tuple[float, float]:
    """LuGre on Table 2, written anew: force and rate of the deflection."""
    f_s, f_c, v_s, b = (29.0, 12.0, 1.3e-3, 4500.0) if velocity >= 0 else (36.0, 12.5, 3.6e-3, 4800)
    g = f_c + (f_s - f_c) * math.exp(-((velocity / v_s) ** 2))
    rate = velocity - STIFFNESS * abs(velocity) / g * deflection
    sigma = DAMPING * math.exp(-((velocity / DAMPING_SPEED) ** 2))
    return STIFFNESS * deflection + sigma * rate + b * velocity, rate


def pressure_rates(flows: tuple[float, float], air: Array, place: float, speed: float) -> Array:
    """Eq. (26): κ/V (R T ṁ − P dV/dt)."""
    heat = 287.05 * 297.0
    v_a, v_b = DEAD_VOLUME + AREA * place, DEAD_VOLUME + AREA * (STROKE - place)
    return np.array(
        [
            1.4 / v_a * (heat * flows[0] - air[0] * AREA * speed),
            1.4 / v_b * (heat * flows[1] + air[1] * AREA * speed),
        ]
    )


Rates = Callable[[Array, tuple[float, float]], Array]


def rigid(s: Array, flows: tuple[float, float]) -> Array:
    """x, v, P_a, P_b, z: one mass of 1 kg."""
    force, rate = friction(s[1], s[4])
    push = AREA * (s[2] - s[3])
    return np.array([s[1], push - force, *pressure_rates(flows, s[2:4], s[0], s[1]), rate])


def magnetic(s: Array, flows: tuple[float, float]) -> Array:
    """x, v, P_a, P_b, z of the carriage, and x, v, z of the piston: 0.65 and 0.35 kg."""
    lag, rate = s[5] - s[0], s[6] - s[1]
    link = 363.0 * math.sin(math.pi * lag / 6e-3) + 20.0 * rate
    force, slip = friction(s[1], s[4])
    force_p, slip_p = friction(s[6], s[7])
    return np.array(
        [
            s[1],
            (link - 0.3 * force) / 0.65,
            *pressure_rates(flows, s[2:4], s[5], s[6]),
            slip,
            s[6],
            (AREA * (s[2] - s[3]) - link - 0.7 * force_p) / 0.35,
            slip_p,
        ]
    )


def by_radau(rates: Rates, parts: tuple[tuple[float, float], ...], start: float) -> Array:
    """The states at every millisecond while the valve has each voltage (V) for a while (s)."""
    plant = Plant.of(RigParameters())
    pressures = settled_pressures(plant, plant.valve.closed_voltage)
    state = np.array([start, 0.0, *pressures, 0.0])
    if rates is magnetic:
        state = np.concatenate([state, [start, 0.0, 0.0]])
    rows, valve_flows = [state[:, None]], getattr(inflows, "py_func", inflows)
    for voltage, duration in parts:
        lands = openings(plant, voltage)

        def rate(_: float, s: Array, lands: object = lands) -> Array:
            a, b = valve_flows(plant, lands, Motion(s[0], s[1], s[2], s[3]))
            return rates(s, (a.mass_flow, b.mass_flow))

        absolute = [1e-12, 1e-11, 1e-4, 1e-4, 1e-14, 1e-12, 1e-11, 1e-14][: state.size]
        run = solve_ivp(
            rate,
            (0.0, duration),
            state,
            method="Radau",
            rtol=1e-9,
            atol=absolute,
            max_step=1e-3,
            t_eval=np.arange(1, round(duration / 1e-3) + 1) * 1e-3,
        )
        assert run.success
        rows.append(run.y)
        state = run.y[:, -1]
    return np.hstack(rows)


@pytest.mark.parametrize("rates", [rigid, magnetic])
def test_against_radau(rates: Rates) -> None:
    """There, stop and back: within 5 µm and 100 Pa of equations written apart."""
    parts = ((6.5, 0.1), (5.08, 0.05), (3.8, 0.1))
    values = {**LUGRE, **(MAGNETIC if rates is magnetic else {})}
    voltages = [voltage for voltage, duration in parts for _ in range(round(duration / 1e-3))]
    run = simulate(RigParameters(values), voltages, 1e-3, position=0.08)
    expected = by_radau(rates, parts, 0.08)
    assert np.ptp(expected[0]) > 1e-3
    assert run.position == pytest.approx(expected[0], abs=5e-6)
    assert run.pressure_a == pytest.approx(expected[2], abs=100.0)
    assert run.pressure_b == pytest.approx(expected[3], abs=100.0)
    assert run.bristle_deflection == pytest.approx(expected[4], abs=1e-6)
    if rates is magnetic:
        assert run.piston_position == pytest.approx(expected[5], abs=5e-6)
        assert run.coupled.min() == 1.0


def test_a_push_below_breakaway_moves_it_a_little_and_lets_it_back() -> None:
    """A push of some newtons deflects the bristles; static friction would hold it exactly."""
    rig = Rig(RigParameters({**LUGRE, "friction.forward.static": 60.0}))
    rig.reset(position=0.1, pressures=(300e3, 300e3 - 20.0 / AREA))
    still = Rig(RigParameters({"friction.forward.static": 60.0}))
    still.reset(position=0.1, pressures=(300e3, 300e3 - 20.0 / AREA))
    moved = rig.advance(5.08, 0.02).position - 0.1
    assert still.advance(5.08, 0.02).position == 0.1
    assert 2e-5 < moved < 60.0 / STIFFNESS


def test_on_a_cap_it_is_held() -> None:
    """Pressed into the cap of chamber A for a second it stays there; then it leaves."""
    rig = Rig(RigParameters(LUGRE))
    assert rig.advance(3.0, 1.0).position == 0.0
    assert rig.advance(8.0, 0.5).position > 1e-2


def test_out_of_range_is_refused() -> None:
    """The text names what is meant."""
    with pytest.raises(ParameterError, match=r"friction\.dynamics"):
        RigParameters({"friction.dynamics": "dahl"})
    with pytest.raises(ParameterError, match=r"friction\.bristle_stiffness"):
        RigParameters({"friction.bristle_stiffness": 0.0})
