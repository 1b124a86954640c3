# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One number out of what a caller gave for it."""

import math
from decimal import Decimal

from rodless_base.one_line import shown
from rodless_base.real_number import is_number, only_number


def single_number(value: object, name: str, unit: str) -> float:
    """Return ``value`` as a float, infinite where none is large enough.

    Arrays of one number count as that number, and decimals are numbers, as they are in an array.
    Raises TypeError, with ``name`` and ``unit``, for booleans, texts, what is masked, and what else
    is no number.
    """
    if type(value) is float:
        return value
    number = only_number(value)
    if not (is_number(number) or isinstance(number, Decimal)):
        raise TypeError(f"{name} {shown(value)} refused: must be a number of {unit}")
    try:
        return float(number)
    except OverflowError:
        return math.inf if number == abs(number) else -math.inf
    except ValueError:  # a decimal's signalling NaN
        return math.nan


def positive_number(value: object, name: str, unit: str) -> float:
    """Return :func:`single_number`; raises ValueError too for one that is not positive."""
    number = single_number(value, name, unit)
    if not number > 0.0:
        raise ValueError(f"{name} {shown(value)} refused: must be positive")
    return number
