# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The results of a sweep, read back from its folder."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rodless_base.extras import missing_extra
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.parts import Parts
from rodless_lab.studies.study import Study

if TYPE_CHECKING:
    from pandas import DataFrame


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

    def some(self, count: int) -> "Results":
        """Return so many rows, drawn at random, in their order, or all that there are."""
        if len(self) <= count:
            return self
        random = np.random.default_rng(0)
        chosen = np.sort(random.choice(len(self), count, replace=False))
        return Results(self._table.take(chosen), self.axes, self.total)

    def unit(self, name: str) -> str:
        """Return the unit of a column, empty where it has none; raises KeyError."""
        metadata = self._table.schema.field(name).metadata or {}
        return str(metadata.get(b"unit", b"").decode())

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
        frame.attrs["units"] = {name: self.unit(name) for name in self._table.column_names}
        return frame


def read_results(folder: Path, study: Study, traces: bool = True) -> Results:
    """Return the complete parts of a sweep, with their ``traces``, which may fill the memory.

    Raises StudyError where there is none, or something in the data set is not as it was written;
    OSError.
    """
    import pyarrow as arrow  # noqa: PLC0415  there, or nothing would have been written

    parts = Parts(folder, study)
    tables = [parts.read(part, traces) for part in parts.numbers if parts.is_complete(part)]
    if not tables:
        raise StudyError(f"{folder}: no part of the sweep is complete yet; run it again")
    axes = tuple(one.name for one in study.dimensions)
    return Results(arrow.concat_tables(tables), axes, len(study))
