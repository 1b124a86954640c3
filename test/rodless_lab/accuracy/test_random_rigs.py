# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rigs of the campaign: known by number, each another, all of them rigs that can move."""

import numpy as np

from rodless_lab.accuracy.random_rigs import WHOLE_RANGE, case
from rodless_sim import RigParameters

COUNT = 60


def test_a_number_gives_the_same_rig_each_time() -> None:
    """Twice the same, and no two numbers alike."""
    one, again, other = case(12), case(12), case(15)
    assert one.parameters == again.parameters
    assert one.position == again.position
    assert np.array_equal(one.voltages, again.voltages)  # type: ignore[arg-type]
    assert one.parameters != other.parameters


def test_neighbourhoods_and_drives_take_turns() -> None:
    """As many of each; open loop has voltages within 0 to 10 V, closed loop law and reference."""
    cases = [case(number) for number in range(COUNT)]
    for around in ("paper", "saturating", WHOLE_RANGE):
        for drive in ("open loop", "closed loop"):
            group = [one for one in cases if (one.around, one.drive) == (around, drive)]
            assert len(group) == COUNT / 6
    for one in cases:
        assert (one.voltages is None) == (one.law is not None) == (one.reference is not None)
        if one.voltages is not None:
            assert one.voltages.min() >= 0.0
            assert one.voltages.max() <= 10.0
        assert 0.0 <= one.position <= one.parameters.number("cylinder.stroke")


def test_the_whole_range_is_the_whole_range() -> None:
    """Bores of 40 rigs lie in both the lowest and the highest fifth; the preset's are near it."""
    whole = [case(number).parameters for number in range(3 * COUNT) if number % 3 == 2]
    bores = [parameters.number("cylinder.bore") for parameters in whole]
    assert min(bores) < 0.02
    assert max(bores) > 0.08
    default = RigParameters().number("cylinder.bore")
    for number in range(COUNT):
        if case(number).around != WHOLE_RANGE:
            assert 0.5 <= case(number).parameters.number("cylinder.bore") / default <= 2.0
