# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The work–precision picture: processor time against error, a line for each solver."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodless_lab.benchmark.side_by_side import OTHERS, PROMISED, SideBySide
from rodless_lab.benchmark.solvers.ours import COMPILED, IN_C
from rodless_lab.benchmark.work import DURATION, Work
from rodless_lab.figures.style import panels

MARKERS = "os^vDPX"


def work_precision(found: SideBySide) -> Figure:
    """Draw the closed loops, a panel each."""
    closed = [work for work in found.work if work.is_closed]
    figure, axes = panels(2, 2, height=2.2)
    for panel, work in zip(axes, closed, strict=True):
        _panel(panel, found, work)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2)
    return figure


def _panel(axes: Axes, found: SideBySide, work: Work) -> None:
    for place, solver in enumerate((COMPILED, IN_C, *OTHERS)):
        rungs = found.of(solver, work)
        if rungs:
            axes.loglog(
                [one.errors.position * 1e6 for one in rungs],
                [one.seconds / DURATION * 1e3 for one in rungs],
                marker=MARKERS[place],
                markersize=4,
                label=solver.name.replace("`", ""),
            )
    axes.axvline(PROMISED.position * 1e6, color="0.6", linestyle=":")
    axes.set_title(work.name)
    axes.set_xlabel("position error / µm")
    axes.set_ylabel("processor time / (ms/s)")
