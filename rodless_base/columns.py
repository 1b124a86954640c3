# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Runs as named columns with units: as a data frame, as CSV, as Parquet.

A class of arrays inherits :class:`Columns` and states the unit of each array beside it:
``position: Annotated[Array, "m"]``.
"""

from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_type_hints

import numpy as np
import numpy.typing as npt

from rodless_base.atomic_write import atomic_write
from rodless_base.extras import missing_extra
from rodless_base.file_path import file_path
from rodless_base.one_line import OneLineError

if TYPE_CHECKING:
    from pandas import DataFrame

Array = npt.NDArray[Any]


class Quantity(NamedTuple):
    """An annotated field: ``name: Annotated[kind, unit, meaning]``, the meaning optional."""

    name: str
    unit: str
    meaning: str = ""


def quantities(kind: type) -> tuple[Quantity, ...]:
    """Return the annotated fields of a class, in order, those of its base classes first."""
    return _quantities(kind)


@cache
def _quantities(kind: type) -> tuple[Quantity, ...]:
    hints = get_type_hints(kind, include_extras=True)
    return tuple(
        Quantity(name, *hint.__metadata__)
        for name, hint in hints.items()
        if hasattr(hint, "__metadata__")
    )


class Columns:
    """A run whose arrays, all of one shape (n,), are columns of a table."""

    def columns(self) -> dict[str, Array]:
        """Return the arrays by name, shape (n,) each, in the order of the table."""
        return {name: getattr(self, name) for name in self.units()}

    def units(self) -> dict[str, str]:
        """Return the unit of each column by name, such as ``m/s``; empty for none."""
        return {quantity.name: quantity.unit for quantity in quantities(type(self))}

    def to_dataframe(self) -> "DataFrame":
        """Return the columns as a pandas data frame.

        Returns
        -------
        DataFrame
            One row per sample; ``DataFrame.attrs["units"]`` holds the units by column.

        Raises
        ------
        ModuleNotFoundError
            Where pandas is not installed; the text says how to get it.
        """
        try:
            from pandas import DataFrame  # noqa: PLC0415  an extra
        except ModuleNotFoundError as error:
            raise missing_extra("a data frame", error.name, "data") from error
        frame: DataFrame = DataFrame(self.columns())
        frame.attrs["units"] = self.units()
        return frame

    def save(self, path: str | Path) -> None:
        """Write the columns to a file, whole or not at all.

        Numbers in CSV have as many digits as it takes to read the same bits back. Its first line
        holds the units, the second the names: a spreadsheet shows both as rows,
        ``pandas.read_csv(path, comment="#")`` takes the names. Parquet has the units in the
        metadata of each field.

        Parameters
        ----------
        path
            Ends in ``.csv``, or in ``.parquet``, which needs pyarrow. A symbolic link stays
            one: its target is written.

        Raises
        ------
        TypeError
            For what is no path.
        ValueError
            For another ending, or a path that no file can have.
        ModuleNotFoundError
            Where pyarrow is needed and not installed; the text says how to get it.
        OSError
            Where the file cannot be written.
        """
        file = file_path(path)
        if file.suffix not in (".csv", ".parquet"):
            raise OneLineError(f"{path}: cannot be saved in this format; use .csv or .parquet")
        content = self._csv() if file.suffix == ".csv" else self._parquet()
        atomic_write(file, content)

    def _csv(self) -> str:
        columns, units = self.columns(), self.units()
        rows = zip(*(map(repr, values.tolist()) for values in columns.values()), strict=True)
        lines = [
            "# units: " + ",".join(units[name] for name in columns),
            ",".join(columns),
            *map(",".join, rows),
        ]
        return "\n".join(lines) + "\n"

    def _parquet(self) -> bytes:
        try:
            import pyarrow as arrow  # noqa: PLC0415  an extra
            from pyarrow import parquet  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise missing_extra("Parquet", error.name, "data") from error
        columns, units = self.columns(), self.units()
        arrays = [arrow.array(np.ascontiguousarray(values)) for values in columns.values()]
        schema = arrow.schema(
            [
                arrow.field(name, array.type, metadata={"unit": units[name]})
                for name, array in zip(columns, arrays, strict=True)
            ]
        )
        buffer = BytesIO()
        parquet.write_table(arrow.Table.from_arrays(arrays, schema=schema), buffer)
        return buffer.getvalue()
