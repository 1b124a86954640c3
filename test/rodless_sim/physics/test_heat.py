# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Chambers with temperatures of their own against closed forms and balances."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from rodless_sim import HeatedState, Rig, RigParameters, State, simulate
from rodless_sim.physics import faults
from rodless_sim.physics.equations import inflows, rates, sliding_rates
from rodless_sim.physics.integrator import GAMMA, eliminated, error_size, solved
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import inflow_a, inflow_b, openings, supply_flow
from rodless_sim.physics.settled import settled_air
from rodless_sim.physics.state import HeatedMotion
from rodless_sim.physics.streams import (
    heated_supply_flow,
    leak_out,
    net_stream,
    stream_into_a,
    stream_into_b,
)

KAPPA, R, T_S, T_E, P_S, P_E = 1.4, 287.05, 297.0, 293.15, 621325.0, 101325.0
C_V, C_P = R / (KAPPA - 1.0), KAPPA * R / (KAPPA - 1.0)
BORE, STROKE, DEAD_VOLUME = 0.025, 0.2, 15e-6
AREA = math.pi / 4.0 * BORE**2
STATES = HeatedMotion._fields
HEATED = {"chambers.thermodynamics": "energy_balance"}
H, T_W = "chambers.heat_transfer_coefficient", "chambers.wall_temperature"
SEALED = {**HEATED, "valve.gap_height": 0.0}
CLOSED = 5.08

Array = npt.NDArray[np.float64]


def volume_a(position: "float | Array") -> "float | Array":
    """Volume of chamber A."""
    return DEAD_VOLUME + AREA * position


def volume_b(position: "float | Array") -> "float | Array":
    """Volume of chamber B."""
    return DEAD_VOLUME + AREA * (STROKE - position)


def wall(volume: float) -> float:
    """The wall of a piece of bore that holds ``volume``, with both of its ends."""
    return math.pi * BORE * volume / AREA + 2.0 * AREA


def slope(function: Callable[[float], float], place: float, width: float) -> float:
    """Central difference of fourth order."""
    near = function(place + width) - function(place - width)
    far = function(place + 2.0 * width) - function(place - 2.0 * width)
    return (8.0 * near - far) / (12.0 * width)


def thrown(values: dict[str, object], velocity: float, temperature: float) -> Rig:
    """A rig with the carriage thrown at ``velocity`` in chambers of 2 bar and ``temperature``."""
    slippery = {
        f"friction.{side}.{name}": 0.5 if name != "viscous" else 0.0
        for side in ("forward", "reverse")
        for name in ("static", "coulomb", "viscous")
    }
    rig = Rig(RigParameters({**SEALED, **slippery, **values}))
    rig.reset(0.1, (2e5, 2e5), (temperature, temperature))
    # No public way throws a carriage.
    rig._motion = rig._motion._replace(velocity=velocity)
    return rig


@pytest.mark.parametrize("velocity", [0.5, -0.5])
def test_without_heat_a_closed_chamber_is_adiabatic(velocity: float) -> None:
    """With h = 0 P V^κ and T V^(κ-1) stay as they were while the carriage swings on the air."""
    rig = thrown({H: 0.0}, velocity, 300.0)
    start = volume_a(0.1)
    travelled = 0.0
    for _ in range(400):
        state = rig.advance(CLOSED, 1e-3)
        travelled = max(travelled, abs(state.position - 0.1))
        for volume, pressure, temperature in (
            (volume_a(state.position), state.pressure_a, state.temperature_a),
            (volume_b(state.position), state.pressure_b, state.temperature_b),
        ):
            ratio = start / volume
            assert pressure == pytest.approx(2e5 * ratio**KAPPA, rel=1e-6)
            assert temperature == pytest.approx(300.0 * ratio ** (KAPPA - 1.0), rel=1e-6)
    assert travelled > 0.01


def test_with_much_heat_a_closed_chamber_is_isothermal() -> None:
    """With h at its greatest P V stays as it was, and the air at the wall's temperature."""
    rig = thrown({H: 1e5, T_W: 310.0}, 0.2, 310.0)
    travelled = 0.0
    for _ in range(200):
        state = rig.advance(CLOSED, 1e-3)
        travelled = max(travelled, abs(state.position - 0.1))
        content = state.pressure_a * volume_a(state.position)
        assert content == pytest.approx(2e5 * volume_a(0.1), rel=2e-3)
        assert state.temperature_a == pytest.approx(310.0, rel=2e-3)
    assert travelled > 4e-3


@pytest.mark.parametrize("position", [0.0, 0.13])
def test_a_closed_chamber_cools_to_its_wall(position: float) -> None:
    """At fixed volume T − T_w decays with τ = m c_v/(h A_w), and P follows T."""
    rig = Rig(RigParameters({**SEALED, "cylinder.locked": True, H: 80.0, T_W: 285.0}))
    rig.reset(position, (4e5, 3e5), (350.0, 230.0))
    for k in range(1, 60):
        state = rig.advance(CLOSED, 20e-3)
        for pressure, temperature, volume, start, air in (
            (state.pressure_a, state.temperature_a, volume_a(position), 4e5, 350.0),
            (state.pressure_b, state.temperature_b, volume_b(position), 3e5, 230.0),
        ):
            tau = start * float(volume) / (R * air) * C_V / (80.0 * wall(float(volume)))
            expected = 285.0 + (air - 285.0) * math.exp(-20e-3 * k / tau)
            assert temperature == pytest.approx(expected, abs=1e-3)
            assert pressure == pytest.approx(start * expected / air, rel=1e-5)
    assert abs(state.temperature_a - 285.0) < 30.0


def test_an_empty_chamber_that_is_filled_is_heated_to_kappa_times_the_supply() -> None:
    """U = c_p T_s Δm: T = P V/(R m) at every instant, and nearly κ T_s from a hundredth of a bar.

    Chamber B is filled through 1b, its exhaust being shut; the wall takes no heat.
    """
    parameters = RigParameters({**SEALED, "cylinder.locked": True, H: 0.0})
    run = simulate(parameters, np.full(1000, 3.0), 1e-3, 0.1, (P_E, 1e3), (300.0, 300.0))
    volume, pressure = float(volume_b(0.1)), run.pressure_b
    mass = 1e3 * volume / (R * 300.0) + (pressure - 1e3) * volume / (KAPPA * R * T_S)
    assert np.abs(run.temperature_b / (pressure * volume / (R * mass)) - 1.0).max() < 1e-5
    assert pressure[-1] == pytest.approx(P_S, rel=1e-6)
    assert run.temperature_b[-1] == pytest.approx(KAPPA * T_S, rel=2e-3)


def test_a_chamber_that_is_vented_keeps_its_entropy() -> None:
    """What stays inside has only expanded: T P^((1-κ)/κ) of the air is kept, with h = 0."""
    parameters = RigParameters({**SEALED, "cylinder.locked": True, H: 0.0})
    run = simulate(parameters, np.full(300, 3.0), 1e-3, 0.1, (P_S, P_E), (T_S, T_S))
    kept = run.temperature_a * run.pressure_a ** ((1.0 - KAPPA) / KAPPA)
    assert run.pressure_a[-1] < 0.4 * P_S
    assert np.abs(kept / kept[0] - 1.0).max() < 1e-5


def simpson(three: tuple[Array, Array, Array], duration: float) -> Array:
    """Integral over ``duration`` from the values at start, middle and end."""
    return duration / 6.0 * (three[0] + 4.0 * three[1] + three[2])


def test_mass_and_energy_close_over_a_cycle() -> None:
    """Each chamber's gain is what flowed in, less the work, plus the wall's heat, to 1e-6.

    The carriage is driven there and back; flows, work and heat are added up by Simpson's rule.
    """
    parameters = RigParameters(
        {**HEATED, "friction.form": "saturating", "time.tolerance": 1e-2, H: 80.0}
    )
    rig = Rig(parameters)
    rig.reset(0.06)
    plant = rig.plant
    start = content(rig.motion)
    gained, passed = np.zeros(4), np.zeros(4)
    period, far = 1e-4, 0.06
    for k in range(8000):
        voltage = CLOSED + 1.2 * math.sin(2.0 * math.pi * k * period / 0.8)
        lands = openings(plant, voltage)
        seen = [gains(plant, lands, rig.motion)]
        for _ in range(2):
            rig.advance(voltage, 0.5 * period)
            seen.append(gains(plant, lands, rig.motion))
        part = simpson((seen[0], seen[1], seen[2]), period)
        gained += part
        passed += np.abs(part)
        far = max(far, rig.motion.position)
    assert far > 0.065
    assert np.abs((content(rig.motion) - start - gained) / passed).max() < 1e-6


def content(state: HeatedMotion) -> Array:
    """Mass (kg) and internal energy (J) of A and of B."""
    energy_a = state.pressure_a * volume_a(state.position) / (KAPPA - 1.0)
    energy_b = state.pressure_b * volume_b(state.position) / (KAPPA - 1.0)
    masses = energy_a / (C_V * state.temperature_a), energy_b / (C_V * state.temperature_b)
    return np.array([*masses, energy_a, energy_b])


def gains(plant: Plant, lands: object, state: HeatedMotion) -> Array:
    """Their rates of change."""
    a = stream_into_a(plant, plant.supply_pressure, lands, state.pressure_a, state.temperature_a)
    b = stream_into_b(plant, plant.supply_pressure, lands, state.pressure_b, state.temperature_b)
    warmth_a = 80.0 * wall(float(volume_a(state.position))) * (293.15 - state.temperature_a)
    warmth_b = 80.0 * wall(float(volume_b(state.position))) * (293.15 - state.temperature_b)
    work = AREA * state.velocity
    return np.array(
        [
            a.mass_flow,
            b.mass_flow,
            a.enthalpy_flow - state.pressure_a * work + warmth_a,
            b.enthalpy_flow + state.pressure_b * work + warmth_b,
        ]
    )


@pytest.mark.parametrize(
    ("pressure", "upstream"), [(3e5, (T_S, 350.0)), (9e4, (T_S, T_E)), (7e5, (350.0, 350.0))]
)
def test_air_has_the_temperature_of_where_it_comes_from(
    pressure: float, upstream: tuple[float, float]
) -> None:
    """A chamber at 350 K takes in the supply's air or the room's, and gives its own to either."""
    plant = Plant.of(RigParameters(HEATED))
    lands = openings(plant, 6.0)
    nothing = lands.closing._replace(orifice_area=0.0, gap=0.0)
    inward = net_stream(plant, plant.supply_pressure, lands.opening, nothing, pressure, 350.0)
    outward = net_stream(plant, plant.supply_pressure, nothing, lands.opening, pressure, 350.0)
    for flow, temperature in zip((inward, outward), upstream, strict=True):
        assert abs(flow.mass_flow) > 1e-6
        assert flow.enthalpy_flow == pytest.approx(C_P * temperature * flow.mass_flow, rel=1e-12)


@pytest.mark.parametrize("voltage", [3.0, 4.9, 5.3, 7.0])
def test_air_as_warm_as_the_supplys_flows_as_that_without_temperatures(voltage: float) -> None:
    """Into each chamber and out of the supply, by edges that are shared out alike."""
    plant = Plant.of(RigParameters(HEATED))
    lands, supply = openings(plant, voltage), plant.supply_pressure
    for pressure_a, pressure_b in ((2e5, 5e5), (5e5, 2e5), (3e5, 1.5e5)):
        for stream, inflow, pressure in (
            (stream_into_a, inflow_a, pressure_a),
            (stream_into_b, inflow_b, pressure_b),
        ):
            found = stream(plant, supply, lands, pressure, T_S).mass_flow
            assert found == pytest.approx(inflow(plant, lands, pressure).mass_flow, rel=1e-12)
        state = HeatedMotion(0.1, 0.0, pressure_a, pressure_b, T_S, T_S)
        found = heated_supply_flow(plant, supply, lands, state)
        assert found == pytest.approx(supply_flow(plant, lands, pressure_a, pressure_b), rel=1e-12)


@pytest.mark.parametrize(("pressure", "upstream"), [(3e5, 350.0), (9e4, T_E)])
def test_a_leak_takes_the_chambers_air_out_and_the_rooms_in(
    pressure: float, upstream: float
) -> None:
    """With the heat of where the air comes from."""
    flow = leak_out(Plant.of(RigParameters(HEATED)), 1e-8, pressure, 350.0)
    assert (flow.mass_flow > 0.0) == (pressure > P_E)
    assert flow.enthalpy_flow == pytest.approx(C_P * upstream * flow.mass_flow, rel=1e-12)


def test_errors_of_temperatures_count_by_their_own_unit() -> None:
    """2 mK count as 1, of either chamber and sign; NaN is not passed over."""
    for warm in ((2e-3, 0.0), (-2e-3, 1e-3), (1e-3, 2e-3), (0.0, -2e-3)):
        size = error_size(HeatedMotion(1e-9, 1e-6, 0.2, 0.2, *warm))
        assert size == pytest.approx(1.0, rel=1e-12)
    assert math.isnan(error_size(HeatedMotion(0.0, 0.0, 0.0, 0.0, 0.0, math.nan)))


def states(generator: np.random.Generator) -> tuple[HeatedMotion, int]:
    """A random state of a sliding rig, some of it beyond supply or atmosphere."""
    direction = int(generator.choice((-1, 1)))
    speed = float(10.0 ** generator.uniform(-3.5, 0.0))
    pressures = np.full(2, P_S)
    # The flow's slope has a step where it chokes, at 0.999 and at equal pressures.
    while any(
        abs(ratio - step) < 3e-3
        for ratio in (*(pressures / P_S), *(P_E / pressures), pressures.min() / pressures.max())
        for step in (0.35, 0.528, 1.0)
    ):
        pressures = generator.uniform(0.7e5, 7.5e5, 2)
    state = HeatedMotion(
        generator.uniform(0.01, 0.19),
        direction * speed,
        *pressures.tolist(),
        *generator.uniform(230.0, 390.0, 2).tolist(),
    )
    return state, direction


def matrix_at(plant: Plant, voltage: float, state: HeatedMotion, direction: int) -> Array:
    """All derivatives that the equations give."""
    found = sliding_rates(plant, state, inflows(plant, openings(plant, voltage), state), direction)
    push = found.by_pressure
    whole = np.zeros((6, 6))
    whole[0, 1] = 1.0
    whole[1, :4] = found.by_position, found.by_velocity, push, -push
    for place, other, chamber in ((2, 3, found.a), (3, 2, found.b)):
        for row, own in ((place, chamber.pressure), (place + 2, chamber.temperature)):
            whole[row, :2] = own.by_position, own.by_velocity
            whole[row, [place, place + 2]] = own.by_pressure, own.by_temperature
            whole[row, [other, other + 2]] = own.by_other_pressure, own.by_other_temperature
    return whole


LEAKS = {"leak.across": 2e-7, "leak.a": 1e-7, "leak.b": 2e-7}


@pytest.mark.parametrize(
    "values",
    [{}, {"valve.assembly": "printed"}, {**LEAKS, "valve.flow_law": "iso_6358"}],
    ids=["reconciled", "printed", "leaks"],
)
def test_the_whole_matrix(values: dict[str, object]) -> None:
    """All derivatives of a sliding rig against differences, those taken for zero included."""
    plant = Plant.of(RigParameters({**HEATED, **values, H: 200.0}))
    generator = np.random.default_rng(12)
    widths = (1e-5, 1e-6, 20.0, 20.0, 1e-2, 1e-2)
    for voltage in (3.0, 5.2, 7.0):
        lands = openings(plant, voltage)
        for _ in range(20):
            state, direction = states(generator)
            expected = np.empty((6, 6))
            for column, width in enumerate(widths):
                for row in range(6):

                    def value(x: float, row: int = row, column: int = column) -> float:
                        changed = state._replace(**{STATES[column]: x})  # noqa: B023
                        return rates(plant, lands, changed, direction)[row]  # noqa: B023

                    expected[row, column] = slope(value, state[column], width)
            # Of a full turn of each state: kelvins and pascals are of different size.
            size = np.array([0.1, 0.1, 1e5, 1e5, 100.0, 100.0])
            scale = np.abs(expected * size).max(axis=1, keepdims=True) + 1e-9
            found = matrix_at(plant, voltage, state, direction)
            assert np.abs((found - expected) * size / scale).max() < 1e-6


@pytest.mark.parametrize("values", [{}, LEAKS], ids=["sealed", "leaks"])
def test_the_elimination_solves_the_system(values: dict[str, object]) -> None:
    """Two rows of a chamber at once, position and velocity: against numpy's solution."""
    plant = Plant.of(RigParameters({**HEATED, **values, H: 200.0}))
    generator = np.random.default_rng(13)
    size = np.array([0.1, 0.1, 1e5, 1e5, 100.0, 100.0])
    for step in (1e-6, 1e-4, 1e-3):
        for _ in range(30):
            state, direction = states(generator)
            flows = inflows(plant, openings(plant, 6.0), state)
            first = sliding_rates(plant, state, flows, direction)
            right = size * generator.normal(size=6)
            found = solved(eliminated(first, step), HeatedMotion(*right.tolist()))
            system = np.eye(6) / (GAMMA * step) - matrix_at(plant, 6.0, state, direction)
            expected = np.linalg.solve(system, right)
            assert (
                np.abs((np.array(found) - expected) / size).max()
                < 1e-9 * np.abs(expected / size).max()
            )


@pytest.mark.parametrize("values", [{}, LEAKS], ids=["sealed", "leaks"])
@pytest.mark.parametrize("voltage", [5.08, 5.0, 4.4])
def test_a_rig_starts_where_a_held_one_settles(voltage: float, values: dict[str, object]) -> None:
    """After ten minutes with the carriage locked nothing changes any more."""
    parameters = RigParameters({**HEATED, **values, "cylinder.locked": True, T_W: 280.0})
    rig = Rig(parameters)
    rig.reset(0.07)
    for _ in range(60):
        state = rig.advance(voltage, 10.0)
    _, _, pressure_a, pressure_b, warm_a, warm_b = settled_air(rig.plant, voltage, 0.07)
    assert (state.pressure_a, state.pressure_b) == pytest.approx((pressure_a, pressure_b), rel=1e-6)
    assert (state.temperature_a, state.temperature_b) == pytest.approx((warm_a, warm_b), abs=1e-3)
    assert 280.0 < warm_a < T_S


def test_without_wall_heat_chambers_settle_at_the_supplys_temperature() -> None:
    """And sealed ones, which nothing warms, at the wall's."""
    for temperature in (250.0, 297.0, 350.0):
        plant = Plant.of(RigParameters({**HEATED, H: 0.0, "supply.temperature": temperature}))
        found = settled_air(plant, CLOSED, 0.0)
        assert (found.temperature_a, found.temperature_b) == pytest.approx(
            (temperature, temperature), abs=1e-5
        )
    plant = Plant.of(RigParameters({**SEALED, H: 0.0}))
    assert settled_air(plant, CLOSED, 0.0)[2:] == (P_E, P_E, 293.15, 293.15)


def test_a_rig_without_temperatures_says_so() -> None:
    """It takes none and shows none, and its trace has no column of them."""
    rig = Rig()
    assert isinstance(rig.state, State)
    with pytest.raises(AttributeError, match=r"chambers\.thermodynamics is energy_balance"):
        _ = rig.state.temperature_a
    with pytest.raises(ValueError, match=r"temperatures .* refused.*chambers\.thermodynamics"):
        rig.reset(temperatures=(300.0, 300.0))
    assert "temperature_a" not in simulate(RigParameters(), [6.0], 1e-3).columns()


def test_a_trace_has_the_temperatures_of_the_rig() -> None:
    """With unit, the same as the rig's step by step, bit for bit, last in the table."""
    rig = Rig(RigParameters(HEATED))
    run = simulate(rig.parameters, [6.0] * 30, 1e-3)
    for _ in range(30):
        rig.advance(6.0, 1e-3)
    assert isinstance(rig.state, HeatedState)
    assert list(run.columns()) == list(HeatedState._fields)
    assert run.units()["temperature_b"] == "K"
    assert [values[-1] for values in run.columns().values()] == list(rig.state)
    assert run.temperature_b.min() < run.temperature_b[0] - 1.0
    assert run.temperature_a.max() > run.temperature_a[0] + 10.0


def test_bad_temperatures_are_refused_by_name() -> None:
    """At the start, and of a state that has come to be none of a rig's."""
    rig = Rig(RigParameters(HEATED))
    before = rig.state
    for bad in ((0.0, 300.0), (300.0, math.nan), (300.0,), "ab"):
        with pytest.raises(ValueError, match=r"temperatures .* refused"):
            rig.reset(temperatures=bad)  # type: ignore[arg-type]
    assert rig.state == before
    state = HeatedMotion(0.1, 0.0, 3e5, 3e5, 290.0, -1.0)
    assert faults.fault_of(rig.plant, state) == faults.NO_TEMPERATURE
    assert faults.fault_of(rig.plant, state._replace(temperature_b=math.nan)) == faults.NOT_FINITE
    assert faults.fault_of(rig.plant, state._replace(pressure_a=-1.0)) != faults.SOUND
    assert faults.fault_of(rig.plant, state._replace(temperature_b=290.0)) == faults.SOUND
    said = str(faults.simulation_error(faults.NO_TEMPERATURE, 2.0, state))
    assert said.startswith("after 2 s: a temperature is not positive (")
    assert "temperatures 290 and -1 K" in said


def test_the_option_can_be_switched_on_a_rig_that_runs() -> None:
    """The air begins with the supply's temperature; switched off, position and pressures stay."""
    rig = Rig()
    rig.advance(6.0, 0.1)
    before = rig.state
    rig.configure(rig.parameters.with_values(HEATED))
    assert rig.state[:5] == before[:5]
    assert (rig.state.temperature_a, rig.state.temperature_b) == (T_S, T_S)
    warm = rig.advance(6.0, 0.01)
    assert warm.temperature_a != T_S
    rig.configure(RigParameters())
    assert rig.state[:5] == warm[:5]
    assert isinstance(rig.state, State)


@pytest.mark.parametrize("model", ["adiabatic", "polytropic"])
def test_without_temperatures_the_rooms_air_is_as_warm_as_the_supplys(model: str) -> None:
    """An option of next to nothing changes next to nothing, where air is sucked in, too."""
    values = {
        "chambers.thermodynamics": model,
        "atmosphere.temperature": 250.0,
        "fault.carriage.seized": True,
        "leak.a": 1e-8,
    }
    alone, beside = (
        simulate(RigParameters({**values, **option}), [3.0] * 30, 1e-3, pressures=(6e4, 6e4))
        for option in ({}, {"supply.droop": 1.0})
    )
    assert alone.pressure_a[-1] > 7e4
    assert np.allclose(beside.pressure_a, alone.pressure_a, rtol=1e-6)
    assert np.allclose(beside.pressure_b, alone.pressure_b, rtol=1e-6)


def test_the_size_of_it() -> None:
    """What heat changes, as an independent simulator has it: filling to 95 % in 1.29, not 0.91 s.

    And 43 kPa in chambers at 0.5 MPa gauge, the carriage held at mid-stroke.
    """
    locked = {"cylinder.locked": True, "cylinder.initial_position": 0.1}
    voltages = np.concatenate([np.full(500, CLOSED), np.full(2000, 4.4)])

    def pressures(supply: float, values: dict[str, object]) -> tuple[Array, Array]:
        rig = RigParameters({**locked, "supply.pressure": supply, **values})
        run = simulate(rig, voltages, 1e-3)
        return run.pressure_a[500:], run.pressure_b[500:]

    for values, expected in (({}, 0.91), (HEATED, 1.29)):
        _, filling = pressures(501325.0, values)
        share = (filling - filling[0]) / (501325.0 - filling[0])
        assert np.argmax(share > 0.95) * 1e-3 == pytest.approx(expected, abs=0.01)
    cold, warm = pressures(601325.0, {}), pressures(601325.0, HEATED)
    assert np.abs(np.subtract(cold, warm)).max() == pytest.approx(43e3, abs=2e3)
