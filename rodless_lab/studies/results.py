# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The results of a sweep, read back from its folder."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rodless_base.extras import missing_extra
from rodless_base.one_line import described
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.study import Study

if TYPE_CHECKING:
    from pandas import DataFrame

DATA = "rows"  # the folder of the data set, below that of the sweep


class Results:
    """The rows of a sweep: number, seed, axes, figures and failure of each, in order.

    ``results["settling_time"]`` is an array of shape (n,). Traces are lists, one per row, in the
    columns ``trace.position`` and so on.
    """

    def __init__(self, table: Any, axes: tuple[str, ...], total: int) -> None:
        """Take a pyarrow table, the study's axes and its number of rows."""
        self._table = table
        self.axes = axes
        self.total = total

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return a column; raises KeyError."""
        found = self._table[name].to_numpy()
        return np.asarray(found)

    def __len__(self) -> int:
        return int(self._table.num_rows)

    def __repr__(self) -> str:
        return f"Results: {len(self)} of {self.total} rows, {len(self.failures)} failed"

    @property
    def complete(self) -> bool:
        """Whether all rows of the study are there."""
        return len(self) == self.total

    @cached_property
    def failures(self) -> Mapping[int, str]:
        """Why rows have no figures, by number."""
        pairs = zip(self["row"].tolist(), self["failure"].tolist(), strict=True)
        return {row: why for row, why in pairs if why}

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Return all columns by name."""
        return {name: self[name] for name in self._table.column_names}

    def to_dataframe(self) -> "DataFrame":
        """Return the rows as a pandas data frame, units in its ``attrs`` as those of a run.

        Raises ModuleNotFoundError without pandas.
        """
        try:
            frame: DataFrame = self._table.to_pandas()
        except ModuleNotFoundError as error:
            raise missing_extra("a data frame", error.name, "data") from error
        frame.attrs["units"] = {
            field.name: (field.metadata or {}).get(b"unit", b"").decode()
            for field in self._table.schema
        }
        return frame


def read_part(
    file: Path, study: Study, filters: Any = None, columns: Sequence[str] | None = None
) -> Any:
    """Return the table of a complete part, or those of its rows that pass pyarrow's ``filters``.

    Raises StudyError for a file that is damaged, or has other columns than ``study``.
    """
    import pyarrow as arrow  # noqa: PLC0415  there, or nothing would have been written
    from pyarrow import parquet  # noqa: PLC0415

    try:
        kinds = {one.name: one.type for one in parquet.read_schema(file)}
        table = parquet.read_table(file, filters=filters, columns=columns)
    except (arrow.ArrowException, OSError) as error:
        raise _damaged(file, described(error)) from error
    if tuple(kinds) != _columns(study):
        raise _damaged(file, "it has other columns than the study")
    if {kinds[name] for name in RunMetrics._fields} != {arrow.float64()}:
        raise _damaged(file, "it has figures that are no numbers")
    return table


def check_rows(file: Path, study: Study, rows: range) -> None:
    """Raise StudyError as :func:`read_part`, and where a part has not these ``rows``, in order."""
    found = read_part(file, study, columns=["row"])["row"].to_pylist()
    if found != list(rows):
        raise _damaged(file, f"it has {len(found)} rows that are not the {len(rows)} of its part")


def _columns(study: Study) -> tuple[str, ...]:
    """Return the names of a part's columns, in order."""
    axes = (one.name for one in study.dimensions)
    traces = (f"trace.{name}" for name in study.trace_columns)
    return tuple(dict.fromkeys(("row", "seed", *axes, *RunMetrics._fields, "failure", *traces)))


def _damaged(file: Path, why: str) -> StudyError:
    return StudyError(f"{file}: damaged, {why}; remove it, and the sweep's next run makes it anew")


def read_results(folder: Path, study: Study) -> Results:
    """Return the complete parts of a sweep; raises StudyError where there is none."""
    import pyarrow as arrow  # noqa: PLC0415  there, or nothing would have been written

    files = sorted((folder / DATA).glob("part-*.parquet"))
    axes = tuple(one.name for one in study.dimensions)
    if not files:
        raise StudyError(f"{folder}: no part of the sweep is complete yet; run it again")
    table = arrow.concat_tables([read_part(file, study) for file in files])
    return Results(table, axes, len(study))
