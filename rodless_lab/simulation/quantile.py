# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One rule for "90 % of the rigs": the least value of a rig that so many of them do not exceed."""

import math

import numpy as np
import numpy.typing as npt


def quantile(values: npt.ArrayLike, share: float) -> float:
    """Return the ``share`` quantile of ``values``, shape (n,): one of them, not between two.

    A rig that does not have the figure (NaN), because it never settled or its run failed, is worse
    than all that have: it counts as infinite, and nothing lies between it and another.
    """
    return float(_from_quantile(values, share)[0])


def mean_beyond(values: npt.ArrayLike, share: float) -> float:
    """Return the mean of the quantile and of all that lie beyond it in the order of their size."""
    return float(np.mean(_from_quantile(values, share)))


def nth(count: int, share: float) -> str:
    """Return which of ``count`` values, by their size, the ``share`` quantile is.

    Examples
    --------
    >>> nth(100, 0.9)
    '90th'
    """
    place = _place(count, share)
    endings = {1: "st", 2: "nd", 3: "rd"}
    teens = place // 10 % 10 == 1
    return f"{place}{'th' if teens else endings.get(place % 10, 'th')}"


def _place(count: int, share: float) -> int:
    # 0.55 is a little more in binary: of a hundred it is the 55th all the same.
    return max(math.ceil(share * count - 1e-9), 1)


def _from_quantile(values: npt.ArrayLike, share: float) -> npt.NDArray[np.float64]:
    found = np.asarray(values, dtype=np.float64)
    there = np.sort(np.where(np.isnan(found), np.inf, found))
    return there[_place(len(there), share) - 1 :]
