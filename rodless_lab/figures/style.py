"""Figures in one style, and their bytes as PNG."""

import io
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# One colour per preset and chamber in every picture.
PRESET_COLOURS = {"paper": "tab:blue", "calibrated": "tab:orange"}


def panels(rows: int = 1, columns: int = 1, height: float = 3.0) -> tuple[Figure, list[Axes]]:
    """Return a figure of ``rows`` x ``columns`` panels, each ``height`` inches, row by row."""
    figure = Figure(figsize=(8.0, 0.6 + rows * height), layout="constrained")
    FigureCanvasAgg(figure)
    axes: list[Axes] = list(np.ravel(figure.subplots(rows, columns)))
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
        axes.legend(**{"frameon": False, "fontsize": 9, **legend})


def png(figure: Figure) -> bytes:
    """Return the picture as PNG; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=110, metadata={"Software": None})
    return buffer.getvalue()
