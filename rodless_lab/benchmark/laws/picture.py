# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The scores as a picture: of each law and task the median, and how far the worst rig is."""

import re
from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rodless_lab.benchmark.laws.contest import Score
from rodless_lab.figures.style import literal, panels

# Beyond these nothing is told apart any more.
LONGEST = 2.0  # s
LARGEST = 3.0  # mm

MARKERS = "os^vDPX*"
BEYOND = "$\\uparrow$"
LABEL_WIDTH = 13  # letters


def side_by_side(scores: Sequence[Score]) -> Figure:
    """Draw settling times of the moves and peak errors of the sines."""
    figure, (moves, sines) = panels(2, 1, height=3.0)
    _panel(moves, [one for one in scores if not one.task.cycles], "settling_time", 1.0, LONGEST)
    moves.set_ylabel("settling time to ± 0.2 mm / s")
    _panel(sines, [one for one in scores if one.task.cycles], "peak_error", 1e3, LARGEST)
    sines.set_ylabel("peak error / mm")
    handles, names = moves.get_legend_handles_labels()
    parts = {
        "median, by the law's sign": _sign("o"),
        "nine rigs in ten at most": _sign("_"),
        "up to the worst rig": _sign("|"),
        "the worst is beyond, or never settled": _sign(BEYOND),
    }
    figure.legend(handles, names, loc="outside lower left", ncols=2)
    figure.legend(list(parts.values()), list(parts), loc="outside lower right")
    return figure


def _panel(axes: Axes, scores: Sequence[Score], figure: str, scale: float, largest: float) -> None:
    tasks = list(dict.fromkeys(one.task.name for one in scores))
    laws = list(dict.fromkeys(one.entry.name for one in scores))
    for place, law in enumerate(laws):
        own = [one for one in scores if one.entry.name == law]
        found = np.array([one.quantiles(figure, scale) for one in own]).T
        middle, high, worst = np.minimum(found, largest)
        x = np.array([tasks.index(one.task.name) for one in own]) + 0.8 * (
            (place + 0.5) / len(laws) - 0.5
        )
        colour = f"C{place}"
        axes.vlines(x, middle, worst, colors=colour, linewidth=0.8)
        within = found[1] <= largest
        axes.plot(x[within], high[within], "_", color=colour, markersize=5)
        marker = MARKERS[place % len(MARKERS)]
        axes.plot(x, middle, marker, color=colour, markersize=4, label=literal(law))
        beyond = x[found[-1] > largest]
        level = np.full(len(beyond), 1.03 * largest)
        axes.plot(beyond, level, linestyle="none", marker=BEYOND, color=colour, markersize=5)
    axes.set_xticks(range(len(tasks)), [_in_lines(task) for task in tasks])
    axes.tick_params(axis="x", labelsize=6)
    axes.set_ylim(0.0, 1.06 * largest)


def _sign(marker: str) -> Line2D:
    return Line2D([], [], marker=marker, color="0.3", linestyle="none", markersize=5)


def _in_lines(task: str) -> str:
    """Break a name where it has commas, and no number from its unit."""
    kept = re.sub(r"(\d) ", "\\1\u00a0", task)
    return "\n".join(fill(part, LABEL_WIDTH) for part in kept.replace(", ", ",\n").splitlines())
