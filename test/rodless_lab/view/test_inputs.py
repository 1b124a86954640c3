# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What comes from a page is checked before anything is done with it."""

import math
from typing import Any

import pytest

from rodless_lab.view import inputs
from rodless_lab.view.errors import ViewError

RIG = {"reference.type": "setpoint", "reference.minimum": 0.0, "reference.maximum": 0.2}


@pytest.mark.parametrize("value", [0.0, 0.2, 0.058, 0, "0.1"])
def test_a_set_point_within_the_bounds_is_taken(value: Any) -> None:
    """Bounds included, as in the controller; in m."""
    assert inputs.set_point(value, RIG) == float(value)


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (-1e-9, "the controller takes 0 to 200 mm"),
        (0.2001, "200.1 mm refused"),
        (math.nan, "must be finite"),
        (math.inf, "must be finite"),
        (True, "must be a number"),
        (None, "must be a number"),
        ({"x": 1}, "must be a number"),
        ("1e", "must be a number"),
        ([0.1], "must be a number"),
    ],
)
def test_another_set_point_is_refused_in_words(value: Any, reason: str) -> None:
    """With the value and what would do."""
    with pytest.raises(ViewError, match=reason):
        inputs.set_point(value, RIG)


@pytest.mark.parametrize("kind", ["step", "sine"])
def test_a_step_and_a_sine_take_no_set_points(kind: str) -> None:
    """The controller would ignore it without a word."""
    with pytest.raises(ViewError, match=f"reference.type is {kind}"):
        inputs.set_point(0.1, {**RIG, "reference.type": kind})


def test_a_controller_without_such_parameters_judges_for_itself() -> None:
    """It may be anybody's."""
    assert inputs.set_point(3.0, {}) == 3.0


@pytest.mark.parametrize("value", [0, 1001, 1.5, "x", None, math.nan, -1])
def test_steps_are_whole_and_few(value: Any) -> None:
    """A page cannot keep the rig busy for long."""
    with pytest.raises(ViewError):
        inputs.steps(value)


def test_a_number_of_steps_is_taken() -> None:
    """Also as browsers send whole numbers."""
    assert [inputs.steps(value) for value in (1, 10.0, "3", 1000)] == [1, 10, 3, 1000]


@pytest.mark.parametrize(
    "name", ["../run1", "/run1", "a/b", "", ".", "..", ".hidden", "a b", "ä", "a" * 101, 5, "a\n"]
)
def test_a_bag_is_a_name_and_no_path(name: Any) -> None:
    """A page gets at the view's folder alone."""
    with pytest.raises(ViewError, match="must be a name"):
        inputs.bag_name(name)


def test_a_name_of_a_bag_is_taken() -> None:
    """As recorders make them."""
    assert inputs.bag_name("rosbag2_2026_01_01-10_00_00") == "rosbag2_2026_01_01-10_00_00"


def test_a_parameter_becomes_the_text_that_rodless_set_takes() -> None:
    """True is true, and nothing but numbers and texts gets through."""
    assert [inputs.parameter_text(one) for one in (True, 0.5, 3, "pid")] == [
        "true",
        "0.5",
        "3",
        "pid",
    ]
    for other in (["a"], 10**5000):
        with pytest.raises(ViewError, match="must be a number or a text"):
            inputs.parameter_text(other)
