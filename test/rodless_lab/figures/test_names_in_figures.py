# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Names that a user has given, of bags and laws, in pictures and their tables."""

import csv
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from rodless_lab.benchmark.laws.picture import side_by_side
from rodless_lab.figures.animation import Film, write_animation
from rodless_lab.figures.comparison import draw_comparison
from rodless_lab.figures.files import figure_contents, png
from rodless_lab.figures.style import literal, name_of, panels
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_lab.studies.pictures import _places

NAMES = ["run$^$1", "_one", "$1_$2", "__$", "a\\$b", "run 1"]

TIME = np.arange(20) * 1e-2
STILL = np.full(20, 3e5)
RUN = MeasuredRun(TIME, 0.1 * TIME, STILL, STILL, STILL, STILL / 6e4)


def texts(figure: Figure, panel: int) -> list[str]:
    """What the legend of a panel says, as it is drawn."""
    legend = figure.axes[panel].get_legend()
    assert legend is not None
    return [one.get_text() for one in legend.get_texts()]


@pytest.mark.parametrize("name", NAMES)
def test_two_runs_are_drawn_under_their_names(name: str) -> None:
    """No name is a formula, and both are in each legend; every letter can be drawn."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = draw_comparison((name, "two"), (RUN, RUN), TIME)
        assert png(lambda: figure).startswith(b"\x89PNG")
    shown = literal(name)
    assert texts(figure, 0) == texts(figure, 3) == [shown, "two"]
    assert len(texts(figure, 2)) == 4
    # matplotlib draws an escaped dollar as one.
    assert shown.replace("\\$", "$").replace("\u200b", "") == name


@pytest.mark.parametrize("name", NAMES[:2])
def test_a_film_has_its_bag_as_title(tmp_path: Path, name: str) -> None:
    """Whatever it is called."""
    file = tmp_path / "run.gif"
    assert write_animation(file, RUN, None, 0.2, Film(0.0, 0.05, title=name)) == 2
    assert file.read_bytes().startswith(b"GIF89a")


def test_laws_and_texts_of_a_study_are_drawn_under_their_names() -> None:
    """All laws are in the legend, by their modules; a text of an axis is no formula either."""
    laws = ["_mine:Law", "pid", "lab$1$_2:Law"]
    scores: Any = [
        SimpleNamespace(
            entry=SimpleNamespace(name=law),
            task=SimpleNamespace(name=f"task of {cycles}", cycles=cycles),
            quantiles=lambda *_: (0.5, 0.6, 0.7),
        )
        for law in laws
        for cycles in (0, 3)
    ]
    figure = side_by_side(scores)
    png(lambda: figure)
    shown = [name_of(one.get_text()) for one in figure.legends[0].get_texts()]
    assert shown == laws
    results: Any = {"time.scenario": np.array(laws)}
    assert _places(results, "time.scenario") == ([0.0, 1.0, 2.0], [literal(law) for law in laws])


def test_a_table_has_the_names_as_they_were_given(tmp_path: Path) -> None:
    """Of lines, also those that begin with an underscore, and of ticks."""
    figure, (panel,) = panels()
    for name in NAMES:
        panel.plot([0.0, 1.0], [1.0, 2.0], label=literal(name))
    panel.set_xticks(range(len(NAMES)), [literal(name) for name in NAMES])
    table = figure_contents(tmp_path, "names", lambda: figure)[tmp_path / "names.csv"].decode()
    comment, _heads, *rows = csv.reader(table.splitlines())
    assert list(dict.fromkeys(row[1] for row in rows)) == NAMES
    ticks = ", ".join(f"{place} = {name}" for place, name in enumerate(NAMES))
    assert ", ".join(one.strip() for one in comment) == f"# panel 1: x: {ticks}; y:"
