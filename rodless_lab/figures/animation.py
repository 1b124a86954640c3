# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A run as a moving picture: the rig above, its curves growing below.

The chambers are coloured by their pressures, in a scale that the colour-blind can read too; the
triangle below the tube is the set-point, and the spool stands as far to a side as its voltage.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from rodless_base.atomic_write import atomic_write
from rodless_base.constants import CLOSED_VOLTAGE, STANDARD_ATMOSPHERE
from rodless_lab.figures.style import STYLE, label, literal
from rodless_lab.runs.measured_run import MeasuredRun, Setpoint

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

SIZE = (7.0, 5.2)  # inches
DPI = 90
FRAMES_PER_SECOND = 20.0
# A GIF shows each frame for whole hundredths of a second; the last one stays for this long.
LAST_FRAME = 1.0  # s

ADAPTIVE = 1  # Pillow's number for colours chosen by the picture

COLOURS = mpl.colormaps["YlGnBu"]
SIDES = {"a": "tab:blue", "b": "tab:orange"}

# In mm, as the drawing is: half lengths along the rail, and heights.
CAP, PISTON, CARRIAGE = 14.0, 11.0, 26.0
TUBE_HEIGHT, CARRIAGE_HEIGHT = 22.0, 40.0
VALVE_HALF, VALVE_BOTTOM, VALVE_HEIGHT, SPOOL = 45.0, -58.0, 16.0, 5.0
PISTON_COLOUR, METAL, LIGHT_METAL = "#404040", "#707070", "#c8c8c8"


@dataclass(frozen=True)
class Film:
    """What to show of a run, and how fast."""

    start: float  # s, of plant time
    end: float  # s
    speed: float = 1.0  # plant seconds per second
    title: str = ""


def write_animation(
    path: Path, run: MeasuredRun, setpoint: Setpoint | None, stroke: float, film: Film
) -> int:
    """Write a GIF of ``run`` on a rig of ``stroke`` (m) to ``path``; return how many frames it has.

    Raises OSError where it cannot be written.
    """
    with mpl.rc_context(STYLE):
        times = frame_times(film)
        picture = MovingPicture(run, setpoint, stroke, film)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "run.gif"
            writer = _Writer(fps=round(FRAMES_PER_SECOND))
            with writer.saving(picture.figure, str(file), DPI):
                for time in times:
                    picture.draw(float(time))
                    writer.grab_frame()
                for _ in range(round(LAST_FRAME * FRAMES_PER_SECOND)):
                    writer.grab_frame()
            atomic_write(path, file.read_bytes())
    return len(times)


class _Writer(PillowWriter):
    """Keeps of each frame the 256 colours that the file has: of a minute 0.4 GB, and not 1.4."""

    def grab_frame(self, **options: Any) -> None:
        """Take the figure as it is now."""
        super().grab_frame(**options)
        # As Pillow does when it writes. A matplotlib that keeps its frames elsewhere keeps them.
        frames = getattr(self, "_frames", None)
        if frames:
            frames[-1] = frames[-1].convert("P", palette=ADAPTIVE)


def frame_times(film: Film) -> Array:
    """Return the plant time (s) of each frame."""
    count = round((film.end - film.start) / film.speed * FRAMES_PER_SECOND) + 1
    return film.start + np.arange(count, dtype=np.float64) * (film.speed / FRAMES_PER_SECOND)


def setpoints_of_samples(setpoint: Setpoint, run: MeasuredRun) -> Array:
    """Return the set-point in force (m) at each sample; before the first, where the run starts."""
    given = np.searchsorted(setpoint.time, run.time, "right") - 1
    known = np.append(setpoint.position, run.position[0])  # the place -1 is the last
    return known[given]


class MovingPicture:
    """The figure, and what of it moves."""

    def __init__(
        self, run: MeasuredRun, setpoint: Setpoint | None, stroke: float, film: Film
    ) -> None:
        """``stroke`` is in m."""
        self.run = run
        self.wanted = None if setpoint is None else setpoints_of_samples(setpoint, run)
        self.figure = Figure(figsize=SIZE, layout="constrained")
        FigureCanvasAgg(self.figure)
        self.figure.suptitle(literal(film.title))
        rig, *panels = self.figure.subplots(4, 1, height_ratios=(1.7, 1.0, 1.0, 1.0))
        self.rig = MovingRig(rig, 1e3 * stroke, float(run.supply_pressure.max()))
        within = (run.time >= film.start) & (run.time <= film.end)
        self.first = int(np.argmax(within))
        self.curves = list(self._curves(within, *panels))
        for panel in panels:
            panel.grid(alpha=0.3)
            panel.set_xlim(film.start, film.end)
        for panel in panels[:-1]:
            panel.tick_params(labelbottom=False)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # nothing shifts from frame to frame

    def _curves(
        self, within: Mask, position: Axes, pressure: Axes, voltage: Axes
    ) -> Iterator[tuple[Line2D, Array]]:
        """Draw each curve whole, for the scales; yield its line and its values at all samples."""
        run = self.run
        columns = [
            (position, run.position * 1e3, "tab:blue", "carriage"),
            *(
                (pressure, getattr(run, f"pressure_{s}") * 1e-6, c, s.upper())
                for s, c in SIDES.items()
            ),
            (voltage, run.voltage, "tab:red", None),
        ]
        if self.wanted is not None:
            columns.insert(0, (position, self.wanted * 1e3, "k", "set-point"))
        for axes, values, colour, name in columns:
            width = 0.8 if colour in ("k", "tab:red") else None
            shown = run.time[within], values[within]
            yield axes.plot(*shown, color=colour, label=name, linewidth=width)[0], values
        legend: dict[str, Any] = {"loc": "lower right", "ncols": 2}
        label(position, "", "position / mm", **legend)
        label(pressure, "", "pressure,\nabsolute / MPa", **legend)
        label(voltage, "plant time / s", "valve / V")
        for axes in (position, pressure, voltage):
            axes.set_ylim(axes.get_ylim())  # the scale of the whole curve stays

    def draw(self, time: float) -> None:
        """Show the rig at ``time`` (s) and the curves up to it."""
        last = int(np.searchsorted(self.run.time, time + 1e-9, "right")) - 1
        seen = slice(self.first, last + 1)
        for line, values in self.curves:
            line.set_data(self.run.time[seen], values[seen])
        now = {name: float(values[last]) for name, values in self.run.columns().items()}
        self.rig.draw(now, None if self.wanted is None else float(self.wanted[last]))


class MovingRig:
    """Cylinder, carriage and valve, in mm along the rail."""

    def __init__(self, axes: Axes, stroke: float, supply: float) -> None:
        """``stroke`` is in mm, ``supply`` in Pa."""
        self.stroke, self.supply = stroke, supply
        self.left, self.right = -PISTON, stroke + PISTON
        axes.set_xlim(self.left - 2.0 * CAP, self.right + 2.0 * CAP)
        axes.set_ylim(VALVE_BOTTOM - 8.0, CARRIAGE_HEIGHT)
        axes.set_axis_off()
        self.axes = axes
        self.hoses = [self._hose(end) for end in (self.left, self.right)]
        self.chambers = [self._box(0.0, 1.0, TUBE_HEIGHT, METAL) for _ in range(2)]
        for end in (self.left, self.right):
            place = end - CAP if end < 0.0 else end
            self._box(place, CAP, TUBE_HEIGHT + 8.0, LIGHT_METAL)
        self.piston = self._box(0.0, 2.0 * PISTON, TUBE_HEIGHT, PISTON_COLOUR)
        self.carriage = self._box(0.0, 2.0 * CARRIAGE, CARRIAGE_HEIGHT, METAL, alpha=0.45)
        (self.setpoint,) = axes.plot([], [], "k^", markersize=7)
        self.texts = [self._text(0.0, 0.0) for _ in range(2)]
        self._valve()

    def _box(self, x: float, width: float, height: float, colour: str, **more: Any) -> Rectangle:
        box = Rectangle((x, -0.5 * height), width, height, fc=colour, ec="k", lw=0.8, **more)
        self.axes.add_patch(box)
        return box

    def _text(self, x: float, y: float, **more: Any) -> Text:
        return self.axes.text(x, y, "", ha="center", va="center", fontsize=8.0, **more)

    def _hose(self, end: float) -> Line2D:
        """Draw the hose from the valve to a chamber's port."""
        side = -1.0 if end < 0.0 else 1.0
        port, outlet = end - side * 4.0, 0.5 * self.stroke + side * 0.6 * VALVE_HALF
        top = VALVE_BOTTOM + VALVE_HEIGHT
        bend = top + 9.0
        x, y = [port, port, outlet, outlet], [-0.5 * TUBE_HEIGHT, bend, bend, top]
        return self.axes.plot(x, y, color=METAL, linewidth=3.0, solid_joinstyle="round")[0]

    def _valve(self) -> None:
        """Draw the valve's sleeve, the spool in it, and room for words beside it."""
        middle, centre = 0.5 * self.stroke, VALVE_BOTTOM + 0.5 * VALVE_HEIGHT
        sleeve = Rectangle(
            (middle - VALVE_HALF, VALVE_BOTTOM), 2.0 * VALVE_HALF, VALVE_HEIGHT, fc="w", ec="k"
        )
        self.axes.add_patch(sleeve)
        self.axes.plot([middle, middle], [VALVE_BOTTOM, centre + 0.5 * VALVE_HEIGHT], "k:", lw=0.8)
        self.spool = Rectangle(
            (0.0, VALVE_BOTTOM + 3.0), 2.0 * SPOOL, VALVE_HEIGHT - 6.0, fc="tab:red", ec="k"
        )
        self.axes.add_patch(self.spool)
        gap = VALVE_HALF + 5.0
        self.axes.text(
            middle - gap, centre, "valve", ha="right", va="center", fontsize=8.0, color=METAL
        )
        self.voltage = self.axes.text(middle + gap, centre, "", va="center", fontsize=8.0)

    def draw(self, now: dict[str, float], setpoint: float | None) -> None:
        """Place what moves; ``now`` is a sample by field of MeasuredRun, ``setpoint`` in m."""
        x = 1e3 * now["position"]
        self.piston.set_x(x - PISTON)
        self.carriage.set_x(x - CARRIAGE)
        spans = ((self.left, x - PISTON), (x + PISTON, self.right))
        for side, chamber, span, text, hose in zip(
            SIDES, self.chambers, spans, self.texts, self.hoses, strict=True
        ):
            self._chamber(chamber, span, text, now[f"pressure_{side}"])
            text.set_text(side.upper() if span[1] - span[0] > 10.0 else "")
            hose.set_color(chamber.get_facecolor())
        if setpoint is not None:
            self.setpoint.set_data([1e3 * setpoint], [-0.5 * CARRIAGE_HEIGHT - 5.0])
        self._spool(now["voltage"])

    def _chamber(
        self, chamber: Rectangle, span: tuple[float, float], text: Text, pressure: float
    ) -> None:
        share = (pressure - STANDARD_ATMOSPHERE) / max(self.supply - STANDARD_ATMOSPHERE, 1.0)
        chamber.set_bounds(span[0], -0.5 * TUBE_HEIGHT, max(span[1] - span[0], 0.0), TUBE_HEIGHT)
        chamber.set_facecolor(COLOURS(0.1 + 0.75 * share))
        text.set_position((0.5 * (span[0] + span[1]), 0.0))
        text.set_color("w" if share > 0.5 else "k")

    def _spool(self, voltage: float) -> None:
        travel = VALVE_HALF - SPOOL - 2.0
        share = float(np.clip((voltage - CLOSED_VOLTAGE) / CLOSED_VOLTAGE, -1.0, 1.0))
        self.spool.set_x(0.5 * self.stroke - SPOOL + travel * share)
        self.voltage.set_text(f"{voltage:5.2f} V")
