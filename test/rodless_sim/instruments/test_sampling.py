"""Instruments read one sample at a time: what they show, and that it repeats."""

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, State
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.instruments.sampling import Sensing
from rodless_sim.node.engine import Engine

SHEET = RigParameters(DATA_SHEET)
SUPPLY = 621325.0
CREEP = 5.6


def readings(sensing: Sensing, count: int = 200) -> np.ndarray:
    """Position, pressures and supply as read while a valve opens, shape (count, 4)."""
    rig = Rig()
    rig.reset(0.1)
    rows = []
    for k in range(count):
        if k:
            rig.advance(CREEP, 1e-3)
            sensing.step()
        seen, supply = sensing.read(rig.state, SUPPLY)
        rows.append((seen.position, seen.pressure_a, seen.pressure_b, supply))
    return np.array(rows)


def truth(count: int = 200) -> np.ndarray:
    """The same without instruments."""
    return readings(Sensing(RigParameters()), count)


def test_ideal_instruments_hand_on_the_state_itself() -> None:
    """Nothing is added, nothing is lost: it is the same object."""
    sensing, state = Sensing(RigParameters()), Rig().state
    assert sensing.read(state, SUPPLY)[0] is state


def test_a_sample_read_twice_reads_the_same() -> None:
    """A sample that is offered again is the sample that was offered, to the last bit."""
    sensing, state = Sensing(SHEET), Rig().state
    sensing.read(state, SUPPLY)
    sensing.step()
    assert sensing.read(state, SUPPLY) == sensing.read(state, SUPPLY)
    assert sensing.read(state, SUPPLY)[0].position != state.position


def test_every_start_repeats_and_another_seed_differs() -> None:
    """The seed alone decides."""
    sensing = Sensing(SHEET)
    first = readings(sensing)
    sensing.start()
    assert np.array_equal(readings(sensing), first)
    assert np.array_equal(readings(Sensing(SHEET)), first)
    other = readings(Sensing(SHEET.with_values({"sensors.seed": 2})))
    # The converter's steps are as coarse as the noise, so that some readings are equal by chance.
    assert np.mean(other == first) < 0.2


def test_noise_is_fresh_each_sample_and_of_the_stated_size() -> None:
    """Without other errors 5000 readings scatter by 20 µm and 200 Pa, one unlike the other."""
    sensing = Sensing(
        RigParameters({"sensors.position_noise": 20e-6, "sensors.pressure_noise": 200.0})
    )
    state = Rig().state
    rows = []
    for _ in range(5000):
        seen, supply = sensing.read(state, SUPPLY)
        rows.append((seen.position, seen.pressure_a, seen.pressure_b, supply))
        sensing.step()
    scatter = np.std(rows, axis=0)
    assert scatter == pytest.approx([20e-6, 200.0, 200.0, 200.0], rel=0.04)
    together = np.corrcoef(np.array(rows).T) - np.eye(4)
    after = [np.corrcoef(column[1:], column[:-1])[0, 1] for column in np.array(rows).T]
    assert np.abs([*together.ravel(), *after]).max() < 5.0 / np.sqrt(5000.0)


def test_pressures_come_late_by_the_lag() -> None:
    """Readings obey lag · dp/dt + p = truth: the exact answer to a truth held between samples."""
    lag = 5e-3
    seen = readings(Sensing(RigParameters({"sensors.pressure_lag": lag})))
    true = truth()
    keep = np.exp(-1e-3 / lag)
    for column in (1, 2):
        assert seen[0, column] == true[0, column]
        due = true[:-1, column] + (seen[:-1, column] - true[:-1, column]) * keep
        assert seen[1:, column] == pytest.approx(due, rel=1e-12)
        assert np.abs(seen[:, column] - true[:, column]).max() > 500.0
    assert np.array_equal(seen[:, 0], true[:, 0])


def test_fixed_errors_are_fixed() -> None:
    """Bias of a pressure and offset of the position: the same in every sample of every run."""
    bounds = {"sensors.pressure_bias": 5e-3, "sensors.position_repeatability": 1e-5}
    error = readings(Sensing(RigParameters(bounds))) - truth()
    assert np.ptp(error, axis=0) == pytest.approx(np.zeros(4), abs=1e-9)
    assert np.all(np.abs(error[0]) <= [1e-5, 5e3, 5e3, 5e3])
    assert len(np.unique(np.round(error[0, 1:]))) == 3


def test_force_is_that_of_the_pressures_read() -> None:
    """Eq. (30)'s A (P_a - P_b) with the readings; speed and flows stay those of the rig."""
    state: State = Rig().advance(CREEP, 0.2)
    seen, _ = Sensing(SHEET).read(state, SUPPLY)
    assert seen.force == pytest.approx(4.908739e-4 * (seen.pressure_a - seen.pressure_b))
    assert seen.force != state.force
    assert (seen.velocity, seen.mass_flow_a) == (state.velocity, state.mass_flow_a)


def test_a_change_while_running_takes_effect_at_once() -> None:
    """From ideal to noisy and back: no reading remembers what came before the change."""
    sensing, rig = Sensing(RigParameters()), Rig()
    sensing.read(rig.state, SUPPLY)
    state = rig.advance(CREEP, 0.2)
    sensing.step()
    sensing.configure(RigParameters({"sensors.pressure_lag": 5e-3}))
    assert sensing.read(state, SUPPLY)[0].pressure_a == state.pressure_a
    sensing.configure(SHEET)
    assert sensing.read(state, SUPPLY)[0].pressure_a != state.pressure_a
    sensing.configure(RigParameters())
    assert sensing.read(state, SUPPLY) == (state, SUPPLY)


def test_a_new_seed_begins_anew_and_other_changes_do_not() -> None:
    """Changing a size goes on with the noise where it was; changing the seed draws it again."""
    sensing, state = Sensing(SHEET), Rig().state
    first = sensing.read(state, SUPPLY)
    sensing.step()
    second = sensing.read(state, SUPPLY)
    sensing.configure(SHEET.with_values({"sensors.flow_noise": 0.0}))
    assert sensing.read(state, SUPPLY) == second
    sensing.configure(SHEET.with_values({"sensors.seed": 2}))
    sensing.configure(SHEET)
    assert sensing.read(state, SUPPLY) == first


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
    assert len({str(sample[1]) for sample in samples}) == 51
