# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Tubes between valve and chambers: late air, a fall of pressure, and no air that gets lost."""

import copy
import math
import pickle
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from extent import also
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rodless_base.parameters import ParameterError
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import HeatedState, Rig, RigParameters, simulate
from rodless_sim.physics.air_in_tubes import Tubes, friction_square, hermite, row_at
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings
from rodless_sim.physics.spool import Memory
from rodless_sim.physics.timed import memory_of
from rodless_sim.sensors import IDEAL

Array = npt.NDArray[np.float64]

R, T, KAPPA, MU = 287.05, 297.0, 1.4, 1.83e-5
LENGTH, BORE = 0.6, 4e-3
DELAY = LENGTH / math.sqrt(KAPPA * R * T)
AREA, STROKE, DEAD = math.pi / 4 * 0.025**2, 0.2, 15e-6
TUBES: dict[str, Any] = {"tubes.model": "delay"}
HELD = {**TUBES, "fault.carriage.seized": True}


def tubes_of(rig: Rig) -> Tubes:
    """What is in the tubes of a rig."""
    memory = rig._spool
    assert isinstance(memory, Memory)
    assert isinstance(memory.tubes, Tubes)
    return memory.tubes


def fall(flow: float) -> float:
    """P_v² − P_e² (Pa²) of isothermal flow, by the friction factor."""
    if flow == 0.0:
        return 0.0
    size = abs(flow)
    reynolds = size * BORE / (MU * math.pi / 4 * BORE**2)
    factor = max(64 / reynolds, 0.3164 / reynolds**0.25)
    square = factor * LENGTH / BORE * (size / (math.pi / 4 * BORE**2)) ** 2 * R * T
    return math.copysign(square, flow)


def into(rig: Plant, voltage: float, second: bool) -> Any:
    """The flow (kg/s) that the valve lets into the tube of A or B, by the pressure there (Pa)."""
    lands = openings(rig, voltage)
    inlet, outlet = (lands.opening, lands.closing)
    if lands.forward == second:
        inlet, outlet = outlet, inlet
    return lambda p: (
        edge_flow(rig, inlet, rig.supply_pressure, p) - edge_flow(rig, outlet, p, 101325.0)
    )


def at_valve(flow: Any, end: float) -> tuple[float, float]:
    """Pressure (Pa) and flow (kg/s) at the valve where the tube's end there has ``end`` (Pa)."""
    left = lambda p: p * p - fall(flow(p)) - end * end  # noqa: E731
    pressure = brentq(left, 0.5 * min(end, 1e5), 2.0 * max(end, 1e6), xtol=1e-7, rtol=1e-14)
    return pressure, flow(pressure)


class Apart:
    """The same rig as delay differential equations, by scipy's Radau and the method of steps.

    States are position, velocity, both pressures, and what has passed the valve on either side.
    """

    def __init__(self, parameters: RigParameters, start: Array, held: bool) -> None:
        """Begin at rest."""
        self.plant, self.held, self.moves = Plant.of(parameters), held, False
        self.pieces: list[Any] = []
        self.now, self.state = 0.0, np.array([*start, 0.0, 0.0])

    def passed(self, time: float) -> Array:
        """What had passed the valve at ``time``."""
        if time <= 0.0 or not self.pieces:
            return np.zeros(2)
        piece = next((p for p in self.pieces if time <= p.t_max), self.pieces[-1])
        return np.asarray(piece(time)[4:])

    def arriving(self, time: float, side: int) -> float:
        """The flow (kg/s) out of a tube at ``time``."""
        since = time - DELAY
        piece = next((p for p in self.pieces if p.t_min <= since < p.t_max), None)
        if since <= 0.0 or piece is None:
            return 0.0
        return float(piece.flows(since, piece(since))[side])

    def volumes(self, y: float) -> tuple[float, float]:
        """Of A and B."""
        return DEAD + AREA * y, DEAD + AREA * (STROKE - y)

    def flows(self, voltage: float) -> Any:
        """What passes the valve toward A and B, by time and state."""
        valve = [into(self.plant, voltage, side) for side in (False, True)]

        def found(time: float, s: Array) -> list[float]:
            gone, out = self.passed(time - DELAY), []
            for side, (sign, volume) in enumerate(zip((1, -1), self.volumes(s[0]), strict=True)):
                stiff = KAPPA * R * T / volume
                growth = sign * AREA * s[1]
                end = s[2 + side] - DELAY * KAPPA * s[2 + side] * growth / volume
                end += stiff * (s[4 + side] - gone[side])
                out.append(at_valve(valve[side], end)[1])
            return out

        return found

    def advance(self, voltage: float, until: float) -> None:
        """Hold the valve at ``voltage`` (V) up to ``until`` (s)."""
        jumps = [p.t_min + DELAY for p in self.pieces if p.jumps]
        begins = True
        while self.now < until - 1e-12:
            ends = [t for t in (*jumps, until, self.now + 0.99 * DELAY) if t > self.now + 1e-12]
            self.step(voltage, min(ends), begins)
            begins = False

    def step(self, voltage: float, end: float, jumps: bool) -> None:
        """Integrate over what has one formula."""
        flows = self.flows(voltage)

        def rate(time: float, s: Array) -> list[float]:
            slide = s[1] if self.moves else 0.0
            rates = [slide, 0.0]
            if self.moves:
                drag = 12.0 + 17.0 * math.exp(-((slide / 1.3e-3) ** 2)) + 4500.0 * slide
                rates[1] = AREA * (s[2] - s[3]) - drag
            for side, (sign, volume) in enumerate(zip((1, -1), self.volumes(s[0]), strict=True)):
                late = self.arriving(time, side)
                work = s[2 + side] * sign * AREA * slide
                rates.append(KAPPA / volume * (R * T * late - work))
            return [*rates, *flows(time, s)]

        def breaks(_time: float, s: Array) -> float:
            return float(AREA * (s[2] - s[3])) - 29.0 if not self.moves else -1.0

        breaks.terminal, breaks.direction = True, 1  # type: ignore[attr-defined]
        scale = np.array([1e-9, 1e-8, 1e-3, 1e-3, 1e-13, 1e-13])
        run = solve_ivp(
            rate,
            (self.now, end),
            self.state,
            "Radau",
            dense_output=True,
            rtol=1e-9,
            atol=scale,
            events=None if self.held else breaks,
            max_step=2e-4,
        )
        assert run.success
        piece = run.sol
        piece.flows, piece.jumps = flows, jumps
        self.pieces.append(piece)
        self.now, self.state = float(run.t[-1]), run.y[:, -1]
        if run.status == 1:
            self.moves = True
            if self.now < end - 1e-12:
                self.step(voltage, end, False)


@pytest.mark.parametrize("held", [also(True), False], ids=["held", "sliding"])
def test_agrees_with_delay_differential_equations(held: bool) -> None:
    """5 µm and 100 Pa are wanted; 1 µm and 20 Pa it is, with jumps that arrive between samples."""
    parameters = RigParameters(HELD if held else TUBES)
    voltages = np.repeat([7.0, 9.5, 3.0 if held else 6.5], [13, 12, 15])
    run = simulate(parameters, voltages, 1e-3, 0.05)
    assert np.ptp(run.pressure_a) > 3e4
    start = np.array([0.05, 0.0, run.pressure_a[0], run.pressure_b[0]])
    apart, rows = Apart(parameters, start, held), [start]
    for k, voltage in enumerate(voltages):
        apart.advance(voltage, 1e-3 * (k + 1))
        rows.append(apart.state[:4])
    expected = np.array(rows)
    assert apart.moves != held
    assert np.abs(run.position - expected[:, 0]).max() < 1e-6
    assert np.abs(run.pressure_a - expected[:, 2]).max() < 20.0
    assert np.abs(run.pressure_b - expected[:, 3]).max() < 20.0


def test_air_arrives_after_the_time_of_sound() -> None:
    """Not before L/c does a chamber notice, and then as much as the valve passed at first."""
    rig = Rig(RigParameters(HELD))
    start = rig.reset(0.1).pressure_a
    rig.advance(8.0, DELAY - 2e-9)
    assert rig.state.pressure_a == start
    rig.advance(8.0, 1e-6)
    _, first = at_valve(into(rig.plant, 8.0, False), start)
    grown = (rig.state.pressure_a - start) / (1e-6 - 2e-9)
    assert grown == pytest.approx(KAPPA * R * T / (DEAD + AREA * 0.1) * first, rel=5e-3)
    assert rig.state.mass_flow_a == pytest.approx(first, rel=5e-3)


@pytest.mark.parametrize("flow", [2e-7, 5e-6, -5e-6, 1e-3, -1e-3])
def test_pressure_falls_by_hagen_poiseuille_or_blasius(flow: float) -> None:
    """Along a tube that is cut into thin slices, the slope is that of an incompressible pipe."""
    rig = Rig(RigParameters(HELD))
    found = math.sqrt(4e5**2 + friction_square(rig.plant, flow))
    speed_area = math.pi / 4 * BORE**2

    def slope(_x: float, p: Array) -> list[float]:
        density = p[0] / (R * T)
        speed = abs(flow) / (density * speed_area)
        reynolds = density * speed * BORE / MU
        laminar = 32 * MU * speed / BORE**2
        blasius = 0.3164 / reynolds**0.25 * density * speed**2 / (2 * BORE)
        assert (laminar > blasius) == (reynolds < 1189)
        return [-math.copysign(max(laminar, blasius), flow)]

    sliced = solve_ivp(slope, (0.0, -LENGTH), [4e5], rtol=1e-10, atol=1e-6)
    assert found - 4e5 == pytest.approx(sliced.y[0, -1] - 4e5, rel=1e-6)


def test_all_air_that_passed_is_in_the_chamber_or_in_the_tube() -> None:
    """To a millionth, with jumps of the valve; and some of it is in the tube."""
    rig = Rig(RigParameters(HELD))
    before = rig.reset(0.03)
    generator = np.random.default_rng(5)
    most = 0.0
    for _ in range(60):
        rig.advance(float(generator.uniform(3.0, 8.0)), float(generator.uniform(1e-4, 3e-3)))
        tubes, state = tubes_of(rig), rig.state
        since = rig.nanoseconds * 1e-9 - DELAY
        arrived, _ = hermite(tubes.history, row_at(tubes, since, False), 1, since)
        gained = (state.pressure_a - before.pressure_a) * (DEAD + AREA * 0.03) / (KAPPA * R * T)
        in_chamber = before.pressure_a * (DEAD + AREA * 0.03) / (R * T)
        assert abs(gained - arrived) < 1e-6 * in_chamber
        most = max(most, abs(tubes.a.mass - arrived))
    assert most > 1e-7


@pytest.mark.parametrize("temperature", [250.0, 400.0])
def test_air_on_its_way_goes_on_at_another_speed_of_sound(temperature: float) -> None:
    """Half of the way at the one and half at the other; and as much arrives as without a change."""
    rig, same = Rig(RigParameters(HELD)), Rig(RigParameters(HELD))
    start = rig.reset(0.1).pressure_a
    rig.advance(8.0, 0.5 * DELAY)
    rig.configure(rig.parameters.with_values({"supply.temperature": temperature}))
    half = 0.5 * DELAY * math.sqrt(T / temperature)
    assert rig.advance(8.0, half - 5e-9).pressure_a == start
    assert rig.advance(8.0, 1e-6).pressure_a > start
    grown = rig.advance(8.0, half + 5e-9 - 1e-6).pressure_a - start
    same.reset(0.1)
    expected = same.advance(8.0, 1.5 * DELAY).pressure_a - start
    assert grown == pytest.approx(expected * temperature / T, rel=1e-3)


@pytest.mark.parametrize(("name", "value"), [("supply.temperature", 400.0), ("tubes.length", 0.2)])
def test_no_air_is_lost_where_its_way_becomes_faster(name: str, value: float) -> None:
    """A chamber gains what the valve had passed; the run ended in a motion too fast to follow."""
    rig = Rig(RigParameters({**HELD, "tubes.length": 1.0}))
    rig.reset(0.03)

    def arrived() -> float:
        tubes, since = tubes_of(rig), rig.nanoseconds * 1e-9 - rig.plant.tubes.delay
        return hermite(tubes.history, row_at(tubes, since, False), 1, since)[0]

    before = rig.advance(8.0, 4e-3)
    had_arrived = arrived()
    rig.configure(rig.parameters.with_values({name: value}))
    gain = rig.advance(8.0, 4e-3).pressure_a - before.pressure_a
    stiff = KAPPA * R * rig.plant.air.temperature / (DEAD + AREA * 0.03)
    assert gain == pytest.approx(stiff * (arrived() - had_arrived), rel=1e-5)
    assert gain > 1e4


def test_leaking_air_flows_as_steadily_as_without_tubes() -> None:
    """What leaks out of a held chamber falls in pressure by the tube's friction, and no more."""
    values = {**HELD, "leak.a": 1e-7}
    rig, plain = (
        Rig(RigParameters({**values, **tubes})) for tubes in (TUBES, {"tubes.model": "none"})
    )
    for one in (rig, plain):
        one.reset(0.1)
        one.advance(6.0, 40.0)
    end = tubes_of(rig).a
    assert abs(rig.state.mass_flow_a) < 1e-9
    assert end.flow > 1e-5
    assert end.pressure**2 - rig.state.pressure_a**2 == pytest.approx(fall(end.flow), rel=1e-3)
    assert rig.free_air_flow == pytest.approx(plain.free_air_flow, rel=1e-3)


@pytest.mark.parametrize("leaks", [{}, {"leak.across": 2e-8, "leak.a": 1e-8}])
def test_a_heated_rig_begins_with_the_pressures_that_it_settles_at(leaks: dict[str, float]) -> None:
    """A minute at the closed valve changes a held chamber by no more than friction in its tube.

    Air in a tube has the supply's temperature, not that of the chamber behind it. Where none leaks
    none flows: the air is as warm as the walls, at the root of the mean of both squares, which two
    equal gaps in line leave between them.
    """
    warm = {"chambers.thermodynamics": "energy_balance", "chambers.wall_temperature": 280.0}
    rig = Rig(RigParameters({**HELD, **TUBES, **warm, **leaks}))
    begun = rig.reset(0.1)
    assert isinstance(begun, HeatedState)
    if not leaks:
        between = math.sqrt(0.5 * (621325.0**2 + 101325.0**2))
        assert begun.pressure_a == pytest.approx(between, rel=1e-9)
        assert begun.pressure_b == pytest.approx(between, rel=1e-9)
        assert (begun.temperature_a, begun.temperature_b) == pytest.approx((280.0, 280.0))
    later = rig.advance(5.08, 60.0)
    assert isinstance(later, HeatedState)
    assert later.pressure_a == pytest.approx(begun.pressure_a, abs=5.0)
    assert later.pressure_b == pytest.approx(begun.pressure_b, abs=5.0)
    assert later.temperature_a == pytest.approx(begun.temperature_a, abs=1e-3)
    assert later.temperature_b == pytest.approx(begun.temperature_b, abs=1e-3)


@pytest.mark.parametrize("voltage", [0.0, 10.0])
def test_an_open_valve_does_not_swing_against_a_small_chamber(voltage: float) -> None:
    """The chamber passes neither supply nor atmosphere, even where it is all tube."""
    dead = {"cylinder.dead_volume_a": 2.52e-5, "cylinder.dead_volume_b": 2.52e-5}
    values = {**HELD, **dead, "tubes.length": 2.0, "cylinder.initial_position": 0.0}
    run = simulate(RigParameters(values), np.full(300, voltage), 1e-3)
    low, high = 101325.0 - 1.0, 621325.0 + 1.0
    for pressure in (run.pressure_a, run.pressure_b):
        assert low <= pressure.min() <= pressure.max() <= high
    assert np.ptp(run.pressure_a[-50:]) < 1.0


def test_a_tube_larger_than_the_dead_volume_it_is_part_of_is_refused() -> None:
    """2 m of 4 mm hold 25 cm³: the line names the volume, what the tube holds and the way out."""
    values = {"tubes.model": "delay", "tubes.length": 2.0}
    fits = {**values, "cylinder.dead_volume_a": 2.52e-5, "cylinder.dead_volume_b": 2.52e-5}
    RigParameters(fits)
    line = r"dead_volume_b: 2\.5e-05 m³ refused.* holds 2\.51e-05 m³ .*length 2 m.*: raise it"
    with pytest.raises(ParameterError, match=line):
        RigParameters({**fits, "cylinder.dead_volume_b": 2.5e-5})
    RigParameters({**values, "tubes.model": "none"})


def test_rig_simulation_and_loop_have_the_same_bits() -> None:
    """Step by step, in one go and in closed loop; and once more after a reset, and in a copy."""
    parameters = RigParameters.preset("calibrated").with_values({**IDEAL, **TUBES})
    step = references.step(0.0, 0.058, at=0.02)
    loop = closed_loop(parameters, PidParameters.preset("calibrated"), step, 0.3, 1e-3)
    run = simulate(parameters, loop.voltage[:-1], 1e-3)
    for name in ("position", "velocity", "pressure_a", "mass_flow_b"):
        assert np.array_equal(getattr(loop, name), getattr(run, name)), name
    rig = Rig(parameters)
    for _ in range(2):
        rig.reset()
        states = [rig.advance(u, 1e-3) for u in loop.voltage[:-1]]
        assert [s.pressure_b for s in states] == run.pressure_b[1:].tolist()
    rig.reset()
    for u in loop.voltage[:150]:
        rig.advance(u, 1e-3)
    twins = [copy.deepcopy(rig), pickle.loads(pickle.dumps(rig))]
    for twin in (rig, *twins):
        last = [twin.advance(u, 1e-3) for u in loop.voltage[150:-1]][-1]
        assert last.position == run.position[-1]


def test_a_run_leaves_the_history_that_it_began_with() -> None:
    """A span that is refused can begin once more: what has been is never written over."""
    rig = Rig(RigParameters(TUBES))
    rig.reset(0.1)
    rig.advance(7.0, 0.01)
    kept = tubes_of(rig)
    before = kept.history.copy()
    rig.advance(9.0, 0.05)
    assert tubes_of(rig).rows > kept.rows
    assert np.array_equal(before, kept.history)


def test_without_tubes_and_ripple_nothing_is_remembered() -> None:
    """The rig of the paper has no course in time: it runs the very code it ran before."""
    parameters = RigParameters()
    assert memory_of(Plant.of(parameters), Rig(parameters).motion, 5.08) == ()
