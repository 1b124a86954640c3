# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Numbers of the command line: what people write is read, what only Python's source allows not."""

import argparse
import math

import pytest

from rodless_lab.cli.number import count_up_to, millimetres, number


@pytest.mark.parametrize(
    ("text", "value"), [("58", 58.0), ("-0.5", -0.5), ("1e2", 100.0), (" 7 ", 7.0), (".5", 0.5)]
)
def test_a_number_is_read(text: str, value: float) -> None:
    """With a point or an exponent, as a length in mm too."""
    assert number(text) == millimetres(text) == value


@pytest.mark.parametrize("text", ["1_0", "５８", "٣", "", "5,8", "fast", "0x10"])
def test_what_is_no_number_is_refused_by_name(text: str) -> None:
    """``1_0`` is ten in Python's source and a slip of the finger on a command line."""
    assert math.isnan(number(text))
    with pytest.raises(argparse.ArgumentTypeError, match="is not a length in mm"):
        millimetres(text)


def test_a_count_is_refused_beyond_its_bound() -> None:
    """The bound itself is read; one more is refused with both numbers, and so is what is none."""
    count = count_up_to(10)
    assert [count("1"), count("10")] == [1, 10]
    with pytest.raises(argparse.ArgumentTypeError, match=r"^11 refused, must be 10 or less$"):
        count("11")
    for text in ("0", "-1", "ten"):
        with pytest.raises(argparse.ArgumentTypeError, match="is not a positive whole number"):
            count(text)
