"""The compiled plant against a stiff solver on equations written anew from the paper.

Nothing here calls the plant's equations: the formulas below are a second reading of eqs.
(1)-(31) with the corrections of the errata, in other forms where there are any (nozzle flow from
energy and density, slit flow from mean pressure, and for chambers with temperatures their mass and
internal energy as states), solved by scipy's Radau at 1e-10 with stick, slip and end caps as
events.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from rodless_sim import RigParameters, simulate

KAPPA, R, T_S, MU, B_CRITICAL = 1.4, 287.05, 297.0, 1.83e-5, 0.528
P_E, CLOSED, CENTRE = 101325.0, 5.08, 5.2416
T_E, T_W, H_WALL = 293.15, 293.15, 50.0
C_V = R / (KAPPA - 1)
MASS, BORE, STROKE, DEAD_VOLUME = 1.0, 0.025, 0.2, 15e-6
AREA = math.pi * BORE**2 / 4.0
PERIOD = 1e-3

Array = npt.NDArray[np.float64]
# Of the pressures on both sides and the temperature upstream.
Flow = Callable[[float, float, float], float]


class Case(NamedTuple):
    """A run: which rig, from where, and the voltages with their durations."""

    assembly: str
    form: str
    supply: float
    start: float
    voltages: tuple[tuple[float, float], ...]
    heated: bool = False


def curve(voltage: float) -> float:
    """S of eq. (5) in m²."""
    return 1e-6 * sum(
        amplitude * math.sin(frequency * voltage + phase)
        for amplitude, frequency, phase in (
            (2.108, 0.2636, 0.1742),
            (2.012, 0.4851, 2.157),
            (-0.0933, 1.331, 0.9104),
        )
    )


def coefficient(volts: float) -> float:
    """C_v of eq. (25) at a distance in volts from closed."""
    powers = (1.132, -0.006917, -0.0339, 0.02509, -0.006486, 0.0004983)
    return sum(k * min(abs(volts), 5.0) ** n for n, k in enumerate(powers))


def nozzle(area: float) -> Flow:
    """Isentropic flow: throat density times the speed the enthalpy drop gives, straight at r≈1."""

    def flow(p1: float, p2: float, t: float) -> float:
        if p2 > p1:
            return -flow(p2, p1, t)
        throat = min(p2 / p1, 0.999)
        if throat < B_CRITICAL:
            throat = (2 / (KAPPA + 1)) ** (KAPPA / (KAPPA - 1))
        density = p1 / (R * t) * throat ** (1 / KAPPA)
        enthalpy = KAPPA / (KAPPA - 1) * R * t * (1 - throat ** ((KAPPA - 1) / KAPPA))
        return area * density * math.sqrt(2 * enthalpy) * min(1000 * (1 - p2 / p1), 1.0)

    return flow


def slit(height: float, length: float) -> Flow:
    """Plane flow w h³/(12 μ L) Δp at the density of the mean pressure, which is exact."""
    factor = math.pi * 6e-3 * height**3 / (12 * MU * length)
    return lambda p1, p2, t: factor * (p1 - p2) * (p1 + p2) / 2 / (R * t)


def slit_printed(length: float) -> Flow:
    """Eqs. (15), (16), (21), (22): density of the far end, height of eq. (3)."""
    factor = math.pi * 6e-3 * (6.023e-3 - 6e-3) ** 3 / (96 * MU * length * R)
    return lambda p1, p2, t: factor * p2 * (p1 - p2) / t


def edges(assembly: str, voltage: float) -> tuple[Flow, Flow]:
    """The opening and the closing edge of a port."""
    volts = voltage - CLOSED
    if assembly == "printed":
        x_v = 0.00021485 * voltage - 0.00108499
        length = 2e-3 + (x_v if volts >= 0 else -x_v)
        return nozzle(1.132 * curve(voltage)), slit_printed(length)
    orifice = nozzle(coefficient(volts) * max(curve(CENTRE + volts) - curve(CENTRE), 0.0))
    beside = slit(6e-6, 2e-3)
    fade = math.exp(-((volts / 0.2) ** 2))
    closing = slit(6e-6, 2e-3 + 0.00021485 * abs(volts))
    return lambda p1, p2, t: orifice(p1, p2, t) + fade * beside(p1, p2, t), closing


def chambers(case: Case, voltage: float) -> tuple[Callable[[float], float], ...]:
    """Mass flow into A and into B, each as a function of that chamber's pressure."""
    opening, closing = edges(case.assembly, voltage)
    toward_a, toward_b = (opening, closing) if voltage >= CLOSED else (closing, opening)
    return (
        lambda p: toward_a(case.supply, p, T_S) - toward_b(p, P_E, T_S),
        lambda p: toward_b(case.supply, p, T_S) - toward_a(p, P_E, T_S),
    )


def warm_chambers(
    case: Case, voltage: float
) -> tuple[Callable[[float, float], tuple[float, float]], ...]:
    """Mass flow (kg/s) and enthalpy flow (W) into A and into B, by pressure and temperature."""
    opening, closing = edges(case.assembly, voltage)
    toward_a, toward_b = (opening, closing) if voltage >= CLOSED else (closing, opening)

    def net(inlet: Flow, outlet: Flow, p: float, t: float) -> tuple[float, float]:
        source, drain = T_S if case.supply >= p else t, t if p >= P_E else T_E
        inward, outward = inlet(case.supply, p, source), outlet(p, P_E, drain)
        return inward - outward, (C_V + R) * (source * inward - drain * outward)

    return (lambda p, t: net(toward_a, toward_b, p, t), lambda p, t: net(toward_b, toward_a, p, t))


def volumes(y: float) -> tuple[float, float]:
    """Of A and B at position ``y``."""
    return DEAD_VOLUME + AREA * y, DEAD_VOLUME + AREA * (STROKE - y)


def gas(state: Array, y: float) -> list[tuple[float, float]]:
    """Pressure and temperature of A and B from their masses and internal energies."""
    (m_a, u_a, m_b, u_b), (v_a, v_b) = state, volumes(y)
    return [((KAPPA - 1) * u_a / v_a, u_a / m_a / C_V), ((KAPPA - 1) * u_b / v_b, u_b / m_b / C_V)]


def heated_rates(case: Case, voltage: float) -> Callable[[Array, float], list[float]]:
    """First law and mass of both chambers: dm/dt, dU/dt of A, then of B.

    The wall is that of a bore as long as the whole volume, with both of its ends.
    """
    inlets = warm_chambers(case, voltage)

    def rate(s: Array, slide: float) -> list[float]:
        found: list[float] = []
        for sign, volume, inlet, (p, t) in zip(
            (1, -1), volumes(s[0]), inlets, gas(s[2:], s[0]), strict=True
        ):
            mass_flow, enthalpy_flow = inlet(p, t)
            wall = math.pi * BORE * (volume / AREA) + 2 * AREA
            heat = H_WALL * wall * (T_W - t)
            found += [mass_flow, enthalpy_flow - sign * p * AREA * slide + heat]
        return found

    return rate


def friction(form: str, speed: float, sign: int) -> float:
    """Eq. (29), magnitude: Table 2 forward or reverse, its viscous term bent or not."""
    f_s, f_c, v_s, b = (29.0, 12.0, 1.3e-3, 4500.0) if sign > 0 else (36.0, 12.5, 3.6e-3, 4800.0)
    drag = b * speed
    if form == "saturating":
        drag = 80.0 * speed + (b - 80.0) * 5e-3 * (1 - math.exp(-speed / 5e-3))
    return f_c + (f_s - f_c) * math.exp(-((speed / v_s) ** 2)) + drag


def push(state: Array) -> float:
    """F_e: the air's force."""
    if len(state) == 4:
        return float(AREA * (state[2] - state[3]))
    (p_a, _), (p_b, _) = gas(state[2:], state[0])
    return float(AREA * (p_a - p_b))


def beyond_breakaway(state: Array) -> float:
    """By how many newtons the push exceeds F_s in its own direction; a cap holds any push."""
    forward = -math.inf if state[0] >= STROKE else push(state) - 29.0
    reverse = -math.inf if state[0] <= 0.0 else -push(state) - 36.0
    return max(forward, reverse)


def settled(case: Case) -> Array:
    """The state at rest in which nothing changes, the valve closed."""
    if not case.heated:
        a, b = chambers(case, CLOSED)
        return np.array([case.start, 0.0, brentq(a, P_E, case.supply), brentq(b, P_E, case.supply)])
    rate = heated_rates(case, CLOSED)

    def still(unknown: Array) -> Array:
        return np.array(rate(np.concatenate([[case.start, 0.0], scale * unknown]), 0.0)) / scale

    # Begun with air at 4 bar and the wall's temperature.
    scale = np.array(
        [x for v in volumes(case.start) for x in (4e5 * v / (R * T_W), 4e5 * v / (KAPPA - 1))]
    )
    found = fsolve(still, np.ones(4), xtol=1e-13)
    return np.concatenate([[case.start, 0.0], scale * found])


def solve(case: Case) -> Array:
    """Position, velocity, pressures and temperatures if any at every millisecond, settled first."""
    state = settled(case)
    rows = [state[:, None]]
    for voltage, duration in case.voltages:
        piece = hold(case, voltage, duration, state)
        rows.append(piece)
        state = piece[:, -1]
    found = np.hstack(rows)
    if case.heated:
        for column in found.T:
            (p_a, t_a), (p_b, t_b) = gas(column[2:], column[0])
            column[2:] = p_a, p_b, t_a, t_b
    return found


def hold(case: Case, voltage: float, duration: float, state: Array) -> Array:
    """Solve from stick to slip to stick while one voltage is held."""
    samples = np.arange(1, round(duration / PERIOD) + 1) * PERIOD
    flow_a, flow_b = chambers(case, voltage)
    air_rates = heated_rates(case, voltage)
    rows, now = [], 0.0
    while now < samples[-1]:
        sign = 0
        if state[1] != 0.0 or beyond_breakaway(state) > -1e-9:
            sign = int(np.sign(state[1]) or np.sign(push(state)))

        def rate(_: float, s: Array, sign: int = sign) -> list[float]:
            slide = s[1] if sign else 0.0
            force = push(s) - sign * friction(case.form, s[1] * sign, sign) if sign else 0.0
            if case.heated:
                return [slide, force / MASS, *air_rates(s, slide)]
            y, _, p_a, p_b = s
            return [
                slide,
                force / MASS,
                KAPPA * (R * T_S * flow_a(p_a) - p_a * AREA * slide) / (DEAD_VOLUME + AREA * y),
                KAPPA
                * (R * T_S * flow_b(p_b) + p_b * AREA * slide)
                / (DEAD_VOLUME + AREA * (STROKE - y)),
            ]

        def change(_: float, s: Array, sign: int = sign) -> float:
            return float(s[1]) * sign if sign else -beyond_breakaway(s)

        def strike(_: float, s: Array, sign: int = sign) -> float:
            return float(STROKE - s[0] if sign > 0 else s[0]) if sign else 1.0

        for event in (change, strike):
            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        run = solve_ivp(
            rate,
            (now, samples[-1]),
            state,
            method="Radau",
            rtol=1e-10,
            atol=[1e-13, 1e-12, *([1e-15, 1e-9] * 2 if case.heated else [1e-5] * 2)],
            events=(change, strike),
            dense_output=True,
        )
        within = samples[(samples > now) & (samples <= run.t[-1])]
        if within.size:
            rows.append(run.sol(within))
        now, state = run.t[-1], run.y[:, -1]
        if len(run.t_events[1]):
            state[0] = STROKE if sign > 0 else 0.0
            state[1] *= -0.33
            if abs(state[1]) < 3e-5:
                state[1] = 0.0
        elif run.status == 1 and sign:
            state[1] = 0.0
    return np.hstack(rows)


CASES = {
    "forward from rest": Case("reconciled", "stribeck", 621325.0, 0.05, ((6.0, 0.6),)),
    "reverse from rest": Case("reconciled", "stribeck", 621325.0, 0.15, ((4.0, 0.6),)),
    "forward, saturating": Case("reconciled", "saturating", 501325.0, 0.03, ((5.6, 0.8),)),
    "reverse, saturating": Case("reconciled", "saturating", 601325.0, 0.18, ((4.395, 0.8),)),
    "there, stop and back": Case(
        "reconciled", "stribeck", 621325.0, 0.06, ((6.0, 0.3), (5.08, 0.3), (3.8, 0.5))
    ),
    "there, stop and back, saturating": Case(
        "reconciled", "saturating", 621325.0, 0.06, ((5.8, 0.3), (5.08, 0.3), (4.2, 0.5))
    ),
    "stick-slip": Case("reconciled", "stribeck", 601325.0, 0.02, ((5.24, 12.0),)),
    "stick-slip, saturating": Case("reconciled", "saturating", 601325.0, 0.02, ((5.24, 12.0),)),
    "stick-slip in reverse": Case("reconciled", "saturating", 621325.0, 0.17, ((4.84, 6.0),)),
    "into the cap": Case("reconciled", "saturating", 621325.0, 0.03, ((3.5, 1.0),)),
    "printed assembly": Case("printed", "stribeck", 601325.0, 0.1, ((5.08, 0.5), (6.5, 0.5))),
    "heated": Case(
        "reconciled", "stribeck", 621325.0, 0.06, ((6.0, 0.3), (5.08, 0.3), (3.8, 0.5)), heated=True
    ),
    "heated, saturating": Case(
        "reconciled", "saturating", 621325.0, 0.06, ((5.8, 0.3), (5.08, 0.2), (4.2, 0.5)), True
    ),
    "heated, stick-slip": Case("reconciled", "saturating", 621325.0, 0.17, ((4.8, 3.0),), True),
    "heated, into the cap": Case("reconciled", "saturating", 621325.0, 0.03, ((3.5, 1.0),), True),
    "heated, printed assembly": Case(
        "printed", "stribeck", 601325.0, 0.1, ((5.08, 0.5), (6.5, 0.5)), True
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_compiled_plant_agrees_with_a_stiff_solver(case: Case) -> None:
    """Sample by sample, position agrees within 0.5 µm, pressures within 5 Pa, air within 5 mK."""
    parameters = RigParameters(
        {
            "valve.assembly": case.assembly,
            "friction.form": case.form,
            "supply.pressure": case.supply,
            "chambers.thermodynamics": "energy_balance" if case.heated else "adiabatic",
        }
    )
    voltages = np.concatenate([np.full(round(t / PERIOD), u) for u, t in case.voltages])
    trace = simulate(parameters, voltages, PERIOD, case.start)
    position, _, pressure_a, pressure_b, *temperatures = solve(case)
    assert np.abs(trace.position - position).max() < 5e-7
    assert np.abs(trace.pressure_a - pressure_a).max() < 5.0
    assert np.abs(trace.pressure_b - pressure_b).max() < 5.0
    if case.heated:
        assert np.abs(trace.temperature_a - temperatures[0]).max() < 5e-3
        assert np.abs(trace.temperature_b - temperatures[1]).max() < 5e-3
        assert np.ptp(temperatures[0]) > 1.0
    assert np.ptp(position) > 1e-3


@pytest.mark.parametrize("name", ["there, stop and back", "stick-slip", "stick-slip, saturating"])
def test_the_comparison_includes_stopping(name: str) -> None:
    """The cases meant to stop do stop in the stiff solution, after moving, and stay at rest."""
    velocity = solve(CASES[name])[1]
    moving = np.flatnonzero(velocity)
    assert np.any(velocity[moving[0] :] == 0.0)
