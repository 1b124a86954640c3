# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Numbers on a command line."""

import argparse
import math
from collections.abc import Callable

from rodless_base.one_line import shown
from rodless_base.written_number import written_number


def number(text: str) -> float:
    """Return the number that ``text`` is, NaN for what is none: no bound holds for that."""
    try:
        return written_number(text)
    except ValueError:
        return math.nan


def real(text: str) -> float:
    """Return the number that ``text`` is; raises ArgumentTypeError."""
    try:
        return written_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a number") from None


def millimetres(text: str) -> float:
    """Return the length in mm that ``text`` is; raises ArgumentTypeError."""
    value = number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a length in mm")
    return value


# Digits of the longest whole number that is read: no count is longer, and Python reads none of
# thousands.
DIGITS = 18
BOUND = f" of at most {DIGITS} digits"


def positive_whole(text: str) -> int:
    """Return the positive whole number that ``text`` is; raises ArgumentTypeError."""
    if not _is_whole(text) or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a positive whole number{BOUND}")
    return int(text)


def count_up_to(most: int) -> Callable[[str], int]:
    """Return what reads a whole number from 1 to ``most``; that raises ArgumentTypeError."""

    def count(text: str) -> int:
        found = positive_whole(text)
        if found > most:
            raise argparse.ArgumentTypeError(f"{found} refused, must be {most} or less")
        return found

    return count


def whole(text: str) -> int:
    """Return the whole number from 0 on that ``text`` is; raises ArgumentTypeError."""
    if not _is_whole(text):
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a whole number from 0 on{BOUND}")
    return int(text)


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) <= DIGITS
