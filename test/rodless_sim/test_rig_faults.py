# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Each fault does what it says, and no fault does nothing."""

import math

import numpy as np
import pytest
from extent import also

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_sim import Rig, RigParameters, Trace, simulate
from rodless_sim.faults import PARAMETERS, READINGS, active, cleared
from rodless_sim.physics.plant import Plant

PERIOD = 1e-3
FORWARD = [6.0] * 400


def faulty(**values: object) -> RigParameters:
    """A rig with faults, ``valve_offset`` for ``fault.valve.offset``."""
    names = {name.removeprefix("fault.").replace(".", "_"): name for name in PARAMETERS}
    return RigParameters({names[name]: value for name, value in values.items()})


def end(**values: object) -> Trace:
    """A run of such a rig at 6 V."""
    return simulate(faulty(**values), FORWARD, PERIOD)


SOUND = simulate(RigParameters(), FORWARD, PERIOD)


def test_each_has_a_default_that_is_no_fault() -> None:
    """A set without faults names none, and its plant is that of the other parameters alone."""
    assert active(RigParameters()) == {}
    plant = Plant.of(RigParameters())
    assert plant.supply_pressure == RigParameters()["supply.pressure"]
    assert (plant.leak.open, plant.leak.a, plant.leak.across) == (False, 0.0, 0.0)
    assert not plant.cylinder.locked
    broken = {n: p.maximum if isinstance(p.default, float) else None for n, p in PARAMETERS.items()}
    given = {name: value for name, value in broken.items() if value is not None}
    assert RigParameters(given).with_values(cleared()) == RigParameters()


def test_what_is_active_is_named_with_its_unit() -> None:
    """Values are in the parameter's unit; a valve that is stuck says where."""
    values = faulty(tube_b_burst=1e-5, carriage_seized=True, valve_spool="stuck_at")
    assert active(values) == {
        "fault.valve.spool": "stuck at 5.08 V",
        "fault.tube_b.burst": "1e-05 m²",
        "fault.carriage.seized": "true",
    }
    assert active(faulty(valve_stuck_voltage=7.0)) == {}


def test_an_offset_of_the_valve_is_added_to_the_command() -> None:
    """The run is that of the other command, and its voltage says so."""
    other = simulate(RigParameters(), [6.5] * 400, PERIOD)
    run = end(valve_offset=0.5)
    assert np.array_equal(run.position, other.position)
    assert np.array_equal(run.voltage, other.voltage)
    rig = Rig(faulty(valve_offset=-10.0))
    assert rig.advance(6.0, PERIOD).voltage == 0.0


def test_a_valve_that_is_stuck_at_a_voltage_takes_no_command() -> None:
    """Whatever the commands, the run is that of the voltage it has stuck at."""
    other = simulate(RigParameters(), [7.0] * 400, PERIOD)
    run = end(valve_spool="stuck_at", valve_stuck_voltage=7.0)
    assert np.array_equal(run.pressure_a, other.pressure_a)


def test_a_valve_that_sticks_stays_where_it_was() -> None:
    """Sticking in the middle of a run, it holds the voltage before; free again, it follows."""
    rig = Rig()
    rig.advance(6.0, 0.1)
    rig.configure(faulty(valve_spool="stuck"))
    assert rig.advance(3.0, 0.1).voltage == 6.0
    rig.configure(RigParameters())
    assert rig.advance(3.0, 0.1).voltage == 3.0
    assert rig.reset().voltage == CLOSED_VOLTAGE
    assert Rig(faulty(valve_spool="stuck")).advance(9.0, 0.1).voltage == CLOSED_VOLTAGE


@pytest.mark.parametrize(
    "further", [{}, {"valve.dead_time": 0.05}, also({"supply.ripple_amplitude": 0.01})]
)
def test_a_spool_that_sticks_on_its_way_stays_there(further: dict[str, object]) -> None:
    """Neither its own swing nor a command that is under way moves it on; free again, it follows."""
    values = RigParameters.preset("calibrated").with_values(further)
    rig = Rig(values)
    rig.advance(5.08, 0.01)
    rig.advance(8.0, 0.001 + values.number("valve.dead_time"))
    there, play = rig.state.spool_voltage, 5.0 * values.number("valve.hysteresis")
    assert 5.1 < there < 7.9
    rig.configure(values.with_values({"fault.valve.spool": "stuck"}))
    for command in (5.08, 0.0, 10.0):
        state = rig.advance(command, 0.1)
        assert state.spool_voltage == there
        assert abs(state.voltage - there) == pytest.approx(play), "which holds it there"
    rig.configure(values)
    assert rig.advance(5.08, 0.2).spool_voltage == pytest.approx(5.08, abs=0.03)


@pytest.mark.parametrize("loss", [0.25, 1.0])
def test_a_supply_that_has_lost_pressure_is_one_of_less(loss: float) -> None:
    """The run is that of a supply with the rest of the gauge pressure; at 1 nothing moves."""
    values = RigParameters()
    supply, ambient = values.number("supply.pressure"), values.number("atmosphere.pressure")
    rest = supply - loss * (supply - ambient)
    other = simulate(values.with_values({"supply.pressure": rest}), FORWARD, PERIOD)
    run = end(supply_loss=loss)
    assert np.array_equal(run.pressure_a, other.pressure_a)
    assert Rig(faulty(supply_loss=loss)).read().supply_pressure == rest
    if loss == 1.0:
        assert np.all(run.position == 0.0)
        assert run.pressure_a == pytest.approx(ambient)


@pytest.mark.parametrize("chamber", ["a", "b"])
def test_a_burst_tube_empties_its_chamber(chamber: str) -> None:
    """Torn off in the middle of a run, the chamber is at 5 % of its gauge pressure in 0.1 s."""
    rig = Rig(RigParameters({"cylinder.locked": True}))
    before = getattr(rig.advance(CLOSED_VOLTAGE, 0.1), f"pressure_{chamber}")
    rig.configure(rig.parameters.with_values({f"fault.tube_{chamber}.burst": 1e-5}))
    after = getattr(rig.advance(CLOSED_VOLTAGE, 0.1), f"pressure_{chamber}")
    assert after - 101325.0 < 0.05 * (before - 101325.0)


def test_a_leak_of_a_fault_adds_to_that_of_the_rig() -> None:
    """Half as an option and half as a fault is a leak of the whole."""
    half = RigParameters({"leak.across": 1e-7, "fault.piston.leak": 1e-7})
    whole = RigParameters({"leak.across": 2e-7})
    runs = [simulate(values, FORWARD, PERIOD) for values in (half, whole)]
    assert np.array_equal(runs[0].pressure_b, runs[1].pressure_b)
    assert not np.array_equal(runs[0].pressure_b, SOUND.pressure_b)


def test_a_seized_carriage_stands_at_any_force() -> None:
    """Seizing in motion, it stops there; the force goes on changing."""
    rig = Rig()
    moving = rig.advance(9.0, 0.4)
    assert moving.velocity > 0.01
    rig.configure(faulty(carriage_seized=True))
    after = rig.advance(2.0, 0.4)
    assert (after.position, after.velocity) == (moving.position, 0.0)
    assert after.force < -100.0


@pytest.mark.parametrize("field", READINGS)
def test_a_sensor_that_is_gone_reads_nan(field: str) -> None:
    """The others read on."""
    seen = Rig(RigParameters({f"fault.{field}.sensor": "gone"})).read()
    assert [name for name, value in seen._asdict().items() if math.isnan(value)] == [field]


@pytest.mark.parametrize("sensors", [{}, {"sensors.position_noise": 1e-5}])
def test_a_frozen_sensor_shows_its_last_reading(sensors: dict[str, object]) -> None:
    """From the sample after it freezes, until it works again."""
    rig = Rig(RigParameters(sensors))
    rig.advance(9.0, 0.1)
    last = rig.read().position
    rig.configure(rig.parameters.with_values({"fault.position.sensor": "frozen"}))
    for _ in range(5):
        rig.advance(9.0, 0.02)
        assert rig.read().position == last
    rig.configure(RigParameters(sensors))
    assert rig.read().position > last + 1e-3


@pytest.mark.parametrize("field", READINGS)
def test_an_offset_and_noise_of_a_sensor_are_in_its_readings(field: str) -> None:
    """Of 2000 readings of a rig at rest, mean and scatter are those of the fault."""
    offset, noise = (1e-3, 1e-4) if field == "position" else (5e3, 500.0)
    start = {"cylinder.initial_position": 0.1}
    rig = Rig(
        RigParameters({**start, f"fault.{field}.offset": offset, f"fault.{field}.noise": noise})
    )
    true = getattr(Rig(RigParameters(start)).read(), field)
    errors = []
    for _ in range(2000):
        rig.advance(CLOSED_VOLTAGE, PERIOD)
        errors.append(getattr(rig.read(), field) - true)
    assert np.mean(errors) == pytest.approx(offset, abs=5.0 * noise / math.sqrt(2000.0))
    assert np.std(errors) == pytest.approx(noise, rel=0.1)
