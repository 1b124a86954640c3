# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Pictures of the friction experiment, after Figs. 13 to 16."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodless_lab.figures.style import label, panels
from rodless_lab.identification.friction.auxiliary_lines import AuxiliaryLines
from rodless_lab.identification.friction.curve import Stribeck, friction_force
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit
from rodless_lab.identification.friction.uniform_motion import uniform_parts
from rodless_sim import RigParameters, Trace

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Construction:
    """The auxiliary lines of one direction and the points, m/s and N (n,), they are drawn on."""

    direction: str
    speeds: Array
    forces: Array
    lines: AuxiliaryLines


def draw_runs(runs: Sequence[Trace], voltages: Sequence[float]) -> Figure:
    """Draw displacement and pressure difference of each run, uniform parts thick."""
    figure, axes = panels(2, len(runs))
    for column, (run, voltage) in enumerate(zip(runs, voltages, strict=True)):
        place, pressure = axes[column], axes[len(runs) + column]
        difference = (run.pressure_a - run.pressure_b) * 1e-6
        place.plot(run.time, run.position * 1e3, linewidth=1.0, label="_measured")
        pressure.plot(run.time, difference, linewidth=0.5, label="_measured")
        for part in uniform_parts(run.time, run.position).parts:
            chosen = slice(part.first, part.last)
            place.plot(
                run.time[chosen],
                run.position[chosen] * 1e3,
                "tab:orange",
                linewidth=4.0,
                label="_uniform part",
            )
        place.set_title(f"{voltage:g} V")
        label(place, "time / s", "displacement / mm")
        label(pressure, "time / s", "P_a − P_b / MPa")
    return figure


def draw_curves(fit: FrictionFit, truth: RigParameters) -> Figure:
    """Draw measured friction of both directions, the fit, and the rig's own curve."""
    figure, (slow, whole) = panels(2, height=2.8)
    for sign, direction in ((1.0, "forward"), (-1.0, "reverse")):
        side: DirectionFit = getattr(fit, direction)
        colour = "tab:blue" if sign > 0.0 else "tab:orange"
        fastest = float(side.speeds.max())
        speeds = np.linspace(0.0, fastest, 2000)
        true = Stribeck(
            *(
                truth.number(f"friction.{direction}.{name}")
                for name in ("static", "coulomb", "stribeck_velocity", "viscous")
            )
        )
        for axes in (slow, whole):
            axes.plot(
                sign * side.speeds * 1e3,
                sign * side.forces,
                ".",
                color=colour,
                alpha=0.6,
                label=f"uniform motion, {direction}",
            )
            fitted, table = (sign * friction_force(curve, speeds) for curve in (side.curve, true))
            signed = sign * speeds * 1e3
            axes.plot(signed, fitted, "k", linewidth=1.0, label=f"_fit of eq. (29), {direction}")
            axes.plot(signed, table, "r:", label=f"_Table 2, {direction}")
        draw_events(slow, side, sign)
    slow.plot([], [], "k", linewidth=1.0, label="fit of eq. (29)")
    slow.plot([], [], "r:", label="Table 2")
    slow.set_xlim(-6.0, 6.0)
    slow.set_ylim(-60.0, 60.0)
    label(slow, "speed / (mm/s)", "friction / N", loc="upper left", ncols=2)
    label(whole, "speed / (mm/s)", "friction / N", loc="upper left")
    return figure


def draw_events(axes: Axes, side: DirectionFit, sign: float) -> None:
    """Mark breakaway and stop forces on the force axis."""
    for forces, style, name in (
        (side.breakaways, "g^", "breakaways"),
        (side.stops, "mv", "stops"),
    ):
        if len(forces):
            # Both directions in one colour: one entry of the legend serves.
            shown = name if sign > 0.0 else f"_{name}, reverse"
            axes.plot(np.zeros(len(forces)), sign * forces, style, markersize=5, label=shown)


def draw_lines(sides: Sequence[Construction]) -> Figure:
    """Draw the auxiliary lines f_1 and f_2 on the points of each direction."""
    figure, axes = panels(1, len(sides), height=3.0)
    for panel, side in zip(axes, sides, strict=True):
        lines = side.lines
        panel.plot(side.speeds * 1e3, side.forces, "o", label="uniform motion, one part per run")
        speeds = np.array([0.0, 20e-3])
        name = f"f_2: F_c {lines.coulomb:.1f} N, B {lines.viscous * 1e-3:.2f} N·s/mm"
        panel.plot(speeds * 1e3, lines.coulomb + lines.viscous * speeds, "tab:red", label=name)
        panel.axhline(lines.coulomb, color="0.5", linestyle=":", label="F_c")
        if np.isfinite(lines.static):
            speed = lines.stribeck_velocity * 1e3
            panel.plot(
                [0.0, speed],
                [lines.static, lines.coulomb],
                "tab:green",
                label=f"f_1: F_s {lines.static:.1f} N, v_s {speed:.1f} mm/s",
            )
        panel.set_title(f"{side.direction} (magnitudes)")
        panel.set_xlim(-0.3, 15.0)
        panel.set_ylim(0.0, 110.0)
        label(panel, "speed / (mm/s)", "friction / N", loc="upper left")
    return figure
