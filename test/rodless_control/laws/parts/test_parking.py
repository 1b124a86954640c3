# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The parking automaton: when it parks, when it leaves, and what it never does."""

import math

import pytest

from rodless_control.laws.parts.parking import (
    PARKED_SHARE,
    Parking,
    ParkingLimits,
    acting,
    afoot,
    held,
    parked,
)

LIMITS = ParkingLimits(error=25e-6, hysteresis=2.0, bandwidth=33.5)
CORRECTED = LIMITS._replace(correction=1000.0)
INTERVAL = 1e-3
PARKED = Parking(0.0, 1.0)


def samples_until(
    parking: Parking, error: float, wanted: float, limits: ParkingLimits = LIMITS
) -> int:
    """Count the samples with a constant error until ``parked`` is ``wanted``."""
    for count in range(1, 2000):
        parking = parked(limits, parking, error, 0.0, 0.0, INTERVAL)
        if parking.parked == wanted:
            return count
    raise AssertionError("never")


def test_it_parks_once_the_slow_error_is_small() -> None:
    """From 1 mm the slow error falls to 25 µm, of which 10 µm stay, as e^(-33.5 t) says."""
    expected = math.log((1e-3 - 10e-6) / (25e-6 - 10e-6)) / 33.5
    count = samples_until(Parking(1e-3, 0.0), 10e-6, 1.0)
    assert count == math.ceil(expected / INTERVAL)


def test_it_leaves_at_twice_the_error() -> None:
    """An error of 0.1 mm brings the slow error to 50 µm after ln 2 / 33.5 s."""
    count = samples_until(PARKED, 1e-4, 0.0)
    assert count == math.ceil(math.log(2.0) / 33.5 / INTERVAL)


@pytest.mark.parametrize("error", [30e-6, -45e-6])
def test_between_the_two_it_stays_as_it_is(error: float) -> None:
    """Hysteresis: at 30 or 45 µm a parked carriage stays parked, and another is not parked."""
    still, away = PARKED, Parking(error, 0.0)
    for _ in range(1000):
        still = parked(LIMITS, still, error, 0.0, 0.0, INTERVAL)
        away = parked(LIMITS, away, error, 0.0, 0.0, INTERVAL)
        assert (still.parked, away.parked) == (1.0, 0.0)


def test_a_reference_that_moves_ends_parking_at_once() -> None:
    """However small error and velocity are, and whichever way it moves."""
    for velocity in (1e-9, -0.1):
        assert parked(LIMITS, PARKED, 0.0, 0.0, velocity, INTERVAL).parked == 0.0


@pytest.mark.parametrize(
    ("error", "velocity", "expected"),
    [(1.9e-4, 0.0, 1.0), (2.1e-4, 0.0, 0.0), (0.0, 9.9e-3, 1.0), (0.0, -10.1e-3, 0.0)],
)
def test_a_carriage_on_its_way_is_not_parked(
    error: float, velocity: float, expected: float
) -> None:
    """More than 0.2 mm off or faster than 10 mm/s, though the slow error is small."""
    assert parked(LIMITS, afoot(), error, velocity, 0.0, INTERVAL).parked == expected


def test_an_error_of_zero_never_parks() -> None:
    """The option is off, also for one that was parked when it was switched off."""
    off = LIMITS._replace(error=0.0)
    for parking in (afoot(), PARKED):
        for interval in (0.0, INTERVAL):
            assert parked(off, parking, 0.0, 0.0, 0.0, interval).parked == 0.0


def test_a_carriage_that_may_park_from_now_on_is_not_there_before_it_is() -> None:
    """An error of 0.15 mm, asked to park within 25 µm, was taken for a slow error of 0 before."""
    parking = parked(LIMITS._replace(error=0.0), afoot(), 150e-6, 0.0, 0.0, INTERVAL)
    for _ in range(100):
        parking = parked(LIMITS, parking, 150e-6, 0.0, 0.0, INTERVAL)
        assert parking.parked == 0.0


def test_time_that_stands_still_changes_nothing() -> None:
    """An interval of 0 leaves the automaton where it is."""
    assert parked(LIMITS, PARKED, 1.0, 1.0, 1.0, 0.0) == PARKED


def test_parked_a_hundredth_of_the_law_acts() -> None:
    """And all of it otherwise."""
    assert (acting(PARKED), acting(afoot())) == (PARKED_SHARE, 1.0) == (0.01, 1.0)


def test_a_carriage_that_creeps_is_held_at_the_edge_of_the_band() -> None:
    """1000 V/m on what the slow error is beyond 25 µm, either way; none within, none unasked."""
    for slow_error, expected in ((45e-6, 0.02), (-45e-6, -0.02), (24e-6, 0.0), (-24e-6, 0.0)):
        assert held(CORRECTED, Parking(slow_error, 1.0)) == pytest.approx(expected, abs=1e-15)
    assert held(LIMITS, Parking(45e-6, 1.0)) == 0.0


def test_corrected_it_parks_as_before_and_leaves_later() -> None:
    """The slow error of the parked one has 0.3 times the bandwidth: 70 µm leave at ln 3.5."""
    assert samples_until(Parking(1e-3, 0.0), 10e-6, 1.0, CORRECTED) == samples_until(
        Parking(1e-3, 0.0), 10e-6, 1.0
    )
    expected = math.log(70.0 / (70.0 - 50.0)) / (0.3 * 33.5)
    assert samples_until(PARKED, 70e-6, 0.0, CORRECTED) == math.ceil(expected / INTERVAL)


def test_corrected_a_carriage_that_breaks_loose_leaves_at_once() -> None:
    """76 µm within a sample are no creep, 74 µm may be; uncorrected, the slow error alone says."""
    for error, expected in ((74e-6, 1.0), (76e-6, 0.0), (-76e-6, 0.0)):
        assert parked(CORRECTED, PARKED, error, 0.0, 0.0, INTERVAL).parked == expected
        assert parked(LIMITS, PARKED, error, 0.0, 0.0, INTERVAL).parked == 1.0
