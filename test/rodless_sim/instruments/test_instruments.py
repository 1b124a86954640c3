# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Instruments against what their data sheets say of them."""

import math

import numpy as np
import pytest

from rodless_sim import RigParameters, simulate
from rodless_sim.instruments.instruments import DATA_SHEET, IDEAL, Instruments, read_trace
from rodless_sim.instruments.transmitter import Transmitter, converted, is_ideal, lagged, read

SHEET = RigParameters(DATA_SHEET)
RUN = simulate(RigParameters(), [5.6] * 300, 1e-3, position=0.1)


def test_ideal_instruments_read_the_truth() -> None:
    """By default nothing is added: the measured run is the run, bit for bit."""
    seen = read_trace(RUN, RigParameters(), np.random.default_rng(1))
    for name in ("time", "position", "pressure_a", "pressure_b", "voltage"):
        assert np.array_equal(getattr(seen, name), getattr(RUN, name)), name


def test_what_no_instrument_measures_is_nan() -> None:
    """The rig has no speed sensor and no mass-flow meter in the lines: those columns are NaN."""
    seen = read_trace(RUN, SHEET, np.random.default_rng(1))
    for name in ("velocity", "mass_flow_a", "mass_flow_b"):
        assert np.isnan(getattr(seen, name)).all()


def test_force_is_that_of_the_pressures_read() -> None:
    """Eq. (30) on the readings, with the bore's area: 25 mm is 4.9087e-4 m²."""
    seen = read_trace(RUN, SHEET, np.random.default_rng(1))
    assert seen.force == pytest.approx(4.908739e-4 * (seen.pressure_a - seen.pressure_b))


def test_noise_has_the_stated_size() -> None:
    """20 µm and 200 Pa, over 20 000 samples within 3 %; the converter adds its own steps."""
    generator = np.random.default_rng(2)
    tools = Instruments.specimen(SHEET, generator)
    position = tools.position.measure(np.full(20_000, 0.1), 1e-3, generator)
    pressure = tools.pressure_a.measure(np.full(20_000, 4e5), 1e-3, generator)
    # Rounding to steps d adds d²/12: 15.3 µm and 76 Pa per bit.
    assert np.std(position) == pytest.approx(np.hypot(20e-6, 15.26e-6 / 12**0.5), rel=0.03)
    assert np.std(pressure) == pytest.approx(np.hypot(200.0, 76.3 / 12**0.5), rel=0.03)


def test_converter_rounds_to_305_microvolt() -> None:
    """16 bits over 20 V; 4 V stand for the range, so a step is 15.26 µm of 200 mm."""
    values = np.linspace(0.0, 0.2, 40_001)
    steps = np.diff(np.unique([converted(value, 0.2, 16) for value in values]))
    assert steps == pytest.approx(20.0 / 65536 / 4.0 * 0.2, rel=1e-6)


def test_an_instrument_saturates_at_its_range() -> None:
    """3.8 to 20.5 mA of 4-20 mA (NAMUR NE 43): -1.25 % to 103.125 % of the range, and no further.

    With every error and at any size.
    """
    sensor = Transmitter(0.2, offset=1e-5, noise=2e-5, nonlinearity=1e-4, bits=16)
    step = 20.0 / 65536 / 4.0 * 0.2
    for value in (0.3, 2.0, 1e9):
        assert read(sensor, value, value, 1.0) == pytest.approx(0.20625, abs=step)
        assert read(sensor, -value, -value, 1.0) == pytest.approx(-0.0025, abs=step)
    within = sensor.measure(np.linspace(0.0, 0.2, 101), 1e-3, np.random.default_rng(1))
    assert np.abs(within - np.linspace(0.0, 0.2, 101)).max() < 3e-4


def test_what_is_not_a_number_stays_none() -> None:
    """With a converter of any number of bits, with and without errors."""
    for bits in (0, 12, 16):
        assert math.isnan(read(Transmitter(1e6, noise=200.0, bits=bits), math.nan, math.nan, 0.3))
        assert math.isnan(converted(math.nan, 1e6, bits))
    assert math.isnan(read(Transmitter(1e6), math.nan, math.nan, 0.3))


def test_an_ideal_instrument_has_no_range() -> None:
    """Without errors it shows what is, on a longer cylinder and at a higher pressure too."""
    assert read(Transmitter(0.2), 1.5, 1.5, 1.0) == 1.5
    assert is_ideal(Transmitter(0.2))
    assert not is_ideal(Transmitter(0.2, lag=1e-3))
    longer = RigParameters({"cylinder.stroke": 0.6, "sensors.position_noise": 1e-6})
    sensor = Instruments.specimen(longer, np.random.default_rng(1)).position
    assert read(sensor, 0.5, 0.5, 0.0) == pytest.approx(0.5, abs=1e-9)


def test_ideal_instruments_have_no_error_on_any_preset() -> None:
    """Nothing of what the data sheet states is left of those of ``calibrated``."""
    preset = RigParameters.preset("calibrated")
    assert IDEAL.keys() == DATA_SHEET.keys()
    assert not any(map(is_ideal, Instruments.specimen(preset, np.random.default_rng(1))))
    ideal = Instruments.specimen(preset.with_values(IDEAL), np.random.default_rng(1))
    assert all(map(is_ideal, ideal))


def test_fixed_errors_stay_within_the_data_sheet_and_use_it() -> None:
    """Bias 0.5 % of 1 MPa, nonlinearity 0.05 % of 200 mm: never more, often near it."""
    specimens = [Instruments.specimen(SHEET, np.random.default_rng(seed)) for seed in range(300)]
    biases = np.array([tools.pressure_a.offset for tools in specimens])
    nonlinearities = np.array([tools.position.nonlinearity for tools in specimens])
    assert 4.8e3 < np.abs(biases).max() <= 5e3
    assert 0.95e-4 < np.abs(nonlinearities).max() <= 1e-4
    assert abs(np.mean(biases)) < 600.0


def test_sensors_of_a_rig_differ_from_each_other() -> None:
    """Each of the three pressure sensors has a bias of its own."""
    tools = Instruments.specimen(SHEET, np.random.default_rng(3))
    offsets = {tools.pressure_a.offset, tools.pressure_b.offset, tools.supply_pressure.offset}
    assert len(offsets) == 3


def test_lag_follows_a_ramp_one_time_constant_late() -> None:
    """A first-order lag of 5 ms reads a ramp of 1 Pa/ms 5 Pa low, however often it is read."""
    for period in (1e-4, 1e-3, 1e-2):
        ramp = 1e3 * period * np.arange(200.0 * 1e-3 / period + 1.0)
        late = ramp - lagged(ramp, period, 5e-3)
        time = period * np.arange(ramp.size)
        assert late == pytest.approx(5.0 * (1.0 - np.exp(-time / 5e-3)), abs=1e-9)


def test_lag_follows_a_sine_as_the_transfer_function_has_it() -> None:
    """At 10 Hz, read at 1 kHz: 1/(1 + iωτ) in amplitude and phase, to what straight lines make."""
    time = 1e-3 * np.arange(1000)
    omega, lag = 2.0 * np.pi * 10.0, 5e-3
    late = lagged(np.sin(omega * time), 1e-3, lag)
    due = np.imag(np.exp(1j * omega * time) / (1.0 + 1j * omega * lag))
    assert np.abs(late - due)[100:].max() < omega**2 * 1e-3**2 / 8.0


def test_same_seed_same_reading() -> None:
    """The generator is the only source of chance."""
    first, second = (read_trace(RUN, SHEET, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(first.position, second.position)
    assert np.array_equal(first.pressure_b, second.pressure_b)


def test_flow_meter_reads_within_its_gain_error() -> None:
    """Without noise a reading of 100 L/min is within 1 % of it, the same for every sample."""
    tools = Instruments.specimen(SHEET, np.random.default_rng(5))
    quiet = Transmitter(tools.volume_flow.span, gain_error=tools.volume_flow.gain_error)
    seen = quiet.measure(np.full(10, 100.0 / 6e4), 1e-3, np.random.default_rng(0)) * 6e4
    assert np.ptp(seen) == 0.0
    assert 0.0 < abs(seen[0] - 100.0) <= 1.0
