# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Runs as files and data frames: the same bits come back, and so do the units."""

import builtins
import csv
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import pytest
from pyarrow import parquet

from rodless_base.columns import Array, Columns

UNITS = {"time": "s", "speed": "m/s", "count": "", "extra": "kg"}


@dataclass(frozen=True)
class Run(Columns):
    """Three columns, and something that is none."""

    time: Annotated[Array, "s"]
    speed: Annotated[Array, "m/s"]
    count: Annotated[Array, ""]
    name: str


@dataclass(frozen=True)
class LongerRun(Run):
    """A run that adds a column."""

    extra: Annotated[Array, "kg"]


@pytest.fixture
def run() -> LongerRun:
    """Numbers that no short decimal writes, and none at all."""
    values = np.random.default_rng(1).standard_normal((2, 1000)) * 1e-7
    values[0, 3] = np.nan
    values[1, :3] = 5e-324, 0.1 + 0.2, -1.7976931348623157e308
    return LongerRun(np.arange(1000) / 3.0, values[0], np.arange(1000), "a run", values[1])


def assert_same_bits(found: Array, expected: Array) -> None:
    assert np.asarray(found, dtype=expected.dtype).tobytes() == expected.tobytes()


def test_csv_gives_the_same_bits_back(run: LongerRun, tmp_path: Path) -> None:
    """Read as decimal numbers they are what was written, to the last bit.

    Pandas before 3.0 reads the last bit only when it is told to.
    """
    run.save(tmp_path / "run.csv")
    lines = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(lines[1:]))
    frame = pd.read_csv(tmp_path / "run.csv", comment="#")
    assert list(frame.columns) == list(rows[0]) == list(UNITS)
    for name in UNITS:
        assert_same_bits(np.array([float(row[name]) for row in rows]), run.columns()[name] * 1.0)
        np.testing.assert_allclose(frame[name], run.columns()[name], rtol=1e-15)


def test_csv_has_units_above_the_names(run: LongerRun, tmp_path: Path) -> None:
    """The two header lines stand in line, cell by cell, as a spreadsheet shows them."""
    run.save(str(tmp_path / "run.csv"))
    units, names = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()[:2]
    assert units == "# units: s,m/s,,kg"
    assert names == "time,speed,count,extra"


def test_parquet_gives_the_same_bits_and_units_back(run: LongerRun, tmp_path: Path) -> None:
    """Types are kept, and each field's metadata has its unit."""
    run.save(tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet")
    assert {field.name: field.metadata[b"unit"].decode() for field in table.schema} == UNITS
    for name, values in run.columns().items():
        column = table[name].to_numpy()
        assert column.dtype == values.dtype
        assert_same_bits(column, values)


def test_data_frame_has_columns_and_units(run: LongerRun) -> None:
    """Columns in order, base class first; what is no array is left out."""
    frame = run.to_dataframe()
    assert list(frame.columns) == list(UNITS)
    assert frame.attrs["units"] == UNITS
    assert_same_bits(frame["extra"].to_numpy(), run.extra)


@pytest.mark.parametrize("name", ["run.xlsx", "run", "csv"])
def test_other_endings_are_refused(run: LongerRun, tmp_path: Path, name: str) -> None:
    """One line names the file and the two endings there are; nothing is written."""
    with pytest.raises(ValueError, match=rf"{name}: .*\.csv or \.parquet$"):
        run.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("missing", ["pandas", "pyarrow"])
def test_a_missing_package_is_named_with_the_way_to_get_it(
    run: LongerRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    """Without the extra, CSV still works; the rest says what to install."""
    genuine = builtins.__import__

    def without(name: str, *arguments: object) -> object:
        if name.partition(".")[0] == missing:
            raise ModuleNotFoundError(f"No module named {missing!r}", name=missing)
        return genuine(name, *arguments)

    for name in [name for name in sys.modules if name.partition(".")[0] == missing]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", without)
    run.save(tmp_path / "run.csv")
    said = rf"needs {missing}, .*: pip install 'rodless_sim\[data\]'$"
    with pytest.raises(ModuleNotFoundError, match=said):
        run.to_dataframe() if missing == "pandas" else run.save(tmp_path / "run.parquet")
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_a_file_that_cannot_be_finished_leaves_the_old_one(
    run: LongerRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that fills up: the file of an earlier run stays as it was."""
    (tmp_path / "run.csv").write_text("earlier\n")

    def full(_descriptor: int) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        run.save(tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text() == "earlier\n"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_symbolic_link_stays_and_its_target_is_written(run: LongerRun, tmp_path: Path) -> None:
    """Whoever reads the target sees the run; nothing unfinished is left beside either."""
    (tmp_path / "data").mkdir()
    target, link = tmp_path / "data" / "target.csv", tmp_path / "link.csv"
    target.write_text("old", encoding="utf-8")
    link.symlink_to(target)
    run.save(link)
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8").startswith("# units: ")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["data", "link.csv", "target.csv"]


@pytest.mark.parametrize("name", ["a\nb", "half \ud800.csv", "nul \0.csv", "half \ud800.parquet"])
def test_what_names_no_file_is_refused_in_one_line(
    run: LongerRun, tmp_path: Path, name: str
) -> None:
    """Another ending, half a character, a NUL; nothing is written."""
    with pytest.raises(
        ValueError, match=r"cannot be saved in this format|no file has this path"
    ) as one:
        run.save(f"{tmp_path}/{name}")
    assert "\n" not in str(one.value)
    assert list(tmp_path.iterdir()) == []
