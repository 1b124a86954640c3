# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Arrays of numbers out of what a caller gave for them."""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from numbers import Real

import numpy as np
import numpy.typing as npt

from rodless_base.one_line import described, shown

Array = npt.NDArray[np.float64]

# No instrument reads more, in whatever unit; sums of squares of a fifth power remain numbers.
LARGEST = 1e20


def numbers_of(values: npt.ArrayLike, name: str, unit: str = "") -> Array:
    """Return ``values`` as an array; raises ValueError, in one line with ``name``, for others.

    Others are texts, booleans, spans of time, complex numbers, and what is masked, although numpy
    makes numbers of them.
    """
    try:
        _refuse_other_than_numbers(values)
        # One of numpy's longer kind may be too large for a float: infinite then, as a scalar is.
        with np.errstate(over="ignore"):
            return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        kind = f"numbers of {unit}" if unit else "numbers"
        raise ValueError(
            f"{name} {shown(values)} refused: must be {kind} ({described(error)})"
        ) from error


def measured_numbers(values: npt.ArrayLike, name: str) -> Array:
    """Return :func:`numbers_of`; raises ValueError too for one that nothing can have measured."""
    numbers = numbers_of(values, name)
    bad = np.flatnonzero(~(np.abs(numbers) <= LARGEST))
    if len(bad):
        value = float(numbers.ravel()[bad[0]])
        wanted = f"{LARGEST:g} or less in size" if np.isfinite(value) else "finite"
        raise ValueError(f"{name}: value {bad[0]} is {value}, must be {wanted}")
    return numbers


def number_rows(columns: Mapping[str, npt.ArrayLike]) -> list[Array]:
    """Return ``columns`` as :func:`measured_numbers`, all of the shape (n,) of the first.

    Raises ValueError, in one line with the name, for other shapes.
    """
    rows = []
    for name, values in columns.items():
        row = measured_numbers(values, name)
        if row.ndim != 1:
            raise ValueError(f"{name}: of shape {row.shape}, must be one after the other, (n,)")
        rows.append(row)
        if len(row) != len(rows[0]):
            raise ValueError(f"{name}: {len(row)} values for {len(rows[0])} {next(iter(columns))}")
    return rows


def _refuse_other_than_numbers(values: npt.ArrayLike) -> None:
    """Raise TypeError for what numpy would take for numbers although it is none."""
    # Among numbers in a list, numpy makes numbers of booleans and of spans of time.
    kinds = set(map(type, values)) if isinstance(values, Sequence) else set()
    if np.ma.is_masked(values) or type(np.ma.masked) in kinds:
        raise TypeError("some are masked: fill or leave them out")
    found = np.asarray(values)
    if found.dtype.kind == "O":
        kinds = set(map(type, found.ravel().tolist()))
    if found.dtype.kind not in "iufO" or kinds & {bool, np.bool_, np.timedelta64}:
        raise TypeError("not texts, booleans, spans of time or complex numbers")
    if found.dtype.kind == "O" and not all(issubclass(kind, Real | Decimal) for kind in kinds):
        raise TypeError(f"not {', '.join(sorted(kind.__name__ for kind in kinds))}")
