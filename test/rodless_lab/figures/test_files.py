# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Figures as files: print size, embedded fonts, the same bytes each time, and the data behind."""

import csv
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from rodless_base.atomic_write import write_together
from rodless_lab.figures.files import figure_contents, png
from rodless_lab.figures.style import label, panels
from rodless_lab.figures.table import table_of

TIME = np.linspace(0.0, 1.0, 11)


def draw() -> Figure:
    """Two panels with every kind of line that the experiments draw."""
    figure, (first, second) = panels(2)
    first.plot(TIME, TIME**2 / 3.0, label="position, true")
    first.plot(TIME, TIME, "k:", label="_hidden from the legend")
    first.plot([], [], "k", label="legend only")
    first.axhline(0.25, label="limit")
    first.axvline(0.5)
    first.set_xlim(-1.0, 2.0)
    first.set_ylim(0.0, 4.0)
    first.set_title("title")
    second.fill_between(TIME[:2], [0.0, 1.0], [2.0, 3.0], label="band")
    label(first, "time / s", "position / mm")
    label(second, "time / s", "error / mm")
    return figure


@pytest.fixture
def rows() -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Points by panel and line, as a reader that is not ours finds them."""
    lines = [line for line in table_of(draw()).splitlines() if not line.startswith("#")]
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in csv.DictReader(lines):
        point = (float(row["x"]), float(row["y"]))
        found.setdefault((row["panel"], row["line"]), []).append(point)
    return found


def test_lines_come_back_to_the_last_bit(rows) -> None:
    """What was plotted is in the table, by the name in the legend, commas and all."""
    for name, values in (("position, true", TIME**2 / 3.0), ("hidden from the legend", TIME)):
        np.testing.assert_array_equal(rows["1", name], np.stack([TIME, values], axis=1))
    assert ("1", "legend only") not in rows


def test_lines_across_a_panel_end_at_its_limits(rows) -> None:
    """Axhline and axvline are drawn in shares of the panel; the table has them in its units."""
    assert rows["1", "limit"] == [(-1.0, 0.25), (2.0, 0.25)]
    assert rows["1", "line 5"] == [(0.5, 0.0), (0.5, 4.0)]


def test_a_band_is_its_outline(rows) -> None:
    """The four corners of a band are among its points."""
    corners = {(0.0, 0.0), (TIME[1], 1.0), (TIME[1], 3.0), (0.0, 2.0)}
    assert corners <= set(rows["2", "band"])


def test_axes_are_named_in_comments() -> None:
    """One line for each panel, with its labels and its title."""
    comments = [line for line in table_of(draw()).splitlines() if line.startswith("#")]
    assert comments == [
        "# panel 1: x: time / s; y: position / mm; title",
        "# panel 2: x: time / s; y: error / mm",
    ]


def test_files_are_for_print(tmp_path: Path) -> None:
    """16 cm wide at 300 dpi; the PDF holds its fonts as TrueType and lines as lines."""
    write_together(figure_contents(tmp_path, "name", draw))
    assert {file.name for file in tmp_path.iterdir()} == {"name.png", "name.pdf", "name.csv"}
    width = imread(tmp_path / "name.png").shape[1]
    assert width == pytest.approx(16.0 / 2.54 * 300, abs=3)
    pdf = (tmp_path / "name.pdf").read_bytes()
    assert b"/FontFile2" in pdf
    assert b"/Type3" not in pdf
    assert b"/Subtype /Image" not in pdf
    (box,) = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ", pdf)
    assert float(box) / 72.0 * 2.54 == pytest.approx(16.0, abs=0.01)


def test_the_same_figure_gives_the_same_bytes(tmp_path: Path) -> None:
    """No date, no version, no random name."""
    for folder in ("first", "second"):
        write_together(figure_contents(tmp_path / folder, "name", draw))
    for kind in ("png", "pdf", "csv"):
        first, second = (tmp_path / folder / f"name.{kind}" for folder in ("first", "second"))
        assert first.read_bytes() == second.read_bytes()
    assert b"Date" not in (tmp_path / "first" / "name.pdf").read_bytes()


def test_matplotlibs_own_settings_stay() -> None:
    """A user who draws beside keeps their own style."""
    before = dict(mpl.rcParams)
    assert png(draw).startswith(b"\x89PNG")
    assert dict(mpl.rcParams) == before
