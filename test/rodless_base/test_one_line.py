# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What others have made is shown in one short line, whatever it is."""

from array import array

import numpy as np
import pytest

from rodless_base.one_line import LONGEST, described, in_one_line, shown


class SilentError(Exception):
    """An exception that cannot be printed."""

    def __str__(self) -> str:
        raise RuntimeError("no text")


class Hidden:
    """A value that cannot be shown."""

    __slots__ = ()

    def __repr__(self) -> str:
        raise RuntimeError("no text")


@pytest.mark.parametrize(
    "value",
    [10**5000, "x" * 2_000_000, ["a\nb"] * 9, np.zeros((1000, 1000)), Hidden(), {1: {2: {3: 4}}}],
    ids=["integer", "text", "list", "array", "hidden", "deep"],
)
def test_any_value_is_shown_in_one_short_line(value: object) -> None:
    """Where repr() is long, has several lines, or fails."""
    text = shown(value)
    assert 0 < len(text) <= LONGEST
    assert "\n" not in text


def test_a_whole_number_too_long_to_write_is_shown_by_its_length() -> None:
    """Python itself refuses to write it."""
    assert shown(10**5000) == "a whole number of some 5000 digits"
    assert shown(-(10**99)) == repr(-(10**99))[:38] + "..." + repr(-(10**99))[-39:]


def test_short_values_are_shown_as_python_shows_them() -> None:
    """Nothing is lost of what fits."""
    for value in (1.5, "text", (1, 2), [0.1], None, {"a": 1}):
        assert shown(value) == repr(value)


def test_the_array_of_a_parameter_is_shown_as_the_list_it_is() -> None:
    """ROS gives lists of numbers as arrays; of a long one the first are shown, as of a list."""
    assert shown(array("d", [0.1, 2.0])) == "[0.1, 2.0]"
    numbers = [float(number) for number in range(100)]
    assert shown(array("d", numbers)) == shown(numbers)


def test_any_exception_is_described_in_one_short_line() -> None:
    """Where its text is 2 MB long, or cannot be had."""
    assert described(ValueError("a\n  b")) == "a b"
    assert len(described(ValueError("x\n" * 1_000_000))) <= LONGEST
    assert described(SilentError()) == "(its text cannot be shown)"


def test_a_text_that_is_cut_keeps_its_beginning_and_its_end() -> None:
    """What is said there is mostly what counts."""
    text = in_one_line("begin " + "x " * 1_000_000 + " end")
    assert text.startswith("begin x")
    assert text.endswith("x end")
    assert len(text) <= LONGEST


def test_what_is_no_letter_is_spelt_out() -> None:
    """A NUL ends a message of ROS, and what follows ESC commands a terminal; é is a letter."""
    assert in_one_line("a\nb \x00 \x1b[31m é °") == "a b \\x00 \\x1b[31m é °"
