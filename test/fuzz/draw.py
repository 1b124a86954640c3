# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Odd values, texts and bytes, drawn from a seed."""

import math
import random
from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")

FLOATS = (
    0.0, -0.0, 5e-324, -5e-324, 2.2e-308, 1e-300, 1e-30, 1e-9, 1e-3, 0.1, 1.0, -1.0, 5.08, 10.0,
    1e5, 1e9, 1e18, 2.0**53, 2.0**63, 1e30, 1e200, 1.7976931348623157e308, -1.7e308,
    math.inf, -math.inf, math.nan,
)  # fmt: skip
INTEGERS = (0, 1, -1, 2, 7, 255, 256, 2**31 - 1, 2**31, -(2**31), 2**32, 2**53 + 1, 2**63 - 1)
INTEGERS += (2**63, -(2**63), 2**64, 10**30, 10**400, 10**5000)
TEXTS = (
    "", " ", "\n", "\0", "a", "ä", "\U0001f600", "\ud800", "nan", "inf", "-inf", "1e5", "0x10",
    "true", "null", "~", "[1, 2]", "{a: 1}", "&a [*a]", "1:30:00", "../x", "/", "//", "/a//b",
    "%s%n", "{0}", "a" * 300, "x\ty", "carriage", "\u202e", "-", "1_000", "2001-01-01", "!!python",
)  # fmt: skip
KINDS = (
    lambda: None,
    lambda: True,
    lambda: False,
    object,
    dict,
    list,
    tuple,
    set,
    lambda: b"",
    lambda: b"12345678",
    lambda: bytearray(9),
    lambda: 1j,
    lambda: Decimal("0.1"),
    lambda: Decimal("NaN"),
    lambda: Decimal("1e400"),
    lambda: Fraction(1, 3),
    lambda: np.float64(0.5),
    lambda: np.float32(0.5),
    lambda: np.int64(3),
    lambda: np.uint64(2**64 - 1),
    lambda: np.bool_(True),
    lambda: np.array(0.1),
    lambda: np.array([0.1]),
    lambda: np.array([]),
    lambda: np.array([[1.0, 2.0]]),
    lambda: np.array(["a"]),
    lambda: np.array([None]),
    lambda: np.ma.masked_array([1.0, 2.0], [True, False]),
    lambda: np.datetime64("2001-01-01"),
    lambda: {"a": 1},
    lambda: {1: 2},
    lambda: [[[[]]]],
    lambda: range(3),
    lambda: (x for x in (1.0, 2.0)),
    lambda: math.sin,
    lambda: int,
)


class Draw(random.Random):
    """Draws what no careful caller would give."""

    def float(self) -> float:
        """Return a number, mostly an extreme one."""
        if self.random() < 0.6:
            return self.choice(FLOATS)
        return self.choice((1.0, -1.0)) * 10.0 ** self.uniform(-12.0, 8.0)

    def integer(self, low: int = -(2**63), high: int = 2**63 - 1) -> int:
        """Return a whole number of a range."""
        known = [number for number in INTEGERS if low <= number <= high]
        return self.choice(known) if self.random() < 0.6 else self.randint(low, high)

    def text(self, known: Sequence[str] = ()) -> str:
        """Return a text: one of ``known``, such a one spoilt, or another."""
        if known and self.random() < 0.7:
            text = self.choice(known)
            return text if self.random() < 0.6 else self.spoilt_text(text)
        if self.random() < 0.7:
            return self.choice(TEXTS)
        return "".join(chr(self.randrange(1, 0x2FF)) for _ in range(self.randrange(20)))

    def spoilt_text(self, text: str) -> str:
        """Return ``text`` with something put in, left out or put twice."""
        at, end = sorted(self.randrange(len(text) + 1) for _ in range(2))
        return text[:at] + self.choice(("", text[at:end] * 2, self.choice(TEXTS))) + text[end:]

    def spoilt(self, data: bytes) -> bytes:
        """Return ``data`` with some bytes changed, cut, put in or repeated."""
        found = bytearray(data)
        for _ in range(self.choice((1, 1, 2, 5))):
            at = self.randrange(len(found) + 1)
            size = self.choice((1, 1, 4, 8, 30))
            way = self.randrange(5)
            if way == 0 and at < len(found):
                found[at] ^= 1 << self.randrange(8)
            elif way == 1:
                found[at : at + size] = self.choice((b"\0", b"\xff", b"\x7f", b"\x80")) * size
            elif way == 2:
                del found[at : at + size]
            elif way == 3:
                found[at:at] = self.randbytes(size)
            elif self.random() < 0.3:
                del found[at:]
        return bytes(found)

    def value(self, depth: int = 2) -> object:
        """Return anything."""
        ways: list[Callable[[], object]] = [
            self.float,
            lambda: self.choice(INTEGERS),
            self.text,
            self.choice(KINDS),
        ]
        if depth:
            several = range(self.choice((1, 2, 3, 6, 9)))
            ways += [
                lambda: [self.value(depth - 1) for _ in several],
                lambda: tuple(self.float() for _ in several),
            ]
        return self.choice(ways)()

    def some(self, items: Sequence[Item], most: int = 3) -> list[Item]:
        """Return one or several of ``items``."""
        return self.sample(list(items), min(len(items), self.randint(1, most)))
