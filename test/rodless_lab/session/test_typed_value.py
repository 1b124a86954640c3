# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Texts become values of a parameter's type, or are refused by name."""

import pytest
from rcl_interfaces.msg import ParameterType

from rodless_lab.session.running_rig import RigError
from rodless_lab.session.set_parameters import typed_value

BOOL, INTEGER = ParameterType.PARAMETER_BOOL, ParameterType.PARAMETER_INTEGER
REAL, TEXT = ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_STRING
REALS = ParameterType.PARAMETER_DOUBLE_ARRAY


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("600000", REAL, 600000.0),
        ("6e5", REAL, 600000.0),
        ("-0.5", REAL, -0.5),
        ("3", INTEGER, 3),
        ("1e3", INTEGER, 1000),
        ("9007199254740993", INTEGER, 2**53 + 1),
        ("9223372036854775807", INTEGER, 2**63 - 1),
        ("-9223372036854775808", INTEGER, -(2**63)),
        ("true", BOOL, True),
        ("False", BOOL, False),
        ("sine", TEXT, "sine"),
        ("12", TEXT, "12"),
        ("1,2.5,3e-1", REALS, [1.0, 2.5, 0.3]),
        ("[1, 2]", REALS, [1.0, 2.0]),
    ],
)
def test_a_text_becomes_what_the_parameter_takes(text: str, kind: int, value: object) -> None:
    """The type is the parameter's, not what the text looks like."""
    found = typed_value("some.name", text, kind)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "kind", "wanted"),
    [
        ("high", REAL, "a number"),
        ("1,2", REAL, "a number"),
        ("600_000", REAL, "a number"),
        ("1_000", INTEGER, "a whole number of at most 64 bits"),
        ("2.5", INTEGER, "a whole number of at most 64 bits"),
        ("inf", INTEGER, "a whole number of at most 64 bits"),
        ("nan", INTEGER, "a whole number of at most 64 bits"),
        ("9223372036854775808", INTEGER, "a whole number of at most 64 bits"),
        ("-9223372036854775809", INTEGER, "a whole number of at most 64 bits"),
        ("1e300", INTEGER, "a whole number of at most 64 bits"),
        ("yes", BOOL, "true or false"),
        ("1,two", REALS, "numbers with commas between them"),
    ],
)
def test_a_text_of_the_wrong_kind_is_refused_by_name(text: str, kind: int, wanted: str) -> None:
    """One line: the name, the text, and what it must be."""
    with pytest.raises(RigError) as refused:
        typed_value("some.name", text, kind)
    assert str(refused.value) == f"some.name: {text!r} refused, must be {wanted}"
