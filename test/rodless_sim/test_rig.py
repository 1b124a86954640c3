# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig as its users drive it: advance, reset, configure, simulate."""

import copy
import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from every_option import BRISTLES, SPOOL, TUBES

from rodless_sim import ParameterError, Rig, RigParameters, Scenario, State, simulate

VOLTAGES = np.concatenate([np.full(300, 6.0), np.full(200, 5.08), np.full(300, 3.5)])


def driven_rig() -> Rig:
    """A rig in full motion."""
    rig = Rig()
    rig.reset(0.05)
    rig.advance(6.0, 0.3)
    return rig


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
def test_advancing_in_pieces_equals_one_simulation_exactly(form: str) -> None:
    """Milliseconds through Rig.advance give the samples of simulate(), bit for bit."""
    parameters = RigParameters({"friction.form": form})
    trace = simulate(parameters, VOLTAGES, 1e-3, 0.05)
    rig = Rig(parameters)
    rig.reset(0.05)
    pieces = [rig.advance(voltage, 1e-3) for voltage in VOLTAGES]
    for name in ("time", "position", "velocity", "pressure_a", "pressure_b", "force"):
        assert [getattr(state, name) for state in pieces] == getattr(trace, name)[1:].tolist()
    assert pieces[-1].mass_flow_a == trace.mass_flow_a[-1]
    assert pieces[-1].mass_flow_b == trace.mass_flow_b[-1]
    assert np.ptp(trace.position) > 5e-3


def test_time_is_counted_without_drift() -> None:
    """Ten thousand pieces of 0.1 ms are exactly one second."""
    rig = Rig()
    for _ in range(10_000):
        rig.advance(5.08, 1e-4)
    assert rig.nanoseconds == 1_000_000_000
    assert rig.state.time == 1.0


def test_reset_repeats_a_run_exactly() -> None:
    """After a reset the same commands give the same states, whatever happened before."""
    rig = Rig()
    rig.reset(0.05)
    first = [rig.advance(voltage, 1e-3) for voltage in VOLTAGES]
    rig.reset(0.05)
    assert [rig.advance(voltage, 1e-3) for voltage in VOLTAGES] == first


def test_reset_puts_the_rig_at_rest_where_it_is_told() -> None:
    """Time zero, no speed, valve closed, equal pressures; the default place is a parameter."""
    rig = driven_rig()
    state = rig.reset(0.12)
    assert (state.time, state.position, state.velocity, state.voltage) == (0.0, 0.12, 0.0, 5.08)
    assert state.pressure_a == pytest.approx(state.pressure_b, rel=1e-9)
    assert Rig(RigParameters({"cylinder.initial_position": 0.07})).reset().position == 0.07


@pytest.mark.parametrize("position", [-1e-6, 0.2001, math.nan, math.inf])
def test_reset_outside_the_stroke_is_refused(position: float) -> None:
    """A place the carriage cannot have is refused by its value, and the rig stays as it is."""
    rig = driven_rig()
    before = rig.state
    with pytest.raises(ValueError, match="outside the stroke"):
        rig.reset(position)
    assert rig.state == before


@pytest.mark.parametrize("pressures", [(math.nan, 1e5), (2e5, math.inf), (0.0, 1e5), (2e5, -1.0)])
def test_pressures_that_no_chamber_has_are_refused(pressures: tuple[float, float]) -> None:
    """NaN, infinity, zero and below: refused by value, in one line, and the rig stays as it is."""
    rig = driven_rig()
    before = rig.state
    with pytest.raises(ValueError, match=r"^pressures .* Pa refused: must be finite and positive$"):
        rig.reset(0.1, pressures)
    assert rig.state == before
    with pytest.raises(ValueError, match=repr(pressures[1])):
        simulate(RigParameters(), [5.0], 1e-3, pressures=pressures)


def test_reset_takes_pressures_as_any_pair_of_numbers() -> None:
    """A tuple of integers and an array of NumPy start the same run."""
    starts = [Rig().reset(0.1, pair) for pair in ((300_000, 200_000), np.array([3e5, 2e5]))]
    assert starts[0] == starts[1]
    assert (starts[0].pressure_a, starts[0].pressure_b) == (3e5, 2e5)


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda rig: pickle.loads(pickle.dumps(rig))]
)
def test_a_copied_rig_goes_on_bit_for_bit(copied: Callable[[Rig], Rig]) -> None:
    """With its noise, its parameters, its scenario and its state; a copy goes its own way."""
    parameters = RigParameters({"sensors.position_noise": 20e-6, "friction.form": "saturating"})
    rig = Rig(parameters, Scenario([(0.25, {"fault.valve.offset": 0.5})]))
    rig.advance(7.0, 0.2)
    rig.read()
    twin = copied(rig)
    # One after the other: what they shared, the second would find used up.
    seen = [(one.advance(6.0, 0.1), one.read(), one.parameters, one.played) for one in (rig, twin)]
    assert seen[0] == seen[1]
    assert len(twin.played) == 1
    assert repr(twin) == repr(rig)
    twin.advance(4.0, 0.1)
    assert twin.state != rig.state


@pytest.mark.parametrize("options", [TUBES, {**SPOOL, "valve.dead_time": 3e-3}, BRISTLES])
def test_a_command_or_a_change_of_nothing_leaves_no_trace(options: dict[str, object]) -> None:
    """Time stands still in either: a run without them is the same bit for bit."""
    parameters = RigParameters({"cylinder.initial_position": 0.06, **options})
    plain, asked = Rig(parameters), Rig(parameters)
    for step in range(300):
        voltage = 6.5 if step < 150 else 3.5
        for _ in range(step % 3):
            asked.command(voltage)
        if step % 5 == 0:
            asked.configure(parameters)
        assert asked.advance(voltage, 1e-3) == plain.advance(voltage, 1e-3)
    assert abs(plain.state.position - 0.06) > 1e-3


def test_a_rig_of_no_parameters_is_refused() -> None:
    """A dict is no set of parameters: the error says what to give."""
    with pytest.raises(TypeError, match=r"are no RigParameters: give RigParameters\({\.\.\.}\)$"):
        Rig({"supply.pressure": 6e5})  # type: ignore[arg-type]


def test_configure_keeps_the_state() -> None:
    """New parameters take hold without moving carriage, air or time; the next step feels them."""
    rig = driven_rig()
    before = rig.state
    changed = rig.parameters.with_values({"supply.pressure": 0.7e6})
    rig.configure(changed)
    after = rig.state
    assert rig.parameters == changed
    for name in ("time", "position", "velocity", "pressure_a", "pressure_b", "voltage"):
        assert getattr(after, name) == getattr(before, name)
    assert after.mass_flow_a > before.mass_flow_a


def test_a_stroke_that_ends_before_the_carriage_is_refused() -> None:
    """One line with both lengths; parameters and state stay, and at its very end it may stand."""
    rig = Rig()
    rig.reset(0.058)
    parameters, state = rig.parameters, rig.state
    with pytest.raises(ParameterError, match=r"^cylinder\.stroke: 0\.02 m refused, .* 0\.058 m; "):
        rig.configure(parameters.with_values({"cylinder.stroke": 0.02}))
    assert (rig.parameters, rig.state) == (parameters, state)
    assert rig.plant.cylinder.stroke == parameters["cylinder.stroke"]
    rig.configure(parameters.with_values({"cylinder.stroke": 0.058}))
    assert rig.advance(10.0, 1.0).position == 0.058


@pytest.mark.parametrize("voltage", [math.nan, math.inf, -math.inf])
def test_a_voltage_that_is_no_number_is_refused(voltage: float) -> None:
    """NaN and infinities raise, and carriage, air, time and the last command stay untouched."""
    rig = driven_rig()
    before = rig.state
    with pytest.raises(ValueError, match="voltage"):
        rig.advance(voltage, 1e-3)
    assert rig.state == before


@pytest.mark.parametrize(
    ("voltage", "applied"), [(12.0, 10.0), (1e308, 10.0), (-3.0, 0.0), (-1e308, 0.0)]
)
def test_a_voltage_out_of_range_saturates(voltage: float, applied: float) -> None:
    """The valve takes at least 0 V and at most 10 V, and the state says which it took."""
    beyond, at_limit = driven_rig(), driven_rig()
    assert beyond.advance(voltage, 0.05) == at_limit.advance(applied, 0.05)
    assert beyond.state.voltage == applied


@pytest.mark.parametrize("duration", [0.0, -1e-3, math.nan, math.inf, 1e-10])
def test_a_duration_that_is_not_positive_is_refused(duration: float) -> None:
    """Zero, negative, endless and sub-nanosecond durations raise and change nothing."""
    rig = driven_rig()
    before = rig.state
    with pytest.raises(ValueError, match="duration"):
        rig.advance(6.0, duration)
    assert rig.state == before


def test_simulate_refuses_what_advance_refuses() -> None:
    """A NaN among the voltages, no voltages, a bad period and a bad place raise ValueError."""
    parameters = RigParameters()
    for voltages, period, position in (
        ([5.0, math.nan], 1e-3, None),
        ([], 1e-3, None),
        ([5.0], 0.0, None),
        ([5.0], 1e-3, 0.3),
    ):
        with pytest.raises(ValueError, match=r"refused|no voltages"):
            simulate(parameters, voltages, period, position)


def test_a_trace_has_a_sample_more_than_voltages_and_names_them_like_a_state() -> None:
    """Sample 0 is the start, every array has n + 1 entries, voltages are those the valve took."""
    trace = simulate(RigParameters(), [5.08, 11.0, 6.0], 1e-3, 0.1)
    for name in State._fields:
        assert getattr(trace, name).shape == (4,)
    assert trace.time == pytest.approx([0.0, 1e-3, 2e-3, 3e-3])
    assert trace.voltage.tolist() == [5.08, 10.0, 6.0, 6.0]
    assert trace.position[0] == 0.1


def test_force_is_area_times_pressure_difference() -> None:
    """State and trace agree on A·(P_a - P_b) with A = 490.874 mm²."""
    state = driven_rig().state
    by_hand = 490.8738521e-6 * (state.pressure_a - state.pressure_b)
    assert state.force == pytest.approx(by_hand, rel=1e-9)
    assert state.force > 10.0


def test_air_is_drawn_from_the_supply_and_stated_as_free_air() -> None:
    """A settled closed valve draws 2·k(P_s² - P²): 0.72 L/min of free air at 0.52 MPa.

    k = 5.4369e-17 kg/(s·Pa²), P_s² - P² = (P_s² - P_e²)/2 = 187.9e9 Pa², and 1 kg of air takes
    287.05·293.15/101325 = 0.83049 m³: 2 · 5.4369e-17 · 187.9e9 · 0.83049 m³/s.
    """
    half_difference = (621325.0**2 - 101325.0**2) / 2.0
    assert half_difference == pytest.approx(187.9e9, rel=1e-3)
    assert Rig().free_air_flow == pytest.approx(
        2.0 * 5.4369e-17 * half_difference * 0.83049, rel=1e-4
    )


def test_the_tolerance_bounds_the_error() -> None:
    """Each hundredth of the tolerance gives a tenth of the error or less, against 1e-3 of it."""
    voltages = np.repeat([6.0, 5.3, 4.5], 100)
    loose, tight, exact = (
        simulate(RigParameters({"time.tolerance": tolerance}), voltages, 1e-3, 0.1).position
        for tolerance in (10.0, 0.1, 1e-3)
    )
    assert np.ptp(exact) > 1e-3
    assert 0.0 < np.abs(tight - exact).max() < 0.1 * np.abs(loose - exact).max() < 1e-6
