# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A picture of two runs overlaid, and their difference in position."""

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from rodless_lab.figures.style import label, literal, panels
from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# Of the pressures in A and B, of the first run and of the second.
COLOURS = (("tab:blue", "tab:orange"), ("tab:cyan", "tab:brown"))

# To look for the best place takes seconds on a long bag.
BESIDE = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "fontsize": "x-small"}


def draw_comparison(
    names: tuple[str, str], runs: tuple[MeasuredRun, MeasuredRun], time: Array
) -> Figure:
    """Draw both runs on ``time`` (s, shape (n,))."""
    figure, axes = panels(4, height=1.7, share_x=True)
    position, apart, pressure, voltage = axes
    figure.suptitle(literal(f"{names[0]} and {names[1]}"))
    # Bags of minutes have so many samples that dashes run together: colours tell the runs apart.
    for run, name, style, colours in zip(runs, names, ("-", "--"), COLOURS, strict=True):
        position.plot(run.time, run.position * 1e3, style, label=literal(name))
        for side, colour in zip("ab", colours, strict=True):
            values = getattr(run, f"pressure_{side}") * 1e-6
            chamber = literal(f"{side.upper()}, {name}")
            pressure.plot(run.time, values, style, color=colour, label=chamber)
        voltage.plot(run.time, run.voltage, style, linewidth=0.8, label=literal(name))
    first, second = (np.interp(time, run.time, run.position) for run in runs)
    apart.plot(time, (second - first) * 1e3, color="tab:red", label="second minus first")
    label(position, "", "position / mm", **BESIDE)
    label(apart, "", "difference / mm", **BESIDE)
    label(pressure, "", "pressure, absolute / MPa", **BESIDE)
    label(voltage, "time / s", "valve voltage / V", **BESIDE)
    voltage.set_xlim(time[0], time[-1])
    return figure
