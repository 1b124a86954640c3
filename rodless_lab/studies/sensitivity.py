# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which parameter matters how much: Sobol indices by SALib (extra ``sensitivity``)."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.extras import missing_extra
from rodless_lab.simulation.design import MOST_ROWS, DesignError

Array = npt.NDArray[np.float64]

SALTELLI = "saltelli"


class Indices(NamedTuple):
    """Sobol indices of one figure, shape (axes,) each, with the half widths of 95 % intervals."""

    first: Array  # share of the variance that the axis makes by itself
    first_interval: Array
    total: Array  # share that it has a part in
    total_interval: Array


def _problem(names: Sequence[str]) -> dict[str, Any]:
    return {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)}


def saltelli(dimensions: int, samples: int, seed: int) -> Array:
    """Return Saltelli's design as shares, shape (samples (dimensions + 2), dimensions).

    Saltelli et al., Computer Physics Communications 181, 2010. Raises ModuleNotFoundError where
    SALib is not installed.
    """
    if samples < 1 or samples & (samples - 1):
        raise DesignError(f"rows {samples} refused: a Saltelli design needs a power of two")
    if dimensions == 0:
        raise DesignError("method saltelli refused: nothing varies; name parameters under vary")
    if samples * (dimensions + 2) > MOST_ROWS:
        raise DesignError(f"rows {samples} refused: more than {MOST_ROWS} runs; take fewer")
    try:
        from SALib.sample import sobol  # noqa: PLC0415  an extra
    except ModuleNotFoundError as error:
        raise missing_extra("a Saltelli design", error.name, "sensitivity") from error
    names = [f"x{k}" for k in range(dimensions)]
    found = sobol.sample(_problem(names), samples, calc_second_order=False, seed=seed)
    return np.asarray(found, dtype=np.float64)


def sobol_indices(names: Sequence[str], figures: Array, seed: int) -> Indices | None:
    """Return the indices of one figure, shape (rows,), of a Saltelli design over axes ``names``.

    None where a run has no such figure, or all have the same.
    """
    if not np.isfinite(figures).all() or np.ptp(figures) == 0.0:
        return None
    from SALib.analyze import sobol  # noqa: PLC0415  there, or the design would not be

    centred = (figures - figures.mean()) / figures.std()
    found = sobol.analyze(_problem(names), centred, calc_second_order=False, seed=seed)
    return Indices(*(np.asarray(found[key]) for key in ("S1", "S1_conf", "ST", "ST_conf")))
