# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Comment lines of a figure's CSV: one for each panel, whatever its labels hold."""

import io

import pandas
from matplotlib.figure import Figure

from rodless_lab.figures.style import panels
from rodless_lab.figures.table import table_of


def broken_labels() -> Figure:
    """Labels in several lines; two panels that share an axis, one of them over texts."""
    figure, (upper, lower) = panels(2, share_x=True)
    upper.plot([0.0, 1.0], [1.0, 2.0], label="upper")
    lower.plot([0.0, 1.0], [3.0, 4.0], label="lower")
    upper.set_ylabel("settling\ntime\n/ s")
    upper.set_title("a title\nof two lines")
    lower.set_xlabel("controller.\nlaw")
    lower.set_xticks([0, 1], ["pid", "own_laws:\nMine"])
    return figure


def test_each_panel_has_one_line_that_names_its_axes() -> None:
    """Labels lose their line breaks; a panel without a label has that of the axis it shares."""
    comments = table_of(broken_labels()).splitlines()[:2]
    law = "controller.law (0 = pid, 1 = own_laws: Mine)"
    assert comments == [
        f"# panel 1: x: {law}; y: settling time / s; a title of two lines",
        f"# panel 2: x: {law}; y: ",
    ]


def test_pandas_reads_the_table_past_its_comments() -> None:
    """Four columns, of which all but the name are numbers."""
    found = pandas.read_csv(io.StringIO(table_of(broken_labels())), comment="#")
    assert found.to_dict("list") == {
        "panel": [1, 1, 2, 2],
        "line": ["upper", "upper", "lower", "lower"],
        "x": [0.0, 1.0, 0.0, 1.0],
        "y": [1.0, 2.0, 3.0, 4.0],
    }


def test_ticks_that_are_numbers_are_not_listed() -> None:
    """Places chosen by hand have no names."""
    figure, (panel,) = panels()
    panel.plot([0.0, 1.0], [1.0, 2.0])
    panel.set_xticks([0.0, 0.5])
    panel.set_xlabel("time / s")
    assert table_of(figure).splitlines()[0] == "# panel 1: x: time / s; y: "


def test_error_bars_without_a_name_are_told_from_lines() -> None:
    """Points, bars across and bars up of one unnamed series are five lines of the table."""
    figure, (panel,) = panels()
    panel.errorbar([1.0, 2.0], [3.0, 4.0], yerr=0.5, xerr=0.25, fmt="o", capsize=2.0)
    found = pandas.read_csv(io.StringIO(table_of(figure)), comment="#")
    assert found.groupby("line")[["x", "y"]].first().T.to_dict("list") == {
        "line 1": [1.0, 3.0],
        "line 1, x from": [0.75, 3.0],
        "line 1, x to": [1.25, 3.0],
        "line 1, from": [1.0, 2.5],
        "line 1, to": [1.0, 3.5],
    }
