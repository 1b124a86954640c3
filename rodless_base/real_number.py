# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What counts as a number where one is wanted."""

import operator
from numbers import Real
from typing import SupportsIndex, TypeGuard

import numpy as np

from rodless_base.one_line import shown


def is_number(value: object) -> TypeGuard[float]:
    """Whether ``value`` is a real number, of whatever size: no boolean, nothing without a float.

    numpy's spans of time count as whole numbers in Python, and have no float.
    """
    if type(value) is float:
        return True
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        float(value)
    except OverflowError:  # a whole number too large for one
        return True
    except TypeError:
        return False
    return True


def only_number(value: object) -> object:
    """Return the number of an array that has one, and no mask on it; anything else as it is."""
    if isinstance(value, np.ndarray) and value.size == 1 and not np.ma.is_masked(value):
        return value.item()
    return value


def whole_number(value: SupportsIndex, name: str) -> int:
    """Return the whole number that ``value`` is; raises TypeError with the ``name`` for others."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name} {shown(value)} refused, must be a whole number") from None
