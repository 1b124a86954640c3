# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the laws are made of, piece by piece, against numbers worked out by hand."""

import math
from typing import Any

import pytest

from rodless_control import Measurement, ReferencePoint
from rodless_control.laws import law_class
from rodless_control.laws.adrc import Memory
from rodless_control.laws.parts.dead_zone import DeadZone
from rodless_control.laws.parts.effort import (
    Bumpless,
    Drive,
    Driver,
    Valve,
    at_limit,
    commanded,
    driven,
    idle,
)
from rodless_control.laws.parts.fading_memory import Motion
from rodless_control.laws.parts.following import (
    Follower,
    Known,
    acceleration_error,
    begun,
    followed,
    position_error,
    velocity_error,
)
from rodless_control.laws.parts.integral import Integrator
from rodless_control.laws.parts.parking import Parking, ParkingLimits
from rodless_control.laws.parts.saturation import (
    Limits,
    bounded,
    bounded_pressure,
    held_at_limit,
    unwound,
)

PLACE = Measurement(0, 0.1, 3e5, 3e5, 6e5)
KNOWN = Known(Motion(0.1, 0.02, 0.7), Parking(0.0, 0.0), PLACE, ReferencePoint(0.1001, 0.05), 0.4)
FOLLOWER = Follower(376.0, ParkingLimits(0.0, 2.0, 30.0))


def test_no_rig_is_longer_faster_or_under_more_pressure() -> None:
    """1 km, 1 km/s and 100 MPa; a pressure is 1 Pa at least, as laws divide by it."""
    assert [bounded(x) for x in (-2e3, -0.1, 0.1, 2e3)] == [-1e3, -0.1, 0.1, 1e3]
    assert [bounded_pressure(p) for p in (-1e5, 0.0, 1.0, 1.5, 3e5)] == [1.0, 1.0, 1.0, 1.5, 3e5]
    assert bounded_pressure(1e12) == 1e8


@pytest.mark.parametrize(
    ("integral", "grown", "excess", "expected"),
    [
        (0.2, 0.3, 1.0, 0.2),
        (0.3, 0.2, 1.0, 0.2),
        (0.3, 0.2, -1.0, 0.3),
        (0.2, 0.3, -1.0, 0.3),
        (-0.2, -0.3, -1.0, -0.2),
        (-0.3, -0.2, -1.0, -0.2),
        (0.2, 0.3, 0.0, 0.3),
    ],
)
def test_an_integral_does_not_grow_against_a_limit(
    integral: float, grown: float, excess: float, expected: float
) -> None:
    """It may shrink there, and grow away from it."""
    assert held_at_limit(integral, grown, excess) == expected


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_integral_that_pushes_away_unwinds(sign: float) -> None:
    """At 50 V/(m·s) times 0.2 mm, the zone, whatever the error: 0.1 mV in 10 ms, and 0 at last."""
    for integral, expected in ((0.2, 0.1999), (2e-4, 1e-4), (5e-5, 0.0), (0.0, 0.0)):
        for error in (1e-3, 5.0):
            found = unwound(sign * integral, 50.0, 2e-4, -sign * error, 0.01)
            assert found == pytest.approx(sign * expected, rel=1e-12)
    # One that pushes towards the target stays, and so does one that has no pace.
    assert unwound(sign * 0.2, 50.0, 2e-4, sign * 1e-3, 0.01) == sign * 0.2
    assert unwound(sign * 0.2, 0.0, 2e-4, -sign * 1e-3, 0.01) == sign * 0.2
    assert unwound(sign * 0.2, 50.0, 0.0, -sign * 1e-3, 0.01) == sign * 0.2


def test_errors_are_what_is_wanted_less_what_is() -> None:
    """Of position, velocity and acceleration."""
    assert position_error(KNOWN) == pytest.approx(1e-4, rel=1e-9)
    assert velocity_error(KNOWN) == pytest.approx(0.03, rel=1e-12)
    assert acceleration_error(KNOWN) == pytest.approx(-0.3, rel=1e-12)


def test_a_law_begins_with_a_carriage_that_is_wanted_where_it_is() -> None:
    """At rest, not parked."""
    known = begun(PLACE)
    assert known == (Motion(0.1, 0.0, 0.0), Parking(0.0, 0.0), PLACE, ReferencePoint(0.1, 0.0), 0.0)


def test_the_acceleration_of_the_reference_is_that_from_sample_to_sample() -> None:
    """Of what is wanted now less what was, filtered; positions and velocities are bounded."""
    later = PLACE._replace(stamp=1_000_000, position=0.1002)
    known = followed(FOLLOWER, KNOWN, later, ReferencePoint(1e9, 0.058), 0.0, 1e-3)
    assert known.reference == (1e3, 0.058)
    # The low-pass of 8 m/s² at 376 rad/s.
    expected = 0.4 + (8.0 - 0.4) * (1.0 - math.exp(-0.376))
    assert known.reference_acceleration == pytest.approx(expected, rel=1e-12)
    assert known.measurement == later


def test_an_effort_is_what_is_wanted_the_integral_and_what_new_gains_left() -> None:
    """The last fades with the tracking time; a law that is parked does not integrate."""
    driver, drive = Driver(Integrator(50.0, 2e-4), 0.1), Drive(0.2, 0.3, 9.0, 0.0)
    grown, offset = 0.2 + 50.0 * 1e-4 * 0.01, 0.3 * math.exp(-0.1)
    found = driven(driver, drive, KNOWN, 1.5, 0.01)
    assert found == pytest.approx((grown, offset, 1.5 + grown + offset, 0.0), rel=1e-9)
    parked = KNOWN._replace(parking=Parking(0.0, 1.0))
    found = driven(driver, drive._replace(saturated=-1.0), parked, 1.5, 0.01)
    assert found == pytest.approx((0.2, offset, 1.7 + offset, -1.0), rel=1e-9)
    # The command is at its upper limit: nothing grows further against it.
    found = driven(driver, drive._replace(saturated=1.0), KNOWN, 1.5, 0.01)
    assert found.integral == 0.2
    assert idle() == (0.0, 0.0, 0.0, 0.0)


def test_a_law_without_an_integral_has_none() -> None:
    """No gain and no zone; its tracking time is its own."""
    parameters = law_class("adrc").Parameters({"adrc.tracking_time": 0.7})
    assert Driver.without_integral(parameters, "adrc") == (Integrator(0.0, 0.0), 0.7)


def test_a_limit_is_known_by_its_sign() -> None:
    """What the limit has taken away: 1 above, -1 below, 0 where nothing is."""
    drive = Drive(0.1, 0.2, 0.3, 0.5)
    for wanted, sign in ((5.1, 1.0), (4.9, -1.0), (5.0, 0.0)):
        assert at_limit(drive, wanted, 5.0) == (0.1, 0.2, 0.3, sign)


def test_an_effort_becomes_a_command_about_neutral() -> None:
    """With the dead zone crossed, within the limits."""
    valve = Valve(DeadZone(0.7, 0.1), Limits(5.08, 1.0, 9.0))
    for effort, voltage, sign in (
        (0.1, 5.08 + 0.1 + 0.7 * math.tanh(1.0), 0.0),
        (-0.1, 5.08 - 0.1 - 0.7 * math.tanh(1.0), 0.0),
        (4.0, 9.0, 1.0),
        (-4.0, 1.0, -1.0),
    ):
        drive, found = commanded(valve, Drive(0.0, 0.0, effort, 0.0))
        assert found == pytest.approx(voltage, rel=1e-12)
        assert drive.saturated == sign


class Straight(Bumpless):
    """A law whose effort is a gain times the error."""

    def __init__(self, gain: float) -> None:
        """Take the gain."""
        self.gains = gain

    def _update(self, gains: float, memory: Any, *sample: Any) -> tuple[Any, float]:
        assert sample == (PLACE, ReferencePoint(0.1001, 0.05), 0.0)
        drive = memory.drive._replace(effort=gains * 1e-4 + memory.drive.offset)
        return memory._replace(drive=drive), 0.0


def test_new_gains_make_no_jump_of_the_command() -> None:
    """The offset takes up the difference of efforts, from the 10 V where the command was open."""
    memory = Memory(KNOWN, Drive(0.0, 0.25, 0.0, 0.0), 0.0)
    for old, new, offset in (
        (1e4, 3e4, 0.25 - 2.0),
        (3e4, 1e4, 0.25 + 2.0),
        (1e4, 9e5, 0.25 - (90.25 - 1.25)),
        (9e9, 1e4, 0.25 + (10.0 - 1.25)),
        (9e9, 9e5, 0.25),
        (-9e9, 1e4, 0.25 - (1.25 + 10.0)),
    ):
        assert Straight(new).retuned(old, memory).drive.offset == pytest.approx(offset)
    begun_anew = memory._replace(drive=idle())
    before = memory._replace(drive=Drive(0.4, 0.25, 1.0, 1.0))
    assert Straight(1.0).resumed(begun_anew, before).drive == Drive(0.4, 0.0, 0.0, 0.0)
