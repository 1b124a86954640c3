# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What one parameter takes, and how it refuses the rest."""

import math
from fractions import Fraction

import numpy as np
import pytest

from rodless_base.one_line import shown
from rodless_base.parameters import Parameter, ParameterError

REAL = Parameter("toy.length", 1.0, "m", "a length", "test", 0.5, 2.0)
FREE = Parameter("toy.free", 0.0, "", "any number", "test")
COUNT = Parameter("toy.count", 3, "", "a count", "test", 0, 10)
SWITCH = Parameter("toy.switch", True, "", "a switch", "test")
TEXT = Parameter("toy.text", "a", "", "any text", "test")
CHOICE = Parameter("toy.choice", "red", "", "a choice", "test", choices=("red", "green"))
TRIPLE = Parameter("toy.triple", (1.0, 2.0, 3.0), "V", "three numbers", "test", -5.0, 5.0)


@pytest.mark.parametrize(
    ("parameter", "given", "taken"),
    [
        (REAL, 0.5, 0.5),
        (REAL, 2.0, 2.0),
        (REAL, 2, 2.0),
        (REAL, np.float64(1.5), 1.5),
        (REAL, np.float32(1.5), 1.5),
        (REAL, np.int64(1), 1.0),
        (REAL, Fraction(3, 2), 1.5),
        (FREE, -1e308, -1e308),
        (COUNT, 4, 4),
        (COUNT, 4.0, 4),
        (COUNT, np.int32(4), 4),
        (SWITCH, False, False),
        (TEXT, "", ""),
        (CHOICE, "green", "green"),
        (TRIPLE, [1, 2.5, -5], (1.0, 2.5, -5.0)),
        (TRIPLE, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        (TRIPLE, np.array([1.0, 2.0, 3.0]), (1.0, 2.0, 3.0)),
    ],
    ids=repr,
)
def test_good_values_are_taken_in_the_declared_type(
    parameter: Parameter, given: object, taken: object
) -> None:
    """Bounds included, integers for reals, lists for tuples; the type is always the default's."""
    found = parameter.check(given)
    assert found == taken
    assert type(found) is type(parameter.default)
    if isinstance(found, tuple):
        assert {type(item) for item in found} == {float}


@pytest.mark.parametrize(
    ("parameter", "value", "wanted"),
    [
        (REAL, 0.4999, "from 0.5 to 2 (m)"),
        (REAL, 2.0001, "from 0.5 to 2 (m)"),
        (REAL, math.nan, "from 0.5 to 2 (m)"),
        (REAL, math.inf, "from 0.5 to 2 (m)"),
        (REAL, True, "a number (m)"),
        (REAL, "1.0", "a number (m)"),
        (REAL, None, "a number (m)"),
        (REAL, [1.0], "a number (m)"),
        (REAL, 1j, "a number (m)"),
        (FREE, math.nan, "from -inf to inf"),
        (FREE, -math.inf, "from -inf to inf"),
        (FREE, 10**400, "from -inf to inf"),
        (COUNT, 2.5, "a whole number"),
        (COUNT, 11, "from 0 to 10"),
        (COUNT, -1, "from 0 to 10"),
        (COUNT, False, "a number"),
        (COUNT, math.nan, "from 0 to 10"),
        (COUNT, "3", "a number"),
        (SWITCH, 1, "true or false"),
        (SWITCH, 0.0, "true or false"),
        (SWITCH, "true", "true or false"),
        (SWITCH, None, "true or false"),
        (TEXT, 3, "a text"),
        (TEXT, None, "a text"),
        (CHOICE, "blue", "one of red, green"),
        (CHOICE, "Red", "one of red, green"),
        (CHOICE, True, "one of red, green"),
        (TRIPLE, [1.0, 2.0], "3 numbers (V)"),
        (TRIPLE, [1.0, 2.0, 3.0, 4.0], "3 numbers (V)"),
        (TRIPLE, "123", "3 numbers (V)"),
        (TRIPLE, 1.0, "3 numbers (V)"),
        (TRIPLE, None, "3 numbers (V)"),
    ],
    ids=repr,
)
def test_bad_values_are_refused_by_name(parameter: Parameter, value: object, wanted: str) -> None:
    """The message names the parameter, the value and what it must be, with its unit."""
    with pytest.raises(ParameterError) as refusal:
        parameter.check(value)
    assert str(refusal.value) == f"{parameter.name}: {shown(value)} refused, must be {wanted}"


@pytest.mark.parametrize("item", [math.nan, 5.1, "2", True, None])
def test_a_bad_item_of_a_tuple_is_refused_by_its_own_value(item: object) -> None:
    """Of three numbers the one that is wrong stands in the message."""
    with pytest.raises(ParameterError, match=r"^toy\.triple: ") as refusal:
        TRIPLE.check([1.0, item, 3.0])
    assert repr(item) in str(refusal.value)


def test_a_refusal_is_a_value_error() -> None:
    """Callers that know nothing of this project catch it as what it is."""
    with pytest.raises(ValueError, match=r"toy\.length"):
        REAL.check(-1.0)
