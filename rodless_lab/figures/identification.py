# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Pictures of an identification: what was measured, what the model says, and the residuals."""

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodless_lab.figures.style import label, panels
from rodless_lab.identification.bristles.fit import BristleFit
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit
from rodless_lab.identification.pressures.fit import PressureFit
from rodless_lab.runs.measured_run import MeasuredRun

Array = npt.NDArray[np.float64]

# Span in s over which the thick line of the residuals is averaged: a sensor's noise drops out.
SMOOTH = 0.02


def draw_pressures(run: MeasuredRun, fit: PressureFit) -> Figure:
    """Draw both pressures, measured and modelled, and measured less modelled."""
    figure, (pressure, residual) = panels(2, height=2.3, share_x=True)
    figure.suptitle(_headline(fit.verdict.fits))
    count = max(round(SMOOTH / run.period), 1)
    for side, colour in (("a", "tab:blue"), ("b", "tab:orange")):
        measured, modelled = (getattr(source, f"pressure_{side}") for source in (run, fit))
        name = side.upper()
        pressure.plot(run.time, measured * 1e-6, color=colour, linewidth=2.5, alpha=0.4, label=name)
        pressure.plot(run.time, modelled * 1e-6, "k--", linewidth=0.8, label=f"_{name}, model")
        apart = (measured - modelled) * 1e-3
        residual.plot(run.time, apart, color=colour, linewidth=0.4, alpha=0.4, label=f"_{name}")
        mean = moving_mean(apart, count)
        residual.plot(run.time, mean, color=colour, label=f"{name}, mean of {SMOOTH * 1e3:g} ms")
    pressure.plot([], [], "k--", linewidth=0.8, label="model")
    label(pressure, "", "pressure, absolute / MPa")
    label(residual, "time / s", "measured − model / kPa")
    return figure


def draw_bristles(run: MeasuredRun, fit: BristleFit) -> Figure:
    """Draw the position, measured and modelled, and measured less modelled."""
    figure, (position, residual) = panels(2, height=2.3, share_x=True)
    figure.suptitle(_headline(fit.verdict.fits))
    count = max(round(SMOOTH / run.period), 1)
    position.plot(run.time, run.position * 1e3, linewidth=2.5, alpha=0.4, label="measured")
    position.plot(run.time, fit.position * 1e3, "k--", linewidth=0.8, label="model")
    apart = (run.position - fit.position) * 1e6
    residual.plot(run.time, apart, linewidth=0.4, alpha=0.4, label="each")
    mean = moving_mean(apart, count)
    residual.plot(run.time, mean, color="tab:blue", label=f"mean of {SMOOTH * 1e3:g} ms")
    label(position, "", "position / mm")
    label(residual, "time / s", "measured − model / µm")
    return figure


def draw_friction(fit: FrictionFit) -> Figure:
    """Draw the points of both directions with the fitted curve, and their residuals."""
    figure, (curve, residual) = panels(2, height=2.3, share_x=True)
    figure.suptitle(_headline(fit.verdict.fits))
    for sign, direction, colour in ((1.0, "forward", "tab:blue"), (-1.0, "reverse", "tab:orange")):
        side: DirectionFit = getattr(fit, direction)
        speeds = sign * side.speeds * 1e3
        curve.plot(speeds, sign * side.forces, ".", color=colour, label=direction)
        _draw_curve(curve, side, sign)
        shown = side.residuals[: len(side.speeds)]
        residual.plot(speeds[: len(shown)], shown, ".", color=colour, label=direction)
    curve.plot([], [], "k", linewidth=1.0, label="fit")
    residual.axhline(0.0, color="k", linewidth=0.6, label="_zero")
    label(curve, "", "friction / N")
    label(residual, "speed / (mm/s)", "residual / standard errors")
    return figure


def _draw_curve(axes: Axes, side: DirectionFit, sign: float) -> None:
    """Draw the fitted curve where F_c and B were found."""
    if not len(side.speeds) or not np.isfinite([side.coulomb.value, side.viscous.value]).all():
        return
    speeds = np.linspace(0.0, float(side.speeds.max()), 500)
    forces = sign * side.form.force(side.curve, speeds)
    axes.plot(sign * speeds * 1e3, forces, "k", linewidth=1.0, label="_fit")


def moving_mean(values: Array, count: int) -> Array:
    """Return the mean of ``count`` values about each, near both ends of as many as there are."""
    window = np.ones(min(count, len(values)))
    there = np.convolve(np.ones(len(values)), window, mode="same")
    return np.asarray(np.convolve(values, window, mode="same") / there)


def _headline(fits: bool) -> str:
    return "the model fits" if fits else "the model does not fit"
