# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Axes of a study: where a share of them is, and what is at a share."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodless_lab import Range, draw
from rodless_lab.simulation.design import DesignError, seed_of, shares


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6), st.booleans())
def test_a_range_ends_where_it_says(one: float, other: float, logarithmic: bool) -> None:
    """Its ends are exact, and nothing between lies beyond them, whatever the rounding."""
    if one == other:
        return
    axis = Range(min(one, other), max(one, other), logarithmic=logarithmic)
    assert (axis.at(0.0), axis.at(1.0)) == (axis.low, axis.high)
    for share in (math.ulp(0.0), 0.3, math.nextafter(1.0, 0.0)):
        assert axis.low <= axis.at(share) <= axis.high


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_share_is_where_a_value_is(logarithmic: bool) -> None:
    """The way back from a value, by hand at the middle; the nearer end for one outside."""
    axis = Range(1.0, 100.0, logarithmic=logarithmic)
    middle = 10.0 if logarithmic else 50.5
    assert axis.share(middle) == pytest.approx(0.5)
    assert [axis.share(value) for value in (1.0, 100.0, 0.1, 1e9)] == [0.0, 1.0, 0.0, 1.0]


def test_the_numbers_of_numpy_are_numbers() -> None:
    """A count, a seed and the ends of a range may come out of an array."""
    axis = Range(np.float32(1.0), np.float32(3.0), np.int64(3))
    assert list(axis.levels()) == [1.0, 2.0, 3.0]
    assert np.array_equal(shares("sobol", np.int64(4), 2, np.int32(5)), shares("sobol", 4, 2, 5))
    assert seed_of(np.int64(7), 3) == seed_of(7, 3)


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ((2.0, 0.7), "from 2.0 to 0.7 refused: must be two finite numbers"),
        ((0.7, float("nan")), "from 0.7 to nan refused: must be two finite numbers"),
        ([], "no values to choose from"),
    ],
)
def test_a_range_that_cannot_be_is_refused_by_the_parameter(given: object, line: str) -> None:
    """Of several ranges in one draw the line says which."""
    ranges = {"supply.pressure": (5e5, 6e5), "cylinder.moving_mass": given}
    with pytest.raises(DesignError, match=f"^cylinder.moving_mass: {line}"):
        list(draw(ranges, 3))


@pytest.mark.parametrize(("count", "seed"), [(3.0, 1), (True, 1), (3, 1.5)])
def test_counts_and_seeds_are_whole_numbers(count: object, seed: object) -> None:
    """3.0 lies between the bounds that the line gives, so that it must say more."""
    with pytest.raises(DesignError, match="refused: must be a whole number from"):
        list(draw({"supply.pressure": (5e5, 6e5)}, count, seed=seed))  # type: ignore[arg-type]
