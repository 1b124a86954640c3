# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A part of a sweep: a Parquet file of some of its rows, how it is written and how it is read."""

from pathlib import Path
from typing import Any

from rodless_base.columns import quantities
from rodless_base.extras import missing_extra
from rodless_base.regular_file import NotAFileError, read_file
from rodless_lab.simulation.design import is_whole
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.seal import UNSEALED, Seal
from rodless_lab.studies.study import Study

# What the columns of traces begin with.
TRACE = "trace."


def parquet_modules() -> Any:
    """Return pyarrow and what it writes with; raises ModuleNotFoundError that names the extra."""
    try:
        import pyarrow as arrow  # noqa: PLC0415  an extra
        from pyarrow import parquet  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise missing_extra("a sweep", error.name, "data") from error
    return arrow, parquet


def part_bytes(study: Study, rows: list[dict[str, Any]], seal: Seal) -> bytes:
    """Return a Parquet file of rows as the journal has them: the same bytes for the same rows.

    Columns are the row's number and seed, each axis of the study, the figures, the failure, and a
    list for each column of the traces. Units stand in the metadata of the fields, the ``seal`` in
    that of the file.
    """
    arrow, parquet = parquet_modules()
    units = {quantity.name: quantity.unit for quantity in quantities(RunMetrics)}
    units |= {axis.name: study.unit(axis) for axis in study.dimensions}
    numbers = [row["row"] for row in rows]
    levels = [study.row(number) for number in numbers]
    columns: dict[str, Any] = {
        "row": arrow.array(numbers, arrow.int64()),
        "seed": arrow.array([int(one.base.rig.number("sensors.seed")) for one in levels]),
    }
    for place, axis in enumerate(study.dimensions):
        values = [one.levels[axis.name] for one in levels]
        # One type for all parts, of which some may have whole numbers alone.
        columns[axis.name] = arrow.array(
            map(_as_floats, values) if place in study.with_fractions else values
        )
    for place, name in enumerate(RunMetrics._fields):
        # There are NaN of two signs; JSON has made them one.
        values = [row["metrics"][place] for row in rows]
        columns[name] = arrow.array(values, arrow.float64())
    columns["failure"] = arrow.array([row["failure"] for row in rows], arrow.string())
    for name in study.trace_columns:
        values = [row["traces"].get(name, []) for row in rows]
        columns[TRACE + name] = arrow.array(values, arrow.list_(arrow.float64()))
    schema = arrow.schema(
        [
            arrow.field(name, array.type, metadata={"unit": units.get(name, "")})
            for name, array in columns.items()
        ],
        metadata={"rodless_sim": UNSEALED},
    )
    sink = arrow.BufferOutputStream()
    parquet.write_table(arrow.Table.from_arrays(list(columns.values()), schema=schema), sink)
    return seal.sealed(bytes(sink.getvalue()))


def _as_floats(level: object) -> object:
    """Return a number as a float, of several each."""
    if isinstance(level, tuple):
        return tuple(map(_as_floats, level))
    return float(level) if is_whole(level) else level


def checked_part(file: Path, seal: Seal) -> bytes:
    """Return what a part holds.

    Raises StudyError where that is not what was written there, OSError where it cannot be read.
    """
    try:
        content = read_file(file)
    except (NotAFileError, FileNotFoundError) as error:  # a link may lead nowhere
        raise _damaged(file, str(error.strerror)) from error
    if not seal.holds(content):
        raise _damaged(file, "not as this sweep wrote it")
    return content


def read_part(file: Path, seal: Seal, traces: bool) -> Any:
    """Return the table of a part, with its ``traces`` or without; raises as checked_part."""
    arrow, parquet = parquet_modules()
    content = parquet.ParquetFile(arrow.BufferReader(checked_part(file, seal)))
    names = content.schema_arrow.names
    return content.read([name for name in names if traces or not name.startswith(TRACE)])


def _damaged(file: Path, why: str) -> StudyError:
    return StudyError(f"{file}: damaged, {why}; remove it, and the sweep's next run makes it anew")
