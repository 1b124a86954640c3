"""A picture of two runs overlaid, and their difference in position."""

from io import BytesIO

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rodless_lab.runs.comparison import QUANTITIES
from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]


def comparison_picture(
    labels: tuple[str, str], runs: tuple[MeasuredRun, MeasuredRun], time: Array
) -> bytes:
    """Draw both runs on ``time`` (s, shape (n,)); returns a PNG."""
    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(4, 1, sharex=True)
    figure.suptitle(f"{labels[0]} and {labels[1]}")
    for run, label, style in zip(runs, labels, ("-", "--"), strict=True):
        panels[0].plot(run.time, run.position * 1e3, style, label=label)
        for side, colour in (("a", "tab:blue"), ("b", "tab:orange")):
            pressure = getattr(run, f"pressure_{side}") * 1e-6
            name = f"{side.upper()}, {label}"
            panels[2].plot(run.time, pressure, style, color=colour, label=name)
        panels[3].plot(run.time, run.voltage, style, linewidth=0.8, label=label)
    first, second = (np.interp(time, run.time, run.position) for run in runs)
    panels[1].plot(time, (second - first) * 1e3, color="tab:red", label="second minus first")
    for panel, name in zip(
        panels,
        (
            "position / mm",
            "difference / mm",
            "absolute pressure / MPa",
            f"{QUANTITIES['voltage'][0]} / V",
        ),
        strict=True,
    ):
        panel.set_ylabel(name)
        panel.grid(alpha=0.3)
        panel.legend(loc="best", frameon=False)
    panels[-1].set_xlabel("time / s")
    panels[-1].set_xlim(time[0], time[-1])
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()
