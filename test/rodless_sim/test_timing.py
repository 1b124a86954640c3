"""Plant time in whole nanoseconds, and its exact division into inner steps."""

import math
import re
from fractions import Fraction

import pytest

from rodless_sim.timing import division, inner_steps, nanoseconds

SPANS = ("1e-9", "1e-4", "0.0001234", "4.01e-4", "1e-3", "2.5e-3", "0.01", "1", "7.77", "3600")
STEPS = ("1e-7", "3e-6", "4.01e-6", "7e-6", "1e-5", "1.3e-5", "2e-5", "1e-3")


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
    with pytest.raises(ValueError, match=re.escape(f"duration {duration!r} s refused")):
        division(duration, 2e-5)


@pytest.mark.parametrize("span", SPANS)
@pytest.mark.parametrize("longest", STEPS)
def test_inner_steps_divide_a_period_exactly(span: str, longest: str) -> None:
    """As many as exact arithmetic asks for: the fewest that are not too long."""
    exact = Fraction(span) * 10**9
    assert exact.denominator == 1
    steps, step = inner_steps(int(exact), float(longest))
    assert steps == max(1, math.ceil(Fraction(span) / Fraction(longest)))
    assert steps * step == pytest.approx(float(span), rel=1e-15)
    assert step <= float(longest) * (1.0 + 1e-9)


def test_the_default_step_divides_a_millisecond_by_fifty() -> None:
    """20 µs go into 1 ms without a remainder, in spite of binary fractions."""
    assert inner_steps(1_000_000, 2e-5) == (50, 2e-5)


@pytest.mark.parametrize("span", SPANS)
def test_a_division_is_both_at_once(span: str) -> None:
    """Nanoseconds, number of steps and step of a duration, the same each time it is asked."""
    expected = (nanoseconds(float(span)), *inner_steps(nanoseconds(float(span)), 2e-5))
    assert division(float(span), 2e-5) == expected
    assert division(float(span), 2e-5) == expected
