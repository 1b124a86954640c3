# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Values and names that are no parameters: refused in one line, by name, and nothing changes."""

import copy
import math
import pickle

import numpy as np
import pytest

from rodless_base.one_line import shown
from rodless_base.parameters import (
    LARGEST_INTEGER,
    Parameter,
    ParameterError,
    ParameterSet,
    declare,
)
from rodless_sim import RigParameters

COUNT = Parameter("mine.count", 60, "", "how many", "none")
COEFFICIENTS = "valve.area_coefficients"


class Own(ParameterSet):
    """A set with a whole number that has no limits."""

    DECLARATIONS = declare(COUNT)


@pytest.mark.parametrize(
    "value",
    [10**5000, -(10**5000), 2**63, 1e30, np.uint64(2**64 - 1), math.inf],
    ids=["long", "long, negative", "65 bits", "real", "unsigned", "infinite"],
)
def test_a_whole_number_out_of_range_is_refused_with_the_range(value: object) -> None:
    """In whole numbers: of its own, or of 64 bits where it has none."""
    with pytest.raises(ParameterError) as refused:
        COUNT.check(value)
    wanted = f"from {-(2**63)} to {2**63 - 1}"
    assert str(refused.value) == f"mine.count: {shown(value)} refused, must be {wanted}"
    with pytest.raises(ParameterError, match=r"refused, must be from 0 to 2147483647$"):
        RigParameters({"sensors.seed": value})


@pytest.mark.parametrize("name", [1, None, ("a", 1), 2.5])
def test_a_name_that_is_no_text_is_refused_by_name(name: object) -> None:
    """In a new set and in a changed one."""
    for make in (RigParameters, RigParameters().with_values):
        with pytest.raises(ParameterError, match="no such parameter; names are texts"):
            make({name: 2})  # type: ignore[dict-item]


@pytest.mark.parametrize("name", ["two\nlines", "reference.\nat", "x" * 1_000_000])
def test_a_name_is_refused_in_one_short_line(name: str) -> None:
    """What is nobody's, and what looks like another node's; in the node's own words too."""
    for text in (RigParameters.unknown(name), refusal_of(name)):
        assert "no such parameter" in text
        assert "\n" not in text
        assert len(text) < 700


def refusal_of(name: str) -> str:
    """Return what is said of a set with that name."""
    with pytest.raises(ParameterError) as refused:
        RigParameters({name: 1.0})
    return str(refused.value)


@pytest.mark.parametrize("name", [[], {}, np.zeros(2), 5, None])
def test_what_cannot_be_a_name_is_no_name(name: object) -> None:
    """Of a parameter, and of a preset: lists and arrays too, which no dict has as keys."""
    with pytest.raises(KeyError, match="no such parameter; names are texts"):
        RigParameters().number(name)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"no preset .*; there are calibrated, paper"):
        RigParameters.preset(name)  # type: ignore[arg-type]


@pytest.mark.parametrize("values", [5, [1, 2], "abc", "", b"", bytearray()])
def test_what_holds_no_values_by_name_is_refused(values: object) -> None:
    """The text says what to give."""
    for make in (RigParameters, RigParameters().with_values):
        with pytest.raises(TypeError, match="must be values by name"):
            make(values)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "value",
    [
        b"123456789",
        bytearray(9),
        "123456789",
        np.array(1.0),
        dict.fromkeys(range(9)),
        set(range(9)),
        np.ones((9, 2)),
        3,
        None,
    ],
    ids=str,
)
def test_what_is_no_list_of_numbers_is_refused(value: object) -> None:
    """Bytes have a length and numbers in them; an array without dimensions has no length."""
    with pytest.raises(ParameterError, match=rf"^{COEFFICIENTS}: .* refused, must be ") as refusal:
        RigParameters({COEFFICIENTS: value})
    assert "\n" not in str(refusal.value)


def test_lists_tuples_and_arrays_are_lists_of_numbers() -> None:
    """All of them give the same set."""
    given = RigParameters()[COEFFICIENTS]
    assert isinstance(given, tuple)
    for kind in (list, tuple, np.array):
        assert RigParameters({COEFFICIENTS: kind(given)}) == RigParameters()


@pytest.mark.parametrize("name", ["supply.pressure", "sensors.seed"])
def test_a_number_with_5001_digits_is_refused_in_one_line(name: str) -> None:
    """Python does not even print it."""
    with pytest.raises(ParameterError, match=rf"^{name}: .* refused, must be from") as refusal:
        RigParameters({name: 10**5000})
    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize("value", [1e300, 2**63, -(2**63) - 1, math.inf, 10**5000], ids=shown)
def test_a_whole_number_that_ros_cannot_hold_is_refused(value: object) -> None:
    """Even where the parameter has no limits of its own."""
    with pytest.raises(ParameterError, match=r"^mine\.count: .* refused"):
        Own({"mine.count": value})


@pytest.mark.parametrize("value", [2**53 + 1, LARGEST_INTEGER, -5, 7.0, np.int64(3)])
def test_whole_numbers_keep_all_their_digits(value: int) -> None:
    """A float would round the large ones."""
    assert Own({"mine.count": value})["mine.count"] == int(value)
    assert type(Own({"mine.count": value})["mine.count"]) is int


def test_a_whole_number_without_limits_has_a_descriptor() -> None:
    """Its range is that of ROS."""
    from rodless_base.ros.parameters import descriptor  # noqa: PLC0415

    (limits,) = descriptor(COUNT).integer_range
    assert (limits.from_value, limits.to_value) == (-(2**63), 2**63 - 1)


def test_a_set_can_be_pickled_and_copied_with_its_origin() -> None:
    """It says afterwards where it came from, as before."""
    for given in (RigParameters.preset("calibrated").with_values({"supply.pressure": 6e5}),):
        for found in (pickle.loads(pickle.dumps(given)), copy.copy(given), copy.deepcopy(given)):
            assert found == given
            assert repr(found) == repr(given)
            assert eval(repr(found), {"RigParameters": RigParameters}) == given
