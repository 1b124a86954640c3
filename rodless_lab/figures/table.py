# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a figure shows, as numbers."""

import csv
import io
import re
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PolyCollection
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter

from rodless_lab.figures.style import name_of

Array = npt.NDArray[np.float64]


def table_of(figure: Figure) -> str:
    """Return the lines and bands of ``figure`` as CSV: panel, line, x, y, a row for each point.

    Panels are numbered row by row, from 1; a comment line for each names its axes, and what the
    numbers of an axis stand for where its ticks are names. A line that the legend leaves out is
    named by its label without the underscore, or ``line 1``, ``line 2``, …; a band is its outline;
    the ends of error bars are lines of their own, ``…, from`` and ``…, to``.
    """
    text = io.StringIO()
    for number, axes in enumerate(figure.axes, 1):
        beside = axes.get_shared_x_axes().get_siblings(axes)
        across = _axis_in_words(axes.xaxis, [one.xaxis for one in beside])
        beside = axes.get_shared_y_axes().get_siblings(axes)
        up = _axis_in_words(axes.yaxis, [one.yaxis for one in beside])
        title = f"; {_in_a_line(axes.get_title())}" if axes.get_title() else ""
        text.write(f"# panel {number}: x: {across}; y: {up}{title}\n")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("panel", "line", "x", "y"))
    for number, axes in enumerate(figure.axes, 1):
        for name, points in _drawn(axes):
            rows.writerows((number, name, *point) for point in points.tolist())
    return text.getvalue()


def _axis_in_words(axis: Axis, shared: Sequence[Axis]) -> str:
    """Return the label of an axis, or of one it is shared with, and the names at its ticks."""
    labels = (one.get_label_text() for one in (axis, *shared))
    found = _in_a_line(next(filter(None, labels), ""))
    names = _names_of_ticks(axis)
    return f"{found} ({names})" if found and names else found or names


def _names_of_ticks(axis: Axis) -> str:
    """Return which numbers stand for which names, empty where the ticks are numbers."""
    named = axis.get_major_formatter()
    fixed = isinstance(axis.get_major_locator(), FixedLocator)
    if not fixed or not isinstance(named, FuncFormatter):
        return ""
    places = np.asarray(axis.get_majorticklocs()).tolist()
    pairs = zip(places, named.format_ticks(places), strict=True)
    return ", ".join(f"{place:g} = {_in_a_line(name)}" for place, name in pairs)


def _in_a_line(text: str) -> str:
    """Return a text that may be broken into lines, within the names of parameters after a dot."""
    return " ".join(re.sub(r"\.\n", ".", name_of(text)).split())


def _drawn(axes: Axes) -> Iterator[tuple[str, Array]]:
    """Names and points, shape (n, 2), of what is drawn; empty lines stand in the legend only."""
    bars = {one.lines[0]: one for one in axes.containers if isinstance(one, ErrorbarContainer)}
    caps = {cap for one in bars.values() for cap in one.lines[1]}
    lines = [line for line in axes.lines if line not in caps]
    for place, line in enumerate(lines, 1):
        name = _name(str(bars.get(line, line).get_label()), place)
        points = _points(axes, line)
        if len(points):
            yield name, points
        if line in bars:
            yield from _ends(name, bars[line])
    for band in axes.collections:
        if isinstance(band, PolyCollection):
            for path in band.get_paths():
                yield str(band.get_label()), np.asarray(path.vertices)


def _name(label: str, place: int) -> str:
    unnamed = label.startswith(("_child", "_container"))
    return f"line {place}" if unnamed else name_of(label.removeprefix("_"))


def _ends(name: str, bars: ErrorbarContainer) -> Iterator[tuple[str, Array]]:
    """Names and points, shape (n, 2), of where error bars begin and end."""
    across = [" x"] * bars.has_xerr + [""] * bars.has_yerr
    for along, drawn in zip(across, bars.lines[2], strict=True):
        ends = np.array([path.vertices for path in drawn.get_paths()], dtype=np.float64)
        for place, which in enumerate(("from", "to")):
            yield f"{name},{along} {which}", ends[:, place]


def _points(axes: Axes, line: Line2D) -> Array:
    """Points of a line in data units; one across the whole panel ends at the panel's limits."""
    points = np.array(line.get_xydata(), dtype=np.float64)
    in_data = line.get_transform().contains_branch_seperately(axes.transData)
    for column, limits in enumerate((axes.get_xlim(), axes.get_ylim())):
        if not in_data[column]:
            points[:, column] = limits[0] + points[:, column] * (limits[1] - limits[0])
    return points
