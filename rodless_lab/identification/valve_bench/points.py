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

from rodless_base.number_rows import number_rows

Array = npt.NDArray[np.float64]


def checked_points(columns: Mapping[str, npt.ArrayLike], fewest: int, curve: str) -> list[Array]:
    """Return :func:`number_rows`; raises as it does.

    And for fewer than the ``fewest`` points that ``curve`` needs.
    """
    found = number_rows(columns)
    if len(found[0]) < fewest:
        raise ValueError(f"{len(found[0])} points refused, {curve} needs {fewest} or more")
    return found
