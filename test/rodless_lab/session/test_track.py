# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Where a move begins, when it has settled and what is measured, on tracks made by hand."""

import math

import pytest

from rodless_lab.session.track import STAY, Track

PERIOD = 1_000_000
TARGET = 0.05

# From a sample to its reference, in ns: the next sample has come by then (after 2 ms), but not its
# command (0.1 ms later).
REFERENCE_DELAY = 2_050_000

# Of the carriage in the tracks below: time constant in s.
LAG = 0.2


def approach(track: Track, start: float, seconds: float, first: int = 0) -> int:
    """Let the carriage approach the target exponentially; return the time after it in ns."""
    for k in range(round(seconds * 1e9 / PERIOD)):
        stamp = first + k * PERIOD
        position = TARGET + (start - TARGET) * math.exp(-k * PERIOD * 1e-9 / LAG)
        track.take_sample(sent(stamp), stamp, position)
        track.take_reference(sent(stamp) + REFERENCE_DELAY, TARGET)
        track.take_voltage(sent(stamp) + 100_000, 6.0)
    return first + round(seconds * 1e9)


def rest(track: Track, position: float, count: int, reference: float, first: int = 0) -> int:
    """Let ``count`` samples come at rest; return the time after them in ns."""
    for k in range(count):
        stamp = first + k * PERIOD
        track.take_sample(sent(stamp), stamp, position)
        track.take_voltage(sent(stamp) + 100_000, 9.0)
        track.take_reference(sent(stamp) + REFERENCE_DELAY, reference)
    return first + count * PERIOD


def sent(stamp: int) -> int:
    """When a sample goes out: some wall-clock time that runs at half the speed."""
    return 77_000_000_000 + 2 * stamp


def test_times_count_from_the_sample_after_which_the_reference_changed() -> None:
    """The response of a first-order lag, whose rise and settling times are known.

    The set-point goes out 30 samples before the controller takes it.
    """
    track = Track(TARGET)
    rest(track, 0.0, 20, reference=0.0)
    track.begin()
    start = rest(track, 0.0, 30, reference=0.0, first=20 * PERIOD)
    assert not track.is_followed
    approach(track, 0.0, 2.5, first=start)
    assert track.has_settled
    result = track.result()
    assert result.settled
    assert result.from_sending is None
    assert result.metrics is not None
    assert result.metrics.rise_time == pytest.approx(LAG * math.log(9.0), abs=1.1e-3)
    settling = math.ceil(LAG * math.log(0.05 / 2e-4) * 1e9 / PERIOD) * PERIOD * 1e-9
    assert result.metrics.settling_time == pytest.approx(settling)
    assert result.metrics.overshoot == 0.0
    assert result.metrics.peak_voltage == 6.0, "9 V came before"


def test_settled_is_half_a_second_within_the_band() -> None:
    """Not before, and whoever leaves the band begins anew."""
    track = Track(TARGET)
    end = rest(track, 0.0, 10, reference=0.0)
    track.begin()
    end = rest(track, TARGET - 1.9e-4, STAY // PERIOD, TARGET, end)
    assert not track.has_settled
    end = rest(track, TARGET + 2.1e-4, 1, TARGET, end)
    end = rest(track, TARGET, STAY // PERIOD, TARGET, end)
    assert not track.has_settled
    rest(track, TARGET, 1, TARGET, end)
    assert track.has_settled


def test_without_a_reference_times_count_from_the_sending_and_that_is_said() -> None:
    """A controller of one's own need not publish what it follows."""
    track = Track(TARGET)
    for stamp in range(0, 10 * PERIOD, PERIOD):
        track.take_sample(sent(stamp), stamp, 0.0)
    track.begin()
    for stamp in range(10 * PERIOD, 1000 * PERIOD, PERIOD):
        track.take_sample(sent(stamp), stamp, TARGET)
        track.take_voltage(sent(stamp), 7.0)
    result = track.result()
    assert result.settled
    assert result.from_sending == "the controller does not publish its reference"
    assert result.metrics is not None
    assert result.metrics.settling_time == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("before", "words"),
    [([0.01, 0.011], "moving already"), ([TARGET, TARGET], "in force already")],
)
def test_a_reference_that_cannot_show_the_change_is_said(before: list[float], words: str) -> None:
    """One that moves already, and one that is there already."""
    track = Track(TARGET)
    for k, reference in enumerate(before):
        track.take_sample(sent(k), k, 0.0)
        track.take_reference(sent(k), reference)
    track.begin()
    approach(track, 0.0, 2.5, first=PERIOD)
    assert words in str(track.result().from_sending)
    assert track.has_settled


def test_a_carriage_that_is_there_has_no_metrics() -> None:
    """There is no step to measure, but it must stay."""
    track = Track(TARGET)
    end = rest(track, TARGET + 1e-4, 10, reference=TARGET)
    track.begin()
    rest(track, TARGET + 1e-4, STAY // PERIOD + 1, TARGET, end)
    result = track.result()
    assert result.metrics is None
    assert result.settled


def test_one_that_never_comes_has_not_settled() -> None:
    """The metrics say how far it came."""
    track = Track(TARGET)
    end = rest(track, 0.0, 10, reference=0.0)
    track.begin()
    rest(track, 0.0, 10, TARGET, rest(track, 0.02, 1000, TARGET, end))
    result = track.result()
    assert not result.settled
    assert result.metrics is not None
    assert math.isnan(result.metrics.settling_time)
    assert result.metrics.final_error == pytest.approx(-TARGET)


def test_a_reset_is_noticed() -> None:
    """Plant time that jumps back ends the move."""
    track = Track(TARGET)
    rest(track, 0.0, 10, reference=0.0)
    track.begin()
    assert not track.was_reset
    track.take_sample(sent(11 * PERIOD), 0, 0.0)
    assert track.was_reset


@pytest.mark.parametrize(
    ("voltages", "words"),
    [((), "no command on valve/voltage since the set-point"), ((6.0, math.nan), "is not finite")],
)
def test_commands_that_measure_nothing_are_said(voltages: tuple[float, ...], words: str) -> None:
    """None at all, as of a controller that was killed, and one that is no number."""
    track = Track(TARGET)
    track.take_sample(sent(9 * PERIOD), 9 * PERIOD, 0.0)
    track.begin()
    for k in range(10, 20):
        track.take_sample(sent(k * PERIOD), k * PERIOD, 0.0)
    for k, voltage in enumerate(voltages):
        track.take_voltage(sent((11 + k) * PERIOD), voltage)
    with pytest.raises(ValueError, match=words):
        track.result()


def test_a_reference_that_rests_elsewhere_is_of_another_set_point() -> None:
    """More than a second of plant time and of wall clock, which runs at double the speed here."""
    track = Track(TARGET)
    end = rest(track, 0.0, 5000, reference=0.0)
    track.begin(sent(end) + REFERENCE_DELAY)
    assert not track.is_elsewhere, "not for what came before"
    end = rest(track, 0.0, 1002, 0.0, end)
    assert not track.is_elsewhere, "it may be late"
    for k in range(1, 2000):
        end = rest(track, 0.0, 1, 1e-6 * k, end)
        assert not track.is_elsewhere, "on its way"
    end = rest(track, TARGET, 5000, TARGET + 1e-4, end)
    assert not track.is_elsewhere, "rounded"
    end = rest(track, 0.0, 1002, 0.12, end)
    assert not track.is_elsewhere
    rest(track, 0.0, 1, 0.12, end)
    assert track.is_elsewhere
    assert track.reference == 0.12


def test_a_controller_that_says_nothing_follows_nothing_else() -> None:
    """It has failed, was disabled or is busy: what it followed before the set-point is no sign."""
    track = Track(TARGET)
    end = rest(track, 0.0, 100, reference=0.0)
    track.begin(sent(end))
    for stamp in range(end, end + 5000 * PERIOD, PERIOD):
        track.take_sample(sent(stamp), stamp, 0.0)
    assert not track.is_elsewhere


def test_a_sensor_that_is_gone_is_nowhere_near() -> None:
    """NaN in place of positions: the carriage that was there already has not settled."""
    track = Track(0.02)
    track.take_reference(0, 0.02)
    track.take_sample(1, 0, 0.02)
    track.begin(2)
    for k in range(1, 20):
        track.take_sample(2 + k, k * STAY, math.nan)
    assert not track.has_settled
