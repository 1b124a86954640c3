# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Points that were measured at a valve, checked before a curve is laid through them."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def check_points(name: str, places: Array, unknowns: int, curve: str) -> None:
    """Raise ValueError where points at ``places``, shape (n,), do not determine ``curve``.

    It has ``unknowns`` values. One point more than these tells how well it is met; and a point
    beside another at the same place, by its ``name``, tells nothing new of the curve.
    """
    if len(places) <= unknowns:
        raise ValueError(f"{len(places)} points refused, {curve} needs {unknowns + 1} or more")
    different = len(np.unique(places))
    if different < unknowns:
        raise ValueError(f"{name}: {different} different refused, {curve} needs {unknowns} or more")


def check_opened(name: str, values: Array) -> None:
    """Raise ValueError for ``values``, by their ``name``, of a valve that lets nothing through."""
    if not np.any(values):
        raise ValueError(f"{name}: all 0 refused, nothing flowed; check the flow meter")
