"""A picture of one move: position, pressures and voltage against time."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Series = tuple[npt.ArrayLike, npt.ArrayLike]


def save_step_picture(
    path: Path,
    title: str,
    position: Series,
    reference: Series,
    pressures: dict[str, Series],
    voltage: Series,
) -> None:
    """Write a PNG to ``path``; every series is (time in s, values in SI)."""
    figure = Figure(figsize=(8.0, 7.5), layout="constrained")
    FigureCanvasAgg(figure)
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    figure.suptitle(title)
    top.plot(reference[0], np.asarray(reference[1]) * 1e3, "k--", linewidth=1.0, label="set-point")
    top.plot(position[0], np.asarray(position[1]) * 1e3, color="tab:blue", label="carriage")
    top.set_ylabel("position / mm")
    for label, (time, values) in pressures.items():
        middle.plot(time, np.asarray(values) * 1e-6, label=label)
    middle.set_ylabel("absolute pressure / MPa")
    bottom.plot(voltage[0], voltage[1], color="tab:red", linewidth=0.8, label="valve command")
    bottom.set_ylabel("voltage / V")
    bottom.set_xlabel("plant time / s")
    for axes in (top, middle, bottom):
        axes.grid(alpha=0.3)
        axes.legend(loc="best", frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
