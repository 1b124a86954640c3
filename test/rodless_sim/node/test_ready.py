# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whom the plant waits for, and what it says of itself once it is ready."""

import pytest

from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.node.ready import all_listen, preset_text, ready_line


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {},
            "ready: realtime, 1000 Hz, supply 0.520 MPa gauge, preset paper; "
            "waiting for commands on /a/valve/voltage",
        ),
        (
            {"time.period": 5e-3, "time.speed": 2.0, "supply.pressure": 501325.0},
            "ready: realtime, 200 Hz at speed 2, supply 0.400 MPa gauge, "
            "preset paper (changed: supply.pressure); waiting for commands on /a/valve/voltage",
        ),
        (
            {"time.recorders": 2},
            "ready: realtime, 1000 Hz, supply 0.520 MPa gauge, preset paper; "
            "waiting for 3 subscribers to /a/joint_states and commands on /a/valve/voltage",
        ),
        (
            {"time.mode": "lockstep"},
            "ready: lockstep, 1000 samples per second of plant time, supply 0.520 MPa gauge, "
            "preset paper; waiting for a subscriber to /a/joint_states and one publisher on "
            "/a/valve/voltage",
        ),
    ],
)
def test_the_line_says_mode_rate_supply_and_what_is_waited_for(
    changes: dict[str, object], expected: str
) -> None:
    """Pressures are gauge, topics as they are resolved."""
    assert ready_line(RigParameters(changes), "/a/joint_states", "/a/valve/voltage") == expected


def test_a_set_is_named_after_the_preset_it_is_nearest_to() -> None:
    """What differs is named; how time passes is no property of the rig."""
    calibrated = RigParameters.preset("calibrated")
    assert preset_text(calibrated.with_values({"time.speed": 2.0})) == "calibrated"
    changes = {"supply.pressure": 5e5, "sensors.seed": 3, "cylinder.moving_mass": 2.0}
    text = preset_text(calibrated.with_values(changes))
    assert text == "calibrated (changed: supply.pressure, cylinder.moving_mass and 1 more)"


def test_instruments_do_not_tell_which_preset_it_is() -> None:
    """Those of the data sheets are many, and the rest of this rig is that of the paper."""
    text = preset_text(RigParameters.preset("paper").with_values(DATA_SHEET))
    assert text.startswith("paper (changed: sensors.")


class Subscriptions:
    """Subscriptions of one process, which match all at once when ``count`` is called a time."""

    def __init__(self, match_after: int) -> None:
        self._match_after = match_after
        self._calls = 0
        self.known = 0

    def count(self) -> int:
        """How many there are on any one of the topics."""
        self._calls += 1
        return int(self._calls > self._match_after)

    def poll(self) -> int:
        """The same, kept as a publisher does that sends on demand."""
        self.known = self.count()
        return self.known


@pytest.mark.parametrize("match_after", range(4))
def test_sample_0_goes_out_when_every_publisher_knows_its_subscribers(match_after: int) -> None:
    """A controller that matches between two counts is not sent positions without pressures."""
    subscriptions = Subscriptions(match_after)
    while not all_listen(subscriptions.count, [subscriptions], recorders=0):
        pass
    assert subscriptions.known == 1


@pytest.mark.parametrize(
    ("samples", "others", "recorders", "expected"),
    [(1, 0, 0, True), (0, 1, 0, False), (2, 1, 1, True), (1, 1, 1, False), (2, 0, 1, False)],
)
def test_recorders_hear_everything_and_one_more_the_samples(
    samples: int, others: int, recorders: int, expected: bool
) -> None:
    """Each topic has as many subscribers as recorders, the samples have one more."""
    publisher = Subscriptions(0 if others else 1)
    assert all_listen(lambda: samples, [publisher], recorders) == expected
