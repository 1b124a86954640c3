# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Constant, step, ramp, sine: position, velocity, and what happens at their corners."""

import math
from fractions import Fraction

import numpy as np
import pytest

from rodless_control import references
from rodless_control.references import Reference

SMOOTH: dict[str, Reference] = {
    "constant": references.constant(0.03),
    "step": references.step(0.01, 0.06, at=0.5),
    "ramp": references.ramp(0.01, 0.06, 0.04, at=0.5),
    "ramp back": references.ramp(0.06, -0.01, 0.04, at=0.5),
    "sine": references.sine(0.1, 0.02, 0.381, at=0.5),
    "move": references.move(0.01, 0.06, 0.05, 0.5, 10.0, at=0.5),
    "move back": references.move(0.06, 0.01, 0.05, 0.5, 10.0, at=0.5),
}
# Where a shape jumps or turns a corner, a difference across it is no derivative.
CORNERS = {"step": [0.5], "ramp": [0.5, 1.75], "ramp back": [0.5, 2.25], "sine": [0.5]}


@pytest.mark.parametrize("name", SMOOTH)
def test_velocity_is_the_derivative_of_position(name: str) -> None:
    """Central differences of the position, away from corners, give the velocity."""
    reference, half = SMOOTH[name], 1e-5
    times = np.linspace(0.0, 3.0, 1501) + 1e-4
    for time in times:
        if all(abs(time - corner) > 2.0 * half for corner in CORNERS.get(name, [])):
            slope = (reference.sample(time + half)[0] - reference.sample(time - half)[0]) / 2e-5
            assert reference.sample(time)[1] == pytest.approx(slope, abs=1e-9)


@pytest.mark.parametrize("name", SMOOTH)
def test_many_samples_at_once_have_the_same_bits(name: str) -> None:
    """At 1 kHz from before the start to after the end, corners included."""
    reference = SMOOTH[name]
    times = np.concatenate([np.arange(-100, 3001) * 1e-3, [0.5, 1.75, 2.25]])
    expected = np.array([reference.sample(float(time)) for time in times])
    assert references.sampled(reference, times).tobytes() == expected.tobytes()


def test_a_reference_of_ones_own_needs_only_sample() -> None:
    """It is asked time by time, with plain numbers."""

    class Saw:
        def sample(self, time: float) -> tuple[float, float]:
            assert type(time) is float
            return time % 0.5, 1.0

    found = references.sampled(Saw(), np.array([0.1, 0.7, 1.2]))
    assert found[:, 0] == pytest.approx([0.1, 0.2, 0.2])
    assert found[:, 1].tolist() == [1.0, 1.0, 1.0]
    assert references.sampled(Saw(), np.empty(0)).shape == (0, 2)


def test_constant() -> None:
    """Everywhere the same, at rest."""
    reference = references.constant(-0.7)
    assert {reference.sample(time) for time in (-5.0, 0.0, 1e6)} == {(-0.7, 0.0)}


def test_step() -> None:
    """Before until its instant, after from then on, never with a velocity."""
    reference = references.step(0.0, 0.058, at=0.5)
    assert reference.sample(math.nextafter(0.5, 0.0)) == (0.0, 0.0)
    assert reference.sample(0.5) == (0.058, 0.0)


@pytest.mark.parametrize(("target", "velocity"), [(0.07, 0.02), (-0.05, -0.02)])
def test_ramp(target: float, velocity: float) -> None:
    """3 s at 20 mm/s in either direction, at rest before and after, exactly at the target."""
    reference = references.ramp(0.01, target, 0.02, at=1.0)
    assert reference.sample(0.999) == (0.01, 0.0)
    assert reference.sample(1.0) == (0.01, velocity)
    assert reference.sample(2.5) == (pytest.approx(0.01 + 1.5 * velocity, rel=1e-14), velocity)
    assert reference.sample(4.0 + 1e-9) == (target, 0.0)
    assert reference.sample(1e9) == (target, 0.0)


def test_ramp_over_no_distance() -> None:
    """It is at its target all the time, at rest."""
    reference = references.ramp(0.05, 0.05, 0.02, at=1.0)
    assert {reference.sample(time) for time in (0.0, 1.0, 2.0)} == {(0.05, 0.0)}


def test_sine() -> None:
    """Quarter periods of 2 s from its start: centre, top, centre, bottom; full speed at first."""
    reference = references.sine(0.1, 0.02, 0.125, at=1.0)
    assert reference.sample(0.9) == (0.1, 0.0)
    found = [reference.sample(1.0 + 2.0 * quarter) for quarter in range(5)]
    top_speed = 0.02 * math.pi / 4.0
    assert [x for x, _ in found] == pytest.approx([0.1, 0.12, 0.1, 0.08, 0.1], rel=1e-14)
    assert [v for _, v in found] == pytest.approx(
        [top_speed, 0.0, -top_speed, 0.0, top_speed], abs=1e-15
    )


def test_sine_has_the_named_frequency_and_amplitude() -> None:
    """Over ten periods it crosses its centre twenty times and spans twice the amplitude."""
    reference = references.sine(0.1, 0.02, 0.381)
    times = np.linspace(0.0, 10.0 / 0.381, 200_001) + 1e-7
    positions = np.array([reference.sample(time)[0] for time in times[::20]])
    assert np.count_nonzero(np.diff(np.sign(positions - 0.1))) == 20
    assert np.ptp(positions) == pytest.approx(0.04, rel=1e-5)


@pytest.mark.parametrize(
    ("centre", "amplitude", "frequency", "at"),
    [
        (0.1, 1e300, 1e9, 0.0),  # its speed
        (0.1, 0.02, 1e299, 0.0),  # its angle after the longest run, 1e10 s
        (0.1, 0.02, 1e9, -1e300),  # its angle at the start of the run
        (1e308, 1e308, 1.0, 0.0),  # its top
        (-1e308, -1e308, 1.0, 0.0),
    ],
)
def test_a_sine_that_overflows_is_refused(
    centre: float, amplitude: float, frequency: float, at: float
) -> None:
    """Whichever of its numbers would; ten or more powers of ten less and it is computed."""
    with pytest.raises(ValueError, match="refused: too large for a sine that can be computed"):
        references.sine(centre, amplitude, frequency, at)
    small = references.sine(0.1, 1e290, 1e8, -1e280)
    assert all(map(math.isfinite, small.sample(1e10)))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_reference_leads_nowhere(value: float) -> None:
    """A number that is not finite is refused when the reference is made, by name and value."""
    kinds = {
        references.constant: ("position",),
        references.step: ("before", "after", "at"),
        references.ramp: ("start", "target", "velocity", "at"),
        references.sine: ("centre", "amplitude", "frequency", "at"),
        references.move: ("start", "target", "velocity", "acceleration", "jerk", "at"),
    }
    for kind, names in kinds.items():
        for name in names:
            good = dict.fromkeys(names, 0.1)
            assert kind(**good).sample(0.0) is not None
            with pytest.raises(ValueError, match=f"{name} {value!r} refused"):
                kind(**{**good, name: value})


@pytest.mark.parametrize("number", [Fraction(1, 4), 1, 10**30, np.float32(0.25), np.array(0.25)])
def test_any_kind_of_number_gives_the_samples_of_the_float(number: float) -> None:
    """One by one and all at once, to the last bit; what is kept is the float."""
    times = np.linspace(0.0, 2.0, 9)
    for make in (references.constant, lambda n: references.step(0.0, n, n), references.sine):
        arguments = (number, number, 1.0, number) if make is references.sine else (number,)
        reference = make(*arguments)
        assert repr(reference) == repr(make(*map(float, arguments)))
        points = references.sampled(reference, times)
        assert points.tolist() == [list(reference.sample(time)) for time in times.tolist()]


@pytest.mark.parametrize(
    "value", [np.zeros(2), np.array([[1.0, 2.0]]), "1", True, None, np.timedelta64(1, "s")]
)
def test_what_is_no_single_number_is_refused(value: object) -> None:
    """By the name of the argument."""
    with pytest.raises(TypeError, match=r"^before .* refused: must be a number$"):
        references.step(value, 1.0)  # type: ignore[arg-type]


class Broken:
    """A reference that cannot answer after 0.2 s."""

    def sample(self, time: float) -> tuple[float, float]:
        """Return a position, or raise."""
        if time > 0.2:
            raise ZeroDivisionError("no way")
        return 0.1, 0.0


def test_a_reference_that_raises_is_named_with_the_time() -> None:
    """And a class in place of one is no reference."""
    with pytest.raises(ValueError, match=r"^at 0\.3 s: reference Broken raises Zero.*: no way"):
        references.sampled(Broken(), np.array([0.1, 0.3]))
    for none in (Broken, type("Odd", (), {"samples": 7})()):
        with pytest.raises(TypeError, match="is no reference: give one of"):
            references.sampled(none, np.array([0.1]))


@pytest.mark.parametrize("times", [0.5, "ab", [[0.1]], [0.1, math.nan], [None], (0.1, "x"), None])
def test_times_must_be_finite_numbers_in_a_row(times: object) -> None:
    """What is no array of times is refused, before any reference is asked."""
    with pytest.raises(ValueError, match=r"^times .* refused: must be finite numbers of s, shape"):
        references.sampled(references.constant(0.1), times)  # type: ignore[arg-type]
    assert references.sampled(references.constant(0.1), [0, 1]).tolist() == [[0.1, 0.0]] * 2  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_speeds_and_limits_must_be_positive(value: float) -> None:
    """A ramp or move that could not get anywhere is refused, naming what is wrong and its value."""
    with pytest.raises(ValueError, match=f"velocity {value!r}"):
        references.ramp(0.0, 1.0, value)
    for k, name in enumerate(("velocity", "acceleration", "jerk")):
        limits = [1.0, 1.0, 1.0]
        limits[k] = value
        with pytest.raises(ValueError, match=f"{name} {value!r}"):
            references.move(0.0, 1.0, *limits)


@pytest.mark.parametrize("place", range(3))
def test_a_masked_number_is_none(place: int) -> None:
    """What stands below the mask was taken; an array of one number is that number."""
    numbers = [0.01, 0.06, 0.5]
    given: list[object] = list(map(np.array, numbers))
    assert references.step(*given) == references.step(*numbers)  # type: ignore[arg-type]
    given[place] = np.ma.masked_array([numbers[place]], [True])
    with pytest.raises(TypeError, match=r"refused: must be a number$"):
        references.step(*given)  # type: ignore[arg-type]


def test_masked_answers_of_a_reference_are_none() -> None:
    """As where a measured course has gaps."""

    class Gaps(Reference):
        def sample(self, time: float) -> tuple[float, float]:
            return time, 0.0

        def samples(self, times: np.ndarray) -> np.ndarray:
            return np.ma.masked_less(np.stack([times, times], axis=1), 0.5)

    with pytest.raises(ValueError, match=r"^reference Gaps: samples.* answered"):
        references.sampled(Gaps(), np.array([0.0, 1.0]))
