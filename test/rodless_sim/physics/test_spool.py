# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The valve's drive: the spool's closed form, hysteresis and dead time, and the order in time."""

import math
import pickle

import numpy as np
import pytest
from scipy.linalg import expm

from rodless_sim import Rig, RigParameters, Scenario, SimulationError, State, simulate
from rodless_sim.physics.course import Course, course_at
from rodless_sim.physics.dead_time import arriving
from rodless_sim.physics.equations import inflows, sliding_rates
from rodless_sim.physics.integrator import sliding_step
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import Spool, calmed, of, sent, swung
from rodless_sim.physics.state import Motion
from rodless_sim.trace import Trace

CLOSED = 5.08
SECOND_ORDER = {"valve.dynamics": "second_order"}
HEATED = {"chambers.thermodynamics": "energy_balance"}
DATA_SHEET = {**SECOND_ORDER, "valve.hysteresis": 0.004, "valve.dead_time": 1e-3}
# Shorter than a period, a whole number of them, and neither.
DEAD_TIMES = (0.4e-3, 2e-3, 3.21e-3)


def same(one: Trace, other: Trace) -> bool:
    """Whether two runs are the same bit for bit."""
    return all(
        np.array_equal(one.columns()[name], values) for name, values in other.columns().items()
    )


@pytest.mark.parametrize("damping", [0.05, 0.7, 0.9999, 1.0, 1.00001, 1.5, 5.0])
def test_the_closed_form_is_the_matrix_exponential(damping: float) -> None:
    """Of ẍ + 2ζωẋ + ω²x = ω²u from any place at any speed, and it can be taken in parts."""
    drive = of(RigParameters({**SECOND_ORDER, "valve.damping": damping}))
    omega = 2.0 * math.pi * 115.0
    system = np.array([[0.0, 1.0], [-(omega**2), -2.0 * damping * omega]])
    start = Spool(6.0, 4.7, 300.0)
    for duration in (1e-9, 1e-6, 1e-4, 1e-3, 2e-2):
        place, speed = expm(system * duration) @ [start.place - 6.0, start.speed]
        found = swung(drive, start, duration)
        assert found.place == pytest.approx(6.0 + place, abs=1e-12)
        assert found.speed == pytest.approx(speed, abs=1e-9)
        halfway = swung(drive, swung(drive, start, 0.3 * duration), 0.7 * duration)
        assert halfway == pytest.approx(found, abs=1e-9)


def test_a_step_overshoots_as_its_damping_says() -> None:
    """By exp(−πζ/√(1−ζ²)), half a period of the damped oscillation after it: 4.6 % at 0.7."""
    root = math.sqrt(1.0 - 0.7**2)
    peak = 1.0 / (2.0 * 115.0 * root)  # s
    rig = Rig(RigParameters({**SECOND_ORDER, "cylinder.locked": True}))
    found = rig.advance(CLOSED + 1.0, peak).spool_voltage - CLOSED
    assert found == pytest.approx(1.0 + math.exp(-math.pi * 0.7 / root), abs=1e-9)
    assert 1.045 < found < 1.047
    assert rig.advance(CLOSED + 1.0, 0.1).spool_voltage == CLOSED + 1.0


@pytest.mark.parametrize(("frequency", "damping"), [(115.0, 0.7), (80.0, 0.5), (200.0, 1.2)])
def test_minus_3_db_is_where_the_closed_form_has_it(frequency: float, damping: float) -> None:
    """At f₀ √(1 − 2ζ² + √(1 + (1 − 2ζ²)²)) the swing is 1/√2 of the command's: 116 Hz at 0.7."""
    less = 1.0 - 2.0 * damping**2
    corner = frequency * math.sqrt(less + math.sqrt(less**2 + 1.0))
    period = 1e-4
    time = np.arange(6000) * period
    values = {**SECOND_ORDER, "valve.natural_frequency": frequency, "valve.damping": damping}
    rig = RigParameters({**values, "cylinder.locked": True})
    commands = CLOSED + 0.5 * np.sin(2.0 * math.pi * corner * time)
    found = simulate(rig, commands, period).spool_voltage[3001:] - CLOSED
    basis = np.exp(-2j * math.pi * corner * np.arange(3001, 6001) * period)
    waves = np.column_stack([basis.real, basis.imag, np.ones(3000)])
    cosine, sine, _ = np.linalg.lstsq(waves, found, rcond=None)[0]
    held = np.sinc(corner * period)  # commands that are held are that much smaller
    assert math.hypot(cosine, sine) / (0.5 * held) == pytest.approx(math.sqrt(0.5), rel=1e-6)
    if frequency == 115.0:
        assert corner == pytest.approx(116.1, abs=0.1)


def test_up_and_down_are_a_hysteresis_apart() -> None:
    """A share of 10 V: 40 mV for 0.4 %, and less than that moves nothing."""
    rig = RigParameters({"valve.hysteresis": 0.004, "cylinder.locked": True})
    up = np.linspace(4.0, 6.0, 201)
    run = simulate(rig, np.concatenate([up, up[::-1]]), 1e-3)
    there, back = run.spool_voltage[100:201], run.spool_voltage[201:402][::-1][100:]
    assert there == pytest.approx(up[100:] - 0.02, abs=1e-12)
    assert back[:-4] == pytest.approx(up[100:-4] + 0.02, abs=1e-12)
    assert back[-1] == there[-1]
    drive = of(RigParameters({"valve.hysteresis": 0.004}))
    assert sent(drive, Spool(6.0, 6.0, 0.0), 6.019).target == 6.0
    assert sent(drive, Spool(6.0, 6.0, 0.0), 5.9).target == pytest.approx(5.92)


def test_hysteresis_alone_is_a_command_that_has_been_through_the_play() -> None:
    """The rig without, given what the play lets through, moves alike: within 1 nm and 0.1 Pa."""
    commands = CLOSED + 2.0 * np.sin(np.arange(600) * 0.02)
    target, through = CLOSED, []
    for command in commands:
        target = min(max(target, command - 0.1), command + 0.1)
        through.append(target)
    played = simulate(RigParameters({"valve.hysteresis": 0.02}), commands, 1e-3, 0.1)
    plain = simulate(RigParameters(), through, 1e-3, 0.1)
    assert np.abs(played.position - plain.position).max() < 1e-9
    assert np.abs(played.pressure_a - plain.pressure_a).max() < 0.1
    assert np.array_equal(played.spool_voltage, plain.voltage)
    assert np.ptp(plain.position) > 1e-3


@pytest.mark.parametrize("late", DEAD_TIMES)
def test_a_command_arrives_to_the_nanosecond(late: float) -> None:
    """A rig with dead time is one without whose command comes later, bit for bit."""
    late += 7e-9
    rig = Rig(RigParameters({**SECOND_ORDER, "valve.dead_time": late}))
    other = Rig(RigParameters(SECOND_ORDER))
    found = rig.advance(7.0, 0.01)
    other.advance(CLOSED, late)
    assert found == other.advance(7.0, 0.01 - late)._replace(voltage=7.0)
    before = Rig(rig.parameters).advance(7.0, late)
    assert before.spool_voltage == CLOSED
    assert before.voltage == 7.0


@pytest.mark.parametrize("late", DEAD_TIMES)
@pytest.mark.parametrize("more", [{}, HEATED], ids=["cold", "heated"])
def test_one_step_at_a_time_is_the_same(late: float, more: dict[str, object]) -> None:
    """Rig.advance and simulate agree in every bit, whatever is under way."""
    parameters = RigParameters({**DATA_SHEET, **more, "valve.dead_time": late})
    commands = CLOSED + np.random.default_rng(3).uniform(-1.0, 1.0, 200).round(1)
    run = simulate(parameters, commands, 1e-3, 0.1)
    rig = Rig(parameters)
    rig.reset(0.1)
    for k, command in enumerate(commands):
        state = rig.advance(float(command), 1e-3)
        for name in ("position", "velocity", "pressure_a", "pressure_b"):
            assert getattr(state, name) == getattr(run, name)[k + 1]
        # To the last bit: a spool that leaves closed is taken to be on the side where it goes.
        assert state.spool_voltage == pytest.approx(run.spool_voltage[k + 1], rel=3e-16)
    assert type(state)(*state) == state == pickle.loads(pickle.dumps(state))
    assert list(run.columns()) == list(state._fields)


def test_commands_under_way_do_not_care_how_time_is_cut() -> None:
    """Spans shorter than the dead time and longer ones lead to the same command at the valve."""
    parameters = RigParameters({"valve.dead_time": 5e-3, "cylinder.locked": True})
    whole, parts = Rig(parameters), Rig(parameters)
    whole.advance(6.0, 4e-3)
    for _ in range(8):
        parts.advance(6.0, 0.5e-3)
    for rig in (whole, parts):
        rig.advance(7.0, 3e-3)
    assert whole.state.spool_voltage == parts.state.spool_voltage == 6.0
    assert whole.advance(7.0, 2e-3 + 1e-9).spool_voltage == 7.0


def test_which_command_is_at_the_valve_when() -> None:
    """By hand: 2.5 periods late, commands 10, 11, 12, … after 5.08."""
    plant = Plant.of(RigParameters({"valve.dead_time": 2.5e-3}))
    commands = np.arange(10.0, 20.0)
    found = [arriving(plant.drive, commands, k, 1_000_000, CLOSED) for k in range(5)]
    assert found == [(CLOSED, CLOSED), (CLOSED, CLOSED), (CLOSED, 10.0), (10.0, 11.0), (11.0, 12.0)]
    plant = Plant.of(RigParameters({"valve.dead_time": 2e-3}))
    found = [arriving(plant.drive, commands, k, 1_000_000, CLOSED) for k in range(4)]
    assert found == [(CLOSED, CLOSED), (CLOSED, CLOSED), (10.0, 10.0), (11.0, 11.0)]


def test_a_reset_puts_the_spool_to_rest() -> None:
    """A run after a reset is the first one once more; what was under way is forgotten."""
    rig = Rig(RigParameters(DATA_SHEET))
    first = [rig.advance(7.0, 1e-3) for _ in range(20)]
    assert rig.reset().spool_voltage == CLOSED
    assert [rig.advance(7.0, 1e-3) for _ in range(20)] == first


def test_a_drive_comes_and_goes() -> None:
    """configure() lets it begin at rest where the command is; without, it is there at once."""
    rig = Rig()
    rig.advance(6.0, 0.01)
    assert type(rig.state) is State
    assert rig.state.spool_voltage == 6.0
    rig.configure(rig.parameters.with_values(DATA_SHEET))
    assert rig.state.spool_voltage == 6.0
    assert "spool_voltage" in rig.state._fields
    assert rig.advance(7.0, 1e-3).spool_voltage == 6.0
    rig.configure(RigParameters())
    assert rig.state.spool_voltage == 7.0


def test_what_fails_leaves_spool_and_commands_as_they_were() -> None:
    """In the middle of a span too, when the first piece of it was sound; the text has the spool."""
    rig = Rig(RigParameters(DATA_SHEET))
    rig.reset(pressures=(1e-100, 1e100))
    before = rig.state
    with pytest.raises(SimulationError, match=r"spool at 5\.08 V"):
        rig.advance(9.0, 0.01)
    assert rig.state == before
    rig.reset()
    other = Rig(rig.parameters)
    assert rig.advance(6.0, 0.005) == other.advance(6.0, 0.005)


def test_a_valve_without_a_drive_has_none() -> None:
    """No constants, no state, no column: what is off costs nothing."""
    for values in ({}, {"valve.damping": 0.2, "valve.natural_frequency": 50.0}):
        parameters = RigParameters(values)
        assert Plant.of(parameters).drive == ()
        assert "spool_voltage" not in simulate(parameters, [6.0], 1e-3).columns()


def test_a_spool_near_its_target_comes_to_rest() -> None:
    """Exactly, within 1 nV and as slow: rigs at rest then cost what constant openings cost."""
    drive = of(RigParameters(SECOND_ORDER))
    for side in (-9e-10, 9e-10):
        assert calmed(drive, Spool(6.0, 6.0 + side, 1e-7)) == Spool(6.0, 6.0, 0.0)
    moving = Spool(6.0, 6.0, 1e-3)
    assert calmed(drive, moving) == moving


@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
@pytest.mark.parametrize("more", [{}, HEATED], ids=["cold", "heated"])
def test_steps_keep_their_order_while_the_openings_move(
    assembly: str, more: dict[str, object]
) -> None:
    """Error of one step of h by h⁴: half the step leaves a sixteenth, with ∂f/∂t only."""
    values = {**SECOND_ORDER, "valve.assembly": assembly, "friction.form": "saturating", **more}
    plant = Plant.of(RigParameters(values))
    spool = Spool(8.0, 6.5, 600.0)
    temperatures = (300.0, 290.0) if more else ()
    start = Rig(RigParameters(more)).motion._replace(
        position=0.06, velocity=0.03, pressure_a=4.2e5, pressure_b=2.6e5
    )
    if temperatures:
        start = start._replace(temperature_a=300.0, temperature_b=290.0)

    def one_step(state: Motion, spool: Spool, step: float) -> tuple[Motion, Spool]:
        course = course_at(plant, spool, 8.0)
        assert isinstance(course, Course)
        first = sliding_rates(plant, state, inflows(plant, course, state), 1)
        after, _ = sliding_step(plant, course, state, 1, first, step)
        return after, swung(plant.drive, spool, step)

    def fine(step: float) -> Motion:
        state, course = start, spool
        for _ in range(128):
            state, course = one_step(state, course, step / 128)
        return state

    def error(step: float) -> float:
        apart = np.subtract(one_step(start, spool, step)[0], fine(step))
        return float(np.abs(apart[2:4]).max())

    # Beside what constant openings would leave, the error is small altogether.
    assert error(4e-4) < 5.0
    assert 12.0 < error(4e-4) / error(2e-4) < 20.0


@pytest.mark.parametrize("periods", [1, 2, 9])
def test_what_arrives_as_a_run_ends_is_in_its_last_sample(periods: int) -> None:
    """A dead time of whole periods: flows and all, the run is that of single steps to its end."""
    rig = RigParameters({"valve.dead_time": periods * 1e-3})
    voltages = 5.2 + 0.3 * np.arange(12.0)
    whole = simulate(rig, voltages, 1e-3).columns()
    stepped = simulate(rig, voltages, 1e-3, scenario=Scenario([])).columns()
    assert whole.keys() == stepped.keys()
    for name, column in whole.items():
        assert np.array_equal(column, stepped[name]), name


@pytest.mark.parametrize("hysteresis", [0.0, 0.004, 0.05])
def test_the_voltage_of_a_spool_that_has_stuck_on_its_way_sends_another_one_there(
    hysteresis: float,
) -> None:
    """A replay without the fault gives it as the command: with a play, too, the spool stands there.

    Elsewhere within the play it would let air in for as long as the fault lasted.
    """
    swinging = {"valve.dynamics": "second_order", "valve.hysteresis": hysteresis}
    stuck, again = (Rig(RigParameters(swinging)) for _ in range(2))
    voltages = (5.08 + 1.2 * np.sin(2.0 * math.pi * 2.0 * 1e-3 * np.arange(40))).tolist()
    for voltage in voltages:
        stuck.advance(voltage, 1e-3)
        again.advance(voltage, 1e-3)
    stuck.configure(stuck.parameters.with_values({"fault.valve.spool": "stuck"}))
    place = stuck.state.spool_voltage
    assert abs(place - 5.08) > 0.25
    for _ in range(500):
        found = stuck.advance(9.0, 1e-3)
        replayed = again.advance(found.voltage, 1e-3)
    assert found.spool_voltage == pytest.approx(place, abs=1e-12)
    assert replayed.spool_voltage == pytest.approx(place, abs=1e-9)
    assert replayed.position == pytest.approx(found.position, abs=1e-5)
