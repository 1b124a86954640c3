# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Instruments read one sample at a time: what they show, and that it repeats."""

import numpy as np
import pytest
from scipy.signal import lsim

from rodless_base.measurement import Measurement
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_sim import Rig, RigParameters
from rodless_sim.instruments import sampling
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.instruments.sampling import Sampling
from rodless_sim.node.engine import Engine

SHEET = RigParameters(DATA_SHEET)
CREEP = 5.6
READ = ("position", "pressure_a", "pressure_b", "supply_pressure")


def truth_of(rig: Rig) -> Measurement:
    """What instruments without errors would read."""
    state = rig.state
    supply = rig.parameters.number("supply.pressure")
    return Measurement(rig.nanoseconds, state.position, state.pressure_a, state.pressure_b, supply)


def run(rig: Rig, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """What is read and what is true while a valve opens, shape (count, 4) each."""
    rig.reset(0.1)
    seen, true = [], []
    for k in range(count):
        if k:
            rig.advance(CREEP, 1e-3)
        seen.append(rig.read())
        true.append(truth_of(rig))
    return np.array(seen)[:, 1:], np.array(true)[:, 1:]


def rig_with(**sensors: float) -> Rig:
    """A rig whose instruments have these errors and no others."""
    return Rig(RigParameters({f"sensors.{name}": value for name, value in sensors.items()}))


def test_ideal_instruments_read_the_truth() -> None:
    """By default nothing is added and nothing is lost, to the last bit, and the stamp is now."""
    seen, true = run(Rig())
    assert np.array_equal(seen, true)
    rig = Rig()
    rig.advance(CREEP, 0.2)
    assert rig.read() == truth_of(rig)
    assert rig.read().stamp == 200_000_000
    assert np.ptp(true[:, 1]) > 1e4


def test_what_is_read_twice_at_one_instant_is_the_same() -> None:
    """A sample that is read again is the sample that was read; after an advance it is another."""
    rig = Rig(SHEET)
    first = rig.read()
    assert rig.read() == first
    assert first.position != rig.state.position
    rig.advance(5.08, 1e-3)
    second = rig.read()
    assert rig.read() == second
    # Nothing has moved at the closed valve: the noise alone is new.
    assert truth_of(rig)[1:] == pytest.approx(truth_of(Rig(SHEET))[1:])
    assert second[1:] != first[1:]


def test_every_reset_repeats_and_another_seed_differs() -> None:
    """The seed alone decides."""
    rig = Rig(SHEET)
    first, _ = run(rig)
    assert np.array_equal(run(rig)[0], first)
    assert np.array_equal(run(Rig(SHEET))[0], first)
    other, _ = run(Rig(SHEET.with_values({"sensors.seed": 2})))
    # The converter's steps are as coarse as the noise, so that some readings are equal by chance.
    assert np.mean(other == first) < 0.2


def test_advances_that_nobody_reads_take_no_noise() -> None:
    """Of a rig read every tenth millisecond the k-th reading has the k-th noise all the same."""
    noisy = {"position_noise": 20e-6, "pressure_noise": 200.0}
    every, tenth = rig_with(**noisy), rig_with(**noisy)
    expected, actual = [], []
    for _ in range(20):
        every.advance(5.08, 1e-3)
        expected.append(np.array(every.read()[1:]) - truth_of(every)[1:])
        for _ in range(10):
            tenth.advance(5.08, 1e-3)
        actual.append(np.array(tenth.read()[1:]) - truth_of(tenth)[1:])
    assert np.array(actual) == pytest.approx(np.array(expected), rel=1e-6, abs=1e-9)
    assert np.ptp(expected, axis=0).min() > 0.0


def test_advance_makes_no_instruments(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rig that nobody reads has none: advance and reset pay for nothing."""
    monkeypatch.setattr(sampling, "instruments_and_noise", None)
    rig = Rig(SHEET)
    rig.advance(CREEP, 0.1)
    rig.configure(SHEET)
    rig.reset()
    with pytest.raises(TypeError):
        rig.read()


def test_noise_is_fresh_each_sample_and_of_the_stated_size() -> None:
    """Without other errors 5000 readings scatter by 20 µm and 200 Pa, one unlike the other."""
    sensors = {"sensors.position_noise": 20e-6, "sensors.pressure_noise": 200.0}
    instruments = Sampling(RigParameters(sensors))
    rows = np.array([instruments.read(Measurement(k, 0.1, 4e5, 4e5, 6e5)) for k in range(5000)])
    scatter = np.std(rows[:, 1:], axis=0)
    assert scatter == pytest.approx([20e-6, 200.0, 200.0, 200.0], rel=0.04)
    together = np.corrcoef(rows[:, 1:].T) - np.eye(4)
    after = [np.corrcoef(column[1:], column[:-1])[0, 1] for column in rows[:, 1:].T]
    assert np.abs([*together.ravel(), *after]).max() < 5.0 / np.sqrt(5000.0)


def test_pressures_come_late_by_the_lag() -> None:
    """Readings obey lag · dp/dt + p = truth, as scipy has it for lines between the samples."""
    lag = 5e-3
    seen, true = run(rig_with(pressure_lag=lag))
    time = 1e-3 * np.arange(len(true))
    for column in (1, 2):
        start = true[0, column]
        due = start + lsim(([1.0], [lag, 1.0]), true[:, column] - start, time)[1]
        assert seen[:, column] == pytest.approx(due, rel=1e-9)
        assert np.abs(seen[:, column] - true[:, column]).max() > 500.0
    assert np.array_equal(seen[:, 0], true[:, 0])


@pytest.mark.parametrize(("period", "error"), [(1e-3, 200.0), (5e-3, 4e3), (1e-2, 7.1e3)])
def test_a_lag_hardly_depends_on_how_often_it_is_read(period: float, error: float) -> None:
    """Against the filter of the true pressures in steps of 10 µs, in the midst of a start."""
    lag, fine = 5e-3, 1e-5
    often, seldom = rig_with(pressure_lag=0.0), rig_with(pressure_lag=lag)
    true = [often.read().pressure_a]
    for _ in range(round(0.1 / fine)):
        often.advance(8.0, fine)
        true.append(often.read().pressure_a)
    time = fine * np.arange(len(true))
    due = true[0] + lsim(([1.0], [lag, 1.0]), np.array(true) - true[0], time)[1]
    seldom.read()
    found = []
    for _ in range(round(0.1 / period)):
        seldom.advance(8.0, period)
        found.append(seldom.read().pressure_a)
    assert found == pytest.approx(due[:: round(period / fine)][1:], abs=error)


def test_a_lag_follows_for_the_plant_time_between_readings() -> None:
    """One reading 6 lags after the first shows what has come since, whatever time.period says."""
    rig = rig_with(pressure_lag=0.05)
    rig.reset(0.05, pressures=(2e5, 2e5))
    rig.read()
    true = rig.advance(7.0, 0.3).pressure_a
    assert true > 6e5
    assert rig.read().pressure_a == pytest.approx(
        true - (true - 2e5) * (1.0 - np.exp(-6.0)) / 6.0, rel=1e-12
    )


def test_fixed_errors_are_fixed() -> None:
    """Bias of a pressure and offset of the position: the same in every sample of every run."""
    seen, true = run(rig_with(pressure_bias=5e-3, position_repeatability=1e-5))
    error = seen - true
    assert np.ptp(error, axis=0) == pytest.approx(np.zeros(4), abs=1e-9)
    assert np.all(np.abs(error[0]) <= [1e-5, 5e3, 5e3, 5e3])
    assert len(np.unique(np.round(error[0, 1:]))) == 3


def test_a_change_while_running_takes_effect_at_once() -> None:
    """From ideal to noisy and back: no reading remembers what came before the change."""
    rig = Rig()
    rig.read()
    true = rig.advance(CREEP, 0.2).pressure_a
    rig.configure(RigParameters({"sensors.pressure_lag": 5e-3}))
    assert rig.read().pressure_a == true
    rig.configure(SHEET)
    assert rig.read().pressure_a != true
    rig.configure(RigParameters())
    assert rig.read() == truth_of(rig)


def test_a_new_seed_begins_anew_and_other_changes_do_not() -> None:
    """Changing a size goes on with the noise where it was; changing the seed starts it again."""
    rig = Rig(SHEET)
    first = rig.read()
    rig.advance(5.08, 1e-3)
    second = rig.read()
    rig.configure(SHEET.with_values({"sensors.flow_noise": 0.0}))
    assert rig.read() == second
    rig.configure(SHEET.with_values({"sensors.seed": 2}))
    rig.configure(SHEET)
    again = rig.read()
    assert [getattr(again, name) for name in READ] == [getattr(first, name) for name in READ]


def test_supply_pressure_is_that_of_the_parameters_in_force() -> None:
    """A change of ``supply.pressure`` is read at once."""
    rig = Rig()
    assert rig.read().supply_pressure == 621325.0
    rig.configure(RigParameters({"supply.pressure": 7e5}))
    assert rig.read().supply_pressure == 7e5


def test_a_reset_repeats_what_is_handed_out() -> None:
    """A run after a reset shows the samples of the run before; a sample offered again is equal."""
    samples: list[tuple[object, ...]] = []
    engine = Engine(SHEET, lambda *sample: samples.append(sample))
    engine.reset()
    for _ in range(50):
        engine.receive(CREEP)
        engine.step()
    engine.offer()
    assert samples[-1] == samples[-2]
    first, samples[:] = samples[:-1], []
    engine.reset()
    for _ in range(50):
        engine.receive(CREEP)
        engine.step()
    assert samples == first
    assert len({str(sample[0]) for sample in samples}) == 51


def test_the_node_hands_out_what_a_rig_reads() -> None:
    """Engine and Rig.read give the same samples of the same commands, noise and lag included."""
    samples: list[Measurement] = []
    engine = Engine(SHEET, lambda seen, _: samples.append(seen))
    engine.offer()
    rig = Rig(SHEET)
    expected = [rig.read()]
    for k in range(100):
        engine.receive(CREEP + 0.01 * k)
        engine.step()
        rig.advance(CREEP + 0.01 * k, 1e-3)
        expected.append(rig.read())
    assert samples == expected


def test_a_closed_loop_sees_what_a_rig_reads() -> None:
    """Fed with the voltages of the run, a rig reads its positions and pressures, bit for bit."""
    reference = references.step(0.0, 0.058, at=0.02)
    found = closed_loop(SHEET, PidParameters(), reference, 0.2, 1e-3)
    rig = Rig(SHEET)
    for k, voltage in enumerate(found.voltage):
        seen = rig.read()
        expected = found.position[k], found.pressure_a[k], found.pressure_b[k]
        assert (seen.position, seen.pressure_a, seen.pressure_b) == expected
        rig.advance(voltage, 1e-3)
    assert np.ptp(found.pressure_a) > 1e4
