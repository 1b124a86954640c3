# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a recording holds of supply and valve acts once on the rig that repeats it."""

from pathlib import Path

import numpy as np
import pytest
import rig_bag
from extent import also
from quiet_stop import Quiet

from rodless_lab.cli import replay as command
from rodless_lab.runs.from_bag import read_run
from rodless_lab.runs.measured_run import MeasuredRun, Setpoint
from rodless_lab.runs.recorded_drive import STEADY, recorded_drive, steady_pieces
from rodless_lab.runs.resimulate import follow, replay, resimulate
from rodless_sim import Rig, RigParameters, Scenario
from rodless_sim.scenario import MOST_ENTRIES

RIG = RigParameters.preset("paper")
PERIOD = 1e-3
VOLTAGES = np.repeat([5.05, 5.7, 4.4], [50, 500, 500])
START = 0.05  # m

# By how much a replay may leave the recording (m): where the supply is as read, by next to nothing;
# where its course is known to some kPa, by what those do to a supply of 0.6 MPa.
EXACT, WITHIN_PIECES = 1e-9, 1e-4


def recorded(parameters: RigParameters, scenario: Scenario | None = None) -> MeasuredRun:
    """A run as the plant's topics have it: what the rig truly did, and what its valve followed."""
    rig = Rig(parameters, scenario)
    rig.reset(START)
    rows = []
    for voltage in VOLTAGES:
        state, supply = rig.command(voltage), rig.read().supply_pressure
        rows.append((state.position, state.pressure_a, state.pressure_b, supply, state.voltage))
        rig.advance(voltage, PERIOD)
    return MeasuredRun(PERIOD * np.arange(len(rows)), *np.array(rows).T)


def apart(one: MeasuredRun, other: MeasuredRun) -> float:
    """The largest distance of two carriages in m."""
    return float(np.abs(one.position - other.position).max())


LOSS, OFFSET = {"fault.supply.loss": 0.3}, {"fault.valve.offset": 0.3}
STUCK = {"fault.valve.spool": "stuck_at", "fault.valve.stuck_voltage": 5.6}
LATE = {"valve.dead_time": 5e-3}


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, ""),
        (
            LOSS,
            "a supply of 465325 Pa in place of supply.pressure 621325 Pa, fault.supply.loss 0.3",
        ),
        (OFFSET, "the valve's voltage in place of fault.valve.offset 0.3 V"),
        (STUCK, "the valve's voltage in place of fault.valve.spool stuck_at"),
        (
            {**LOSS, **OFFSET, **LATE},
            "a supply of 465325 Pa in place of supply.pressure 621325 Pa, "
            "fault.supply.loss 0.3; the valve's voltage in place of fault.valve.offset 0.3 V",
        ),
        ({"fault.supply_pressure.offset": 5e4}, ""),
        ({"fault.supply_pressure.noise": 2e4}, ""),
    ],
)
def test_a_rig_repeats_itself_with_its_own_parameters(values: dict[str, object], said: str) -> None:
    """A loss of supply, an offset or a stuck valve acts once, and one line says what was replaced.

    The recording is of a rig that was advanced step by step with those parameters. With any of them
    acting twice the carriage is off by centimetres.
    """
    parameters = RIG.with_values(values)
    run = recorded(parameters)
    again = replay(parameters, run)
    # Of what a sensor with noise reads, the mean is off a little.
    assert apart(again, run) < (1e-4 if "fault.supply_pressure.noise" in values else EXACT)
    assert again.remarks == ((f"taken from the recording: {said}",) if said else ())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"supply.droop": 5e7}, "supply.droop 5e+07 Pa·s/m³"),
        also({"supply.ripple_amplitude": 3e4}, "supply.ripple_amplitude 30000 Pa"),
        ({"supply.kind": "compressor", "supply.receiver_volume": 1e-3}, "supply.kind compressor"),
    ],
)
def test_a_supply_that_varies_is_repeated_as_it_was_read(
    values: dict[str, object], said: str
) -> None:
    """What sinks, ripples, or comes from a receiver: the rig is fed with the recorded course.

    So it departs by what ±2 kPa do, also where the parameters know nothing of the supply's course.
    """
    parameters = RIG.with_values(values)
    run = recorded(parameters)
    again = replay(parameters, run)
    assert apart(again, run) < WITHIN_PIECES
    assert np.abs(again.supply_pressure - run.supply_pressure).max() <= 2.0 * STEADY
    (line,) = again.remarks
    assert line.endswith(f"in place of supply.pressure 621325 Pa, {said}")
    low, high = again.supply_pressure.min(), again.supply_pressure.max()
    assert f"a supply of {low:.0f} to {high:.0f} Pa in" in line
    assert apart(replay(RIG, run), run) < WITHIN_PIECES


def test_faults_on_the_way_are_repeated() -> None:
    """A scenario took supply away, and then shifted the valve: both stand in the recording."""
    parameters = RIG.with_values(LATE)
    changes = [(0.4, {"fault.supply.loss": 0.4}), (0.7, OFFSET), (0.9, {"fault.supply.loss": 0.0})]
    run = recorded(parameters, Scenario(changes))
    again = replay(parameters, run)
    assert apart(again, run) < EXACT
    assert again.remarks == (
        "taken from the recording: a supply of 413325 to 621325 Pa in place of "
        "supply.pressure 621325 Pa",
    )
    assert np.array_equal(again.supply_pressure, run.supply_pressure)


def test_another_supply_than_the_recorded_one_is_named() -> None:
    """A file with 0.7 MPa for a bag with 621 kPa: the bag's counts, as it says; noise is no other.

    A preset that follows set-points has the recorded supply as well.
    """
    run, more = recorded(RIG), RIG.with_values({"supply.pressure": 0.7e6})
    said = "taken from the recording: a supply of {} Pa in place of supply.pressure {} Pa"
    assert resimulate(more, run).remarks == (said.format(621325, 700000),)
    setpoint = Setpoint(np.zeros(1), np.full(1, START))
    assert follow("paper", recorded(more), setpoint).remarks == (said.format(700000, 621325),)
    assert follow("paper", run, setpoint).remarks == ()
    sinking = recorded(RIG, Scenario([(0.4, {"fault.supply.loss": 0.4})]))
    followed = follow("paper", sinking, setpoint)
    assert np.array_equal(followed.supply_pressure, sinking.supply_pressure)
    noisy = recorded(RIG.with_values({"sensors.pressure_noise": 200.0}))
    found = recorded_drive(RIG, noisy)
    assert (found.scenario, found.remark) == (None, "")
    assert found.rig["supply.pressure"] == noisy.supply_pressure.mean()


def test_a_long_run_of_a_period_between_two_nanoseconds_is_followed_to_its_last_sample() -> None:
    """The clock of a real rig has no whole ones: rounded, they add up to samples."""
    count, period = 150_000, 100_004.6e-9
    still = np.full(count, 4e5)
    run = MeasuredRun(
        period * np.arange(count), still / 4e6, still, still, np.full(count, 621325.0), still / 1e5
    )
    setpoint = Setpoint(np.zeros(1), np.full(1, 0.1))
    assert len(follow("paper", run, setpoint).time) == count


def test_what_a_bias_of_the_supply_sensor_does_to_a_replay_is_named() -> None:
    """The rig of the recording itself, a sensor a kilopascal off: the carriage leaves, as is said.

    The instruments of the preset explain the reading, yet the rig is fed with it.
    """
    biased = recorded(RIG.with_values({"sensors.pressure_bias": 5e-3, "sensors.seed": 1}))
    read = biased.supply_pressure.mean()
    assert 200.0 < abs(read - RIG.number("supply.pressure")) < 2e3
    again = replay(RIG, biased)
    assert apart(again, biased) > 1e-5
    said = (
        f"taken from the recording: a supply of {read:.0f} Pa in place of supply.pressure 621325 Pa"
    )
    assert again.remarks == (said,)


def test_commands_do_not_hold_the_faults_of_the_valve(tmp_path: Path) -> None:
    """A bag without valve/state has what was asked: the parameters' offset is added to that, once.

    A bag with it has what the valve followed, and is repeated with no offset.
    """
    parameters = RIG.with_values(OFFSET)
    run = recorded(parameters)
    followed = read_run(rig_bag.write(tmp_path / "followed", run, held=True))
    columns = run.columns() | {"voltage": VOLTAGES}
    asked = read_run(rig_bag.write(tmp_path / "asked", MeasuredRun(**columns)))
    assert (followed.commanded, asked.commanded) == (False, True)
    for one in (followed, asked):
        assert apart(replay(parameters, one), one) < 1e-6  # stamps are in whole nanoseconds
    assert replay(parameters, asked).remarks == ()
    assert len(replay(parameters, followed).remarks) == 1


def test_the_verb_says_what_it_took_from_the_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line names each parameter of the file that the bag stands in for."""
    file = tmp_path / "loss.yaml"
    file.write_text("/**/plant: {ros__parameters: {fault.supply.loss: 0.3}}\n", encoding="utf-8")
    bag = rig_bag.write(tmp_path / "bag", recorded(RIG.with_values(LOSS)), held=True)
    arguments = [str(bag), "--parameters", str(file), "--output", str(tmp_path / "out")]
    assert command.main(arguments, Quiet()) == 0
    said = capsys.readouterr()
    (line,) = [one for one in said.err.splitlines() if "taken from the recording" in one]
    assert line.endswith("supply.pressure 621325 Pa, fault.supply.loss 0.3")
    row = next(line for line in said.out.splitlines() if line.startswith("position"))
    assert float(row.split()[2]) == 0.0


def test_a_supply_of_nothing_is_the_atmosphere() -> None:
    """All of it lost, and read a little below ambient: the rig is fed with the atmosphere."""
    run = recorded(RIG.with_values({"fault.supply.loss": 1.0}))
    columns = run.columns() | {"supply_pressure": run.supply_pressure - 300.0}
    found = recorded_drive(RIG, MeasuredRun(**columns))
    assert found.rig["supply.pressure"] == RIG["atmosphere.pressure"]


def test_pieces_of_a_supply_by_hand() -> None:
    """Each as long as its readings lie within 4 kPa, with their mean; wider where they are many."""
    readings = np.array([5.00, 5.01, 5.03, 5.05, 5.06, 4.00, 4.02]) * 1e5
    found = steady_pieces(readings)
    assert [start for start, _ in found] == [0, 3, 5]
    assert [pressure for _, pressure in found] == pytest.approx([501333.3, 505500.0, 401000.0])
    wild = 5e5 + 1e5 * (-1.0) ** np.arange(5000)
    assert len(steady_pieces(wild)) == 1
    ramp = 2e5 + 1e3 * np.arange(10_000.0)
    assert MOST_ENTRIES // 2 < len(steady_pieces(ramp)) <= MOST_ENTRIES
