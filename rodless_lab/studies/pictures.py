# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Pictures of a sweep: figures over each axis, and sensitivities."""

import re

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from rodless_lab.figures.style import WIDTH, literal, panels
from rodless_lab.studies.results import Results
from rodless_lab.studies.sensitivity import Indices
from rodless_lab.studies.study import FACTOR
from rodless_lab.studies.summary import in_words, shown, sizes

# What is drawn, where it varies; the data set has all.
FIGURES = ("settling_time", "mean_error", "overshoot", "limit_cycle", "rms_error", "valve_travel")
# More axes than these make panels too narrow to read.
MOST_AXES = 4
# How far beyond the indices a panel shows their intervals, and how much is left free.
FARTHEST, MARGIN = 2.0, 0.1


def draw_rows(results: Results) -> Figure:
    """Draw figures over each axis, a dot for each row."""
    names = [name for name in FIGURES if _varies(sizes(results, name))] or [FIGURES[0]]
    axes = results.axes[:MOST_AXES] or ("row",)
    figure, found = panels(len(names), len(axes), height=1.2)
    for number, panel in enumerate(found):
        row, column = divmod(number, len(axes))
        name, axis = names[row], axes[column]
        places, ticks = _places(results, axis)
        panel.plot(places, sizes(results, name).tolist(), ".", markersize=2.5, label=f"_{name}")
        panel.locator_params(axis="both" if ticks is None else "y", nbins=3)
        panel.ticklabel_format(axis="y", useOffset=False)
        # Rows without a figure would leave its panel with an axis of its own, and no numbers.
        panel.sharex(found[column])
        panel.sharey(found[row * len(axes)])
        panel.tick_params(labelleft=column == 0, labelbottom=row == len(names) - 1)
        if column == 0:
            panel.set_ylabel(f"{_stacked(name)}\n/ {shown(name).unit}")
        if row == len(names) - 1:
            panel.set_xlabel(axis.replace(".", ".\n") + _in_unit(results.unit(axis)))
            if ticks is None:
                panel.ticklabel_format(axis="x", style="sci", scilimits=(-3, 4))
            else:
                panel.set_xticks(range(len(ticks)), ticks)
    return figure


def _places(results: Results, axis: str) -> tuple[list[float], list[str] | None]:
    """Return where each row stands on an axis, and what its ticks say where it has no numbers."""
    values = results[axis]
    if values.dtype.kind in "iuf":
        return values.tolist(), None
    texts = [str(value) for value in values]
    ticks = list(dict.fromkeys(texts))
    return [float(ticks.index(text)) for text in texts], [literal(text) for text in ticks]


def _stacked(name: str) -> str:
    """Return the words of a figure in lines, short enough for a narrow panel."""
    return re.sub("(?<!,) ", "\n", in_words(name))


def _in_unit(unit: str) -> str:
    return {"": "", FACTOR: "\ntimes its base"}.get(unit, f"\n/ {unit}")


def _varies(values: npt.NDArray[np.float64]) -> bool:
    there = values[~np.isnan(values)]
    return bool(there.size and np.ptp(there) > 0.0)


def draw_sensitivities(axes: tuple[str, ...], found: dict[str, Indices]) -> Figure:
    """Draw first and total indices of each figure, with 95 % intervals."""
    figure, drawn = panels(len(found), 1, height=1.1, share_x=True)
    places = np.arange(len(axes))
    for panel, (name, indices) in zip(drawn, found.items(), strict=True):
        for shift, label, values, interval in (
            (-0.12, "by itself", indices.first, indices.first_interval),
            (0.12, "in all", indices.total, indices.total_interval),
        ):
            panel.errorbar(places + shift, values, interval, fmt="o", markersize=3, label=label)
        panel.set_ylabel(_stacked(name))
        panel.set_ylim(*limits(indices))
    drawn[0].set_title("share of the variance, with 95 % intervals")
    figure.legend(*drawn[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    drawn[-1].set_xticks(places, axes, rotation=20, ha="right")
    figure.set_figwidth(WIDTH)
    return figure


def limits(indices: Indices) -> tuple[float, float]:
    """Return the ends of a panel: all indices are within, and intervals as far as ``FARTHEST``.

    An interval that is much wider than the indices would press them into one line.
    """
    both = np.concatenate([indices.first, indices.total])
    around = np.concatenate([indices.first_interval, indices.total_interval])
    points = both[np.isfinite(both)]
    least, most = min(0.0, points.min(initial=0.0)), max(1.0, points.max(initial=1.0))
    ends = np.concatenate([both - around, both + around])
    ends = np.clip(ends[np.isfinite(ends)], least - FARTHEST, most + FARTHEST)
    return min(least, ends.min(initial=0.0)) - MARGIN, max(most, ends.max(initial=1.0)) + MARGIN
