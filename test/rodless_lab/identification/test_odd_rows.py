# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rows of numbers that are none are refused in one line that names the argument."""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from rodless_lab.identification import (
    MeasuredRun,
    RunError,
    auxiliary_lines,
    fit_area_curve,
    fit_flow_coefficient,
    fit_friction,
    friction_force,
    stick_slip_events,
    three_sines,
    uniform_parts,
)
from rodless_lab.identification.friction.curve import Stribeck

SPEEDS = np.linspace(1e-3, 0.1, 30)
FORCES = 12.0 + 4500.0 * SPEEDS
VOLTS = np.linspace(0.1, 4.9, 30)
TIME = np.arange(1000) * 1e-3

Rows = Mapping[str, Any]


def force_at(speed: Any) -> object:
    """Return the friction of a curve at a speed."""
    return friction_force(Stribeck(29.0, 12.0, 1.3e-3, 4500.0), speed)


# Functions, and for each row they take a good one.
GOOD: list[tuple[Callable[..., object], Rows]] = [
    (auxiliary_lines, {"speeds": SPEEDS, "forces": FORCES}),
    (fit_area_curve, {"voltages": VOLTS, "areas": 1e-7 * VOLTS}),
    (fit_area_curve, {"voltages": VOLTS, "areas": 1e-7 * VOLTS, "start": np.arange(1.0, 10.0)}),
    (three_sines, {"coefficients": np.arange(1.0, 10.0), "voltage": VOLTS}),
    (
        fit_flow_coefficient,
        {"deflections": VOLTS, "coefficients": 1.1 - 0.01 * VOLTS, "weights": np.ones(30)},
    ),
    (fit_flow_coefficient, {"deflections": VOLTS, "coefficients": 1.1 - 0.01 * VOLTS}),
    (
        fit_friction,
        {
            "speeds": SPEEDS,
            "forces": FORCES,
            "speed_errors": np.full(30, 1e-6),
            "force_errors": np.ones(30),
            "breakaways": np.full(5, 30.0),
            "breakaway_errors": np.ones(5),
            "stops": np.full(5, 22.0),
            "stop_errors": np.ones(5),
        },
    ),
    (force_at, {"speed": SPEEDS}),
    (stick_slip_events, {"time": TIME, "position": 0.01 * TIME, "force": TIME}),
    (uniform_parts, {"time": TIME, "position": 0.01 * TIME}),
]


def odd(row: Any) -> Iterator[tuple[object, str]]:
    """Yield what is given in place of a good row, and what is said of it after its name."""
    spoilt = {value: np.where(np.arange(len(row)) == 3, value, row) for value in (np.nan, 1e300)}
    none = r" .*refused: must be numbers \(.+\)$"
    yield spoilt[np.nan], ": value 3 is nan, must be finite$"
    yield spoilt[1e300], r": value 3 is 1e\+300, must be 1e\+20 or less in size$"
    yield np.ma.masked_array(row, np.arange(len(row)) == 3), r".*some are masked"
    yield [*row[:3], np.ma.masked, *row[4:]], r".*some are masked"
    yield row.astype(str), none
    yield row + 0j, none
    yield row > 0.0, none
    yield [True, *row[1:]], none
    yield [object(), *row[1:]], none
    yield [[9, 5.08], *row[1:]], none


@pytest.mark.parametrize(
    ("function", "rows"), GOOD, ids=lambda value: getattr(value, "__name__", "")
)
def test_what_is_no_row_of_numbers_is_named(function: Callable[..., object], rows: Rows) -> None:
    """Whichever the row, and whatever is wrong: one line, its name first."""
    function(**rows)
    for name, row in rows.items():
        for given, said in odd(row):
            with pytest.raises(ValueError, match=f"^{name}{said}") as refusal:
                function(**{**rows, name: given})
            assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("function", "rows"), GOOD, ids=lambda value: getattr(value, "__name__", "")
)
def test_rows_of_other_shapes_are_named(function: Callable[..., object], rows: Rows) -> None:
    """A table, and one that is shorter than the row that it belongs to."""
    for name, row in rows.items():
        if name in ("voltage", "speed"):  # of any shape
            continue
        with pytest.raises(ValueError, match=rf"^{name}: of shape \(1, {len(row)}\), must be"):
            function(**{**rows, name: row[None]})
        # Of two rows that do not belong together the second is named.
        named = r"\w+" if name in ("breakaways", "stops", next(iter(rows))) else name
        with pytest.raises(ValueError, match=rf"^{named}: \d+ values"):
            function(**{**rows, name: row[:-1]})


def test_lists_and_fractions_are_numbers() -> None:
    """What numpy makes the same floats of gives the same result."""
    lines = auxiliary_lines(SPEEDS, FORCES, 30.0)
    assert auxiliary_lines(list(SPEEDS), list(map(Fraction, FORCES)), Fraction(30)) == lines
    assert uniform_parts(list(TIME), list(0.01 * TIME)) == uniform_parts(TIME, 0.01 * TIME)


def test_one_error_stands_for_all_and_none_is_negative() -> None:
    """A single number is as good as a row of it."""
    one, all_alike = (fit_friction(SPEEDS, FORCES, force_errors=e) for e in (0.1, [0.1] * 30))
    assert one.forward.viscous == all_alike.forward.viscous
    with pytest.raises(ValueError, match=r"^force_errors: -0.1 refused, must not be negative"):
        fit_friction(SPEEDS, FORCES, force_errors=-0.1)


@pytest.mark.parametrize("name", ["allowance", "force_bias", "speed_stretch"])
@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf])
def test_a_bound_that_is_none_is_named(name: str, value: float) -> None:
    """What all points may be off together is a size."""
    bounds: dict[str, Any] = {name: value}
    with pytest.raises(ValueError, match=rf"^{name} .* refused: must be from 0 to 1e\+20$"):
        fit_friction(SPEEDS, FORCES, **bounds)


def test_weights_below_zero_are_refused() -> None:
    """And a point whose weight is 0 is as good as none: the rest says what it says alone."""
    good, values = VOLTS, 1.1 - 0.01 * VOLTS + 1e-3 * np.cos(40.0 * VOLTS)
    with pytest.raises(ValueError, match=r"^weights: -1 refused, must not be negative$"):
        fit_flow_coefficient(good, values, np.where(VOLTS > 4.0, -1.0, 1.0))
    wild = np.where(VOLTS > 4.0, 100.0, values)
    without = fit_flow_coefficient(good, wild, (VOLTS <= 4.0) * 2.0)
    alone = fit_flow_coefficient(good[VOLTS <= 4.0], values[VOLTS <= 4.0])
    for found, expected in zip(without.coefficients, alone.coefficients, strict=True):
        assert found.value == pytest.approx(expected.value, rel=1e-6)
        assert found.half_width == pytest.approx(expected.half_width, rel=1e-6)


def test_points_of_one_speed_give_no_line() -> None:
    """The fit says that nothing is informed and why; the construction is refused."""
    fit = fit_friction(np.full(5, 0.01), np.linspace(50.0, 60.0, 5), force_errors=0.1)
    assert "have one speed" in fit.forward.viscous.note
    assert not fit.forward.viscous.informed
    assert fit.forward.auxiliary is None
    with pytest.raises(ValueError, match=r"^speeds: the faster ones are all 0.01 m/s"):
        auxiliary_lines([0.001, 0.01, 0.01, 0.01], [1.0, 2.0, 3.0, 4.0])


def test_forces_that_rise_to_their_minimum_draw_no_f_1() -> None:
    """Left of the least force the line through 10, 30, 40 and 9 N does not fall."""
    lines = auxiliary_lines([1e-3, 2e-3, 3e-3, 3.1e-3, 10e-3], [9.5, 30.0, 40.0, 9.0, 50.0])
    assert "does not fall" in lines.note
    assert np.isnan(lines.static)


@pytest.mark.parametrize(
    "search", [uniform_parts, lambda time, position: stick_slip_events(time, position, position)]
)
def test_time_must_be_even(search: Callable[..., object]) -> None:
    """As that of a run: instants that are equal, go back or are missing, or too few."""
    for time, said in (
        (np.round(TIME, 2), "time does not increase at sample 1$"),
        (TIME[::-1], "time does not increase at sample 1$"),
        (np.delete(TIME, 500), "time: sample 500 comes 0.002 s after the one before"),
        (TIME[:1], "only 1 samples, too few for a run"),
        ([], "only 0 samples, too few for a run"),
    ):
        with pytest.raises(RunError, match=said):
            search(time, np.arange(len(time)) * 1e-5)


@pytest.mark.parametrize("value", [np.nan, 0.0, -1.0])
def test_a_window_that_is_none_is_named(value: float) -> None:
    """Of no length; a window beyond the run is too long for it, and a lag has to be a time."""
    with pytest.raises(ValueError, match=r"^window .* refused: must be positive"):
        uniform_parts(TIME, TIME, window=value)
    with pytest.raises(ValueError, match=r"^tolerance .* refused: must be positive"):
        uniform_parts(TIME, TIME, tolerance=value)
    with pytest.raises(ValueError, match="shorter than one window of inf s"):
        uniform_parts(TIME, TIME, window=np.inf)
    with pytest.raises(ValueError, match=r"^lag .* s refused: must be from 0 to"):
        stick_slip_events(TIME, TIME, TIME, lag=value or np.inf)
    with pytest.raises(TypeError, match=r"^window 'long' refused: must be a number of seconds"):
        uniform_parts(TIME, TIME, window="long")  # type: ignore[arg-type]


def test_a_run_with_masked_samples_is_refused() -> None:
    """Their values would be taken as measured; a mask that hides none is none."""
    plain = np.full(1000, 3e5)
    masked = np.ma.masked_array(plain, TIME > 0.5)
    with pytest.raises(RunError, match=r"^pressure_a: some samples are masked"):
        MeasuredRun(TIME, TIME, masked, plain, plain, plain)
    MeasuredRun(TIME, TIME, np.ma.masked_array(plain, TIME < 0.0), plain, plain, plain)
