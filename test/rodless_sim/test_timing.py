# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant time in whole nanoseconds."""

import math
import re

import pytest

from rodless_sim.timing import nanoseconds


@pytest.mark.parametrize(
    ("duration", "expected"),
    [(1e-9, 1), (1e-3, 1_000_000), (0.1 + 0.2, 300_000_000), (1.0 / 3.0, 333_333_333),
     (86400.0, 86_400_000_000_000), (5.1e-10, 1), (2, 2_000_000_000)],
)  # fmt: skip
def test_a_duration_is_rounded_to_the_nanosecond(duration: float, expected: int) -> None:
    """An integer comes out, free of the float's last digit."""
    found = nanoseconds(duration)
    assert (found, type(found)) == (expected, int)


@pytest.mark.parametrize(
    "duration", [0.0, -0.0, -1e-3, 4e-10, math.nan, math.inf, -math.inf, 1e308]
)
def test_a_duration_must_be_positive(duration: float) -> None:
    """None, a negative one, less than half a nanosecond, or no number: refused with its value."""
    with pytest.raises(ValueError, match=re.escape(f"duration {duration!r} s refused")):
        nanoseconds(duration)
