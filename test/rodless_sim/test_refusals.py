# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a rig refuses is said in one line, and leaves the rig as it was."""

import math
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from rodless_base.one_line import shown
from rodless_sim import ParameterError, Rig, RigParameters, SimulationError, Trace, simulate
from rodless_sim.physics import settled
from rodless_sim.physics.equations import Inflows
from rodless_sim.physics.lands import Edge, Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import Inflow
from rodless_sim.physics.state import Motion


@pytest.fixture(scope="module")
def rig() -> Rig:
    """A rig in motion, of noisy instruments that have been read."""
    rig = Rig(RigParameters({"sensors.position_noise": 20e-6}))
    rig.reset(0.15)
    rig.read()
    rig.advance(6.0, 0.3)
    return rig


def seen(rig: Rig) -> tuple[object, ...]:
    """All that a refusal could have changed."""
    return rig.state, rig.parameters, rig.plant, rig.motion, rig.read(), repr(rig)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ((0.1, (-5, math.nan)), "pressures -5.0 and nan Pa refused"),
        ((0.1, (0, 0)), "pressures 0.0 and 0.0 Pa refused"),
        ((0.1, (1e5,)), "must be two numbers of Pa"),
        ((0.1, (1e5, 1e5, 1e5)), "must be two numbers of Pa"),
        ((0.1, 5), "must be two numbers of Pa"),
        ((0.1, (10**400, 1e5)), "pressures inf and 100000.0 Pa refused"),
        ((0.1, (1e18, 1e200)), "refused: no chamber holds more than 1e+150 Pa"),
        ((0.1, {621325.0, 101325.0}), "must be two numbers of Pa"),
        ((0.1, {1e5: "a", 2e5: "b"}), "must be two numbers of Pa"),
        ((0.1, b"ab"), "must be two numbers of Pa"),
        ((0.1, (True, 1e5)), "must be two numbers of Pa"),
        ((0.1, ("1e5", 1e5)), "must be two numbers of Pa"),
        (("x",), "position 'x' refused"),
        ((10**400,), "outside the stroke, must be from 0 to 0.2 m"),
        ((True,), "position True refused: must be a number of metres"),
        ((math.nan,), "outside the stroke, must be from 0 to 0.2 m"),
    ],
)
def test_a_reset_that_is_refused_changes_nothing(
    rig: Rig, arguments: tuple[object, ...], complaint: str
) -> None:
    """Neither time nor state; simulate refuses the same."""
    before = seen(rig)
    with pytest.raises((ValueError, TypeError)) as refusal:
        rig.reset(*arguments)  # type: ignore[arg-type]
    assert complaint in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert seen(rig) == before
    with pytest.raises((ValueError, TypeError), match=r"refused"):
        simulate(RigParameters(), [6.0], 1e-3, *arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("parameters", [{}, None, 5])
def test_what_are_no_parameters_are_refused_and_change_nothing(
    rig: Rig, parameters: object
) -> None:
    """By the rig and by simulate."""
    before = seen(rig)
    with pytest.raises(TypeError, match="are no RigParameters: give RigParameters"):
        rig.configure(parameters)  # type: ignore[arg-type]
    assert seen(rig) == before
    with pytest.raises(TypeError, match="are no RigParameters: give RigParameters"):
        simulate(parameters, [6.0], 1e-3)  # type: ignore[arg-type]


def test_a_stroke_that_ends_before_the_carriage_is_refused(rig: Rig) -> None:
    """The rig goes on as one that was never asked."""
    short = rig.parameters.with_values({"cylinder.stroke": 0.1})
    before = seen(rig)
    with pytest.raises(ParameterError, match=r"^cylinder\.stroke: 0\.1 m refused, the carriage is"):
        rig.configure(short)
    assert seen(rig) == before


def test_a_change_that_fails_halfway_is_taken_back(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever fails, and wherever: here the instruments."""
    before = seen(rig)

    def fail(_parameters: RigParameters) -> None:
        raise ValueError("no such instrument")

    monkeypatch.setattr(rig._sampling, "configure", fail)
    with pytest.raises(ValueError, match="no such instrument"):
        rig.configure(rig.parameters.with_values({"supply.pressure": 4e5}))
    assert seen(rig) == before


@pytest.mark.parametrize(
    ("period", "kind"),
    [("x", TypeError), (None, TypeError), (-1.0, ValueError), (1e300, ValueError)],
)
def test_a_bad_time_is_refused_by_its_own_name(
    rig: Rig, period: object, kind: type[Exception]
) -> None:
    """A period is called a period, a duration a duration."""
    with pytest.raises(kind, match=r"^period .* refused"):
        simulate(RigParameters(), [6.0], period)  # type: ignore[arg-type]
    with pytest.raises(kind, match=r"^duration .* refused"):
        rig.advance(6.0, period)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "voltages",
    [
        ["a"],
        [[1.0], [2.0, 3.0]],
        [slice(1)],
        "555",
        ["0.1"],
        np.array(["0.1", 5.0], dtype=object),
        True,
        [5.0, True],
        np.array([True, False]),
        [1 + 0j],
        np.ma.array([5.0, 9.0], mask=[False, True]),
        [5.0, np.ma.masked],
        [np.timedelta64(5, "s"), 5.6],
        [10**400],
    ],
    ids=shown,
)
def test_voltages_that_are_no_numbers_are_refused(voltages: object) -> None:
    """In one line that says what to give."""
    with pytest.raises(ValueError, match=r"^voltages .* refused: must be numbers of volts"):
        simulate(RigParameters(), voltages, 1e-3)  # type: ignore[arg-type]


def test_voltages_of_two_dimensions_are_refused() -> None:
    """They would be flattened, row by row, without a word."""
    with pytest.raises(ValueError, match=r"^voltages of shape \(3, 4\) refused: .*shape \(n,\)"):
        simulate(RigParameters(), np.full((3, 4), 6.0), 1e-3)


@pytest.mark.parametrize(
    "voltages",
    [
        (5, 6),
        range(5, 7),
        np.array([5, 6], dtype=np.int8),
        [Fraction(5), Decimal(6)],
        np.ma.array([5.0, 6.0]),
    ],
    ids=shown,
)
def test_voltages_may_be_numbers_of_any_kind(voltages: object) -> None:
    """Whole ones, fractions, arrays of which nothing is masked."""
    run = simulate(RigParameters(), voltages, 1e-4)  # type: ignore[arg-type]
    assert run.voltage.tolist() == [5.0, 6.0, 6.0]


def test_a_voltage_may_be_a_decimal_as_those_of_an_array(rig: Rig) -> None:
    """It is applied as the same float; what is no finite one is refused in words, NaN too."""
    one, other = Rig(rig.parameters), Rig(rig.parameters)
    assert one.advance(Decimal("5.5"), 1e-3) == other.advance(5.5, 1e-3)  # type: ignore[arg-type]
    for odd in ("1e400", "-Infinity", "NaN", "sNaN"):
        with pytest.raises(ValueError, match=r"^voltage .* refused: not a finite number$"):
            rig.advance(Decimal(odd), 1e-3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "voltage", [True, np.array(True), np.array([5.0, 6.0]), 10**400, "5"], ids=shown
)
def test_a_voltage_that_is_no_number_changes_nothing(rig: Rig, voltage: object) -> None:
    """One line, however long the number is."""
    before = seen(rig)
    with pytest.raises((ValueError, TypeError), match=r"^voltage .* refused: ") as refusal:
        rig.advance(voltage, 1e-3)  # type: ignore[arg-type]
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 200
    assert seen(rig) == before


def test_a_span_of_time_of_numpys_is_no_number() -> None:
    """It counts as a whole number there, and has no float."""
    odd = np.timedelta64(1, "s")
    with pytest.raises(TypeError, match=r"refused: must be a number of seconds"):
        Rig().advance(5.5, odd)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"^supply\.pressure: .* refused, must be a number"):
        RigParameters({"supply.pressure": odd})


def test_an_array_of_one_number_is_that_number() -> None:
    """State and trace have floats."""
    state = Rig().advance(np.array(5.5), np.array(1e-3))  # type: ignore[arg-type]
    assert type(state.voltage) is float
    assert state == Rig().advance(5.5, 1e-3)
    assert type(Rig().reset(np.array(0.05)).position) is float  # type: ignore[arg-type]


def test_a_valve_beyond_any_says_that_chambers_do_not_settle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where flows are no numbers the root finder gives up; its own words do not come out."""
    plant = Plant.of(RigParameters({"leak.across": 1e-8}))

    def no_numbers(_plant: Plant, _lands: Lands, state: Motion) -> Inflows:
        flow = Inflow(math.nan if state.pressure_a < 3e5 else -1.0, 0.0, 0.0)
        return Inflows(flow, flow)

    monkeypatch.setattr(settled, "inflows", no_numbers)
    settled.settled_pressures.cache_clear()
    with pytest.raises(SimulationError, match=r"do not settle at 5\.08 V; check valve"):
        settled.settled_pressures(plant, 5.08)


def test_openings_that_are_no_numbers_leave_nothing_to_settle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same words for chambers that do not leak into each other."""
    edge = Edge(math.nan, math.nan)
    monkeypatch.setattr(settled, "openings", lambda *_: Lands(True, edge, edge))
    settled.settled_pressures.cache_clear()
    with pytest.raises(SimulationError, match=r"do not settle at 5\.08 V; check valve"):
        settled.settled_pressures(Plant.of(RigParameters()), 5.08)


def test_a_rig_and_a_trace_without_samples_say_what_they_are() -> None:
    """Time, position, voltage and parameters; and no error for an empty trace."""
    rig = Rig()
    assert repr(rig).startswith("<Rig at 0 s: carriage at 0.000 mm, 0.000 mm/s, 5.08 V; RigParam")
    run = simulate(RigParameters(), [6.0], 1e-3)
    empty = Trace(**{name: np.empty(0) for name in run.columns()})
    assert repr(empty) == "Trace: 0 samples"
    assert repr(run) == "Trace: 2 samples, 0.001 s"


def test_a_long_number_too_large_is_refused_in_words() -> None:
    """Numpy's own warning was what came, an error where warnings are."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=r"not a finite number$"):
            simulate(RigParameters(), np.array(["1e400"]).astype("longdouble"), 1e-3)
