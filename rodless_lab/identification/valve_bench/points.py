# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Points that were measured at a valve, checked before a curve is laid through them."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import described, shown

Array = npt.NDArray[np.float64]


def checked_points(columns: Mapping[str, npt.ArrayLike], fewest: int, curve: str) -> list[Array]:
    """Return ``columns`` as arrays of one shape (n,).

    Raises ValueError, in one line, for fewer than the ``fewest`` points that ``curve`` needs, for
    columns of other shapes than the first, and for what is no finite number.
    """
    found = [_numbers(name, values) for name, values in columns.items()]
    count = len(found[0])
    for name, values in zip(columns, found, strict=True):
        if len(values) != count:
            raise ValueError(f"{name}: {len(values)} values for {count} {next(iter(columns))}")
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise ValueError(f"{name}: value {bad[0]} is {values[bad[0]]}, must be finite")
    if count < fewest:
        raise ValueError(f"{count} points refused, {curve} needs {fewest} or more")
    return found


def _numbers(name: str, values: npt.ArrayLike) -> Array:
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name}: {shown(values)} refused: {described(error)}") from error
    if numbers.ndim != 1:
        raise ValueError(f"{name}: of shape {numbers.shape}, must be one after the other, (n,)")
    return numbers
