# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rule for "90 % of the rigs", by counting."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodless_lab.simulation.quantile import mean_beyond, quantile


@given(st.lists(st.floats(0.0, 9.0) | st.just(nan), min_size=1, max_size=200), st.integers(1, 100))
def test_it_is_the_least_value_that_so_many_do_not_exceed(
    values: list[float], percent: int
) -> None:
    """Of any number of rigs; a rig without the figure exceeds all that have it."""
    counted = [inf if value != value else value for value in values]  # noqa: PLR0124  NaN

    def enough(value: float) -> bool:
        return 100 * sum(one <= value for one in counted) >= percent * len(counted)

    assert quantile(values, percent / 100) == min(value for value in counted if enough(value))


@pytest.mark.parametrize(("share", "expected"), [(0.5, 50.0), (0.9, 90.0), (1.0, 100.0)])
def test_of_a_hundred_rigs_it_is_the_one_of_that_number(share: float, expected: float) -> None:
    """The fiftieth, the ninetieth, the worst; of two, the better one is the median."""
    assert quantile([float(k) for k in range(100, 0, -1)], share) == expected
    assert quantile([2.0, 1.0], 0.5) == 1.0


def test_it_is_so_of_any_share_in_per_cent() -> None:
    """Of up to 200 rigs, also where a share times their number is not exact in binary."""
    for count in range(1, 201):
        values = [float(k) for k in range(1, count + 1)]
        expected = [max(-(-percent * count // 100), 1) for percent in range(1, 101)]
        assert [quantile(values, percent / 100) for percent in range(1, 101)] == expected


def test_the_mean_beyond_has_as_many_rigs_whatever_their_ties() -> None:
    """Of a hundred from the 90th on: eleven, by hand, though 95 of them are alike."""
    assert mean_beyond([1.0] * 95 + [10.0] * 5, 0.9) == (6 * 1.0 + 5 * 10.0) / 11
