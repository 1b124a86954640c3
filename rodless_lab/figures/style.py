# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Figures in one style: as wide as the text of a thesis, in its size of letters."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Width in inches: 16 cm.
WIDTH = 6.3

# What matplotlib does otherwise: letters of 9 pt, embedded in PDF as TrueType, which journals take.
STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "figure.titlesize": 9.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "pdf.fonttype": 42,
}

# One colour per preset and chamber in every picture.
PRESET_COLOURS = {"paper": "tab:blue", "calibrated": "tab:orange"}


# Before a name that begins with an underscore, which the legend would leave out.
_NO_WIDTH = "\u200b"


def literal(name: str) -> str:
    """Return a name of the user's as matplotlib shows it to the letter: never as a formula.

    A line of that label is in the legend, too. :func:`name_of` returns the name again.
    """
    escaped = name.replace("$", "\\$")
    return _NO_WIDTH + escaped if escaped.startswith("_") else escaped


def name_of(text: str) -> str:
    """Return the name that :func:`literal` has given ``text`` for."""
    return text.removeprefix(_NO_WIDTH).replace("\\$", "$")


def panels(
    rows: int = 1, columns: int = 1, height: float = 2.4, share_x: bool = False
) -> tuple[Figure, list[Axes]]:
    """Return a figure of ``rows`` x ``columns`` panels, each ``height`` inches, row by row."""
    figure = Figure(figsize=(WIDTH, 0.4 + rows * height), layout="constrained")
    FigureCanvasAgg(figure)
    axes: list[Axes] = list(np.ravel(figure.subplots(rows, columns, sharex=share_x)))
    for panel in axes:
        panel.grid(alpha=0.3)
    return figure, axes


def label(axes: Axes, x: str, y: str, **legend: Any) -> None:
    """Name both axes, units after a slash, and show the legend where lines have names.

    ``legend`` goes to :meth:`matplotlib.axes.Axes.legend`.
    """
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**legend)
