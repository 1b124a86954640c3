# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Section 6.2, Fig. 19: a step of 58 mm under PID control."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from rodless_control import PidParameters, references
from rodless_lab.experiments.experiment import Experiment
from rodless_lab.experiments.result import Comparison, Limits, Picture
from rodless_lab.experiments.runner import IN_PROCESS, Runner
from rodless_lab.figures.style import PRESET_COLOURS, label, panels
from rodless_lab.runs.step_metrics import SETTLING_BAND, StepMetrics, step_metrics
from rodless_lab.simulation.closed_loop import ClosedLoopTrace
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant

TARGET = 0.058
STEP_TIME = 0.5
DURATION = 6.0
PERIOD = 1e-3

# Section 7 calls the two positions steady; the last second of the run is.
STEADY_TIME = 1.0

# 10-90 % rise and time to ±0.2 mm in s. Another program of the same equations, with other gains,
# gave 0.9 and 3.2 s (paper), 0.19 and 0.84 s (calibrated); the gains shipped must not be slower.
CALIBRATED_RISE = Limits(0.05, 0.25, "no slower than another program of these equations: 0.19 s")
SETTLING = {
    "paper": Limits(0.0, 3.5, "no slower than another program of these equations: 3.2 s"),
    "calibrated": Limits(0.0, 1.0, "no slower than another program of these equations: 0.84 s"),
}
STEADY = Limits(
    -SETTLING_BAND * 1e3,
    SETTLING_BAND * 1e3,
    "section 7 states less than 0.2 mm, of simulation against experiment",
)


@dataclass(frozen=True)
class StepResult:
    """One closed-loop run per preset (SI, see ``ClosedLoopTrace``) and its metrics."""

    runs: Mapping[str, ClosedLoopTrace]
    metrics: Mapping[str, StepMetrics]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Rise, settling, overshoot, final error; with both presets their difference."""
        rows = [row for preset in self.runs for row in self._rows(preset)]
        if len(self.runs) == 2:
            rows.append(self._difference())
        return tuple(rows)

    def _rows(self, preset: str) -> Iterator[Comparison]:
        found = self.metrics[preset]
        fig = "Fig. 19, no number in the text"
        rise = rise_limits() if preset == "paper" else CALIBRATED_RISE
        yield Comparison(f"{preset}: rise, 10 to 90 %", found.rise_time, "s", fig, rise)
        yield Comparison(
            f"{preset}: until within 0.2 mm", found.settling_time, "s", fig, SETTLING[preset]
        )
        yield Comparison(f"{preset}: overshoot", found.overshoot * 1e3, "mm", fig, decimals=3)
        yield Comparison(
            f"{preset}: error at the end",
            found.final_error * 1e3,
            "mm",
            "below 0.2 mm between simulation and experiment",
            STEADY,
            decimals=3,
        )

    def _difference(self) -> Comparison:
        first, second = (run.position[run.time > DURATION - STEADY_TIME] for run in self._pair())
        return Comparison(
            "largest steady difference between the presets",
            float(np.abs(first - second).max()) * 1e3,
            "mm",
            "below 0.2 mm between simulation and experiment",
            STEADY,
            decimals=3,
        )

    def _pair(self) -> Sequence[ClosedLoopTrace]:
        return list(self.runs.values())

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Position and error, as in Fig. 19 (a) and (b)."""
        return (
            Picture(
                "step", "Step of 58 mm at 0.52 MPa: position, error, error near rest", self.draw
            ),
        )

    def draw(self) -> Figure:
        """Draw position, error and the error near rest against time."""
        figure, (position, error, near) = panels(3, height=1.9)
        for preset, run in self.runs.items():
            colour = PRESET_COLOURS[preset]
            position.plot(run.time, run.position * 1e3, color=colour, label=preset)
            error.plot(run.time, run.error * 1e3, color=colour, label=preset)
            near.plot(run.time, run.error * 1e3, color=colour, label=preset)
        position.axhline(TARGET * 1e3, color="k", linestyle=":", linewidth=1.0, label="target")
        near.axhspan(-0.2, 0.2, color="0.9", label="±0.2 mm")
        near.set_ylim(-0.5, 0.5)
        label(position, "time / s", "position / mm", loc="center right")
        label(error, "time / s", "error / mm")
        label(near, "time / s", "error, enlarged / mm", ncols=3, loc="lower right")
        return figure

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the numbers rest on."""
        return (
            "The paper's 0.2 mm is the difference between its simulation and its rig, not a "
            "tracking error. Two rigs stand in for that pair here: `paper` with the friction of "
            "Table 2 at every speed, `calibrated` with friction that lets the cylinder move as "
            "fast as its maker says, each with the gains tuned for it.",
            "All numbers are of the positions that the sensors read, as on a rig: of `paper` the "
            "true ones, of `calibrated` with its sensor's noise and nonlinearity. Sweeps, searches "
            "and `rodless_lab.run_metrics` judge by the true position.",
            "With Table 2 the rise is the friction's doing, not the controller's: the carriage "
            f"cannot exceed {top_speed() * 1e3:.1f} mm/s at this supply.",
        )


def top_speed() -> float:
    """Speed in m/s at which Table 2's forward friction takes all the force of the supply."""
    plant = Plant.of(RigParameters.preset("paper"))
    force = plant.cylinder.piston_area * (plant.supply_pressure - plant.ambient_pressure)
    return (force - plant.friction.forward.coulomb) / plant.friction.forward.viscous


def rise_limits() -> Limits:
    """Bounds in s of the rise with Table 2's friction: 80 % of the step at its top speed."""
    fastest = 0.8 * TARGET / top_speed()
    return Limits(
        fastest,
        1.15 * fastest,
        "80 % of the way at the top speed Table 2 allows, at most 15 % more",
    )


def run_step(
    presets: Sequence[str] = ("paper", "calibrated"), runner: Runner = IN_PROCESS
) -> StepResult:
    """Step from 0 to 58 mm at 0.52 MPa gauge, at 0.5 s, with each preset's own gains."""
    reference = references.step(0.0, TARGET, at=STEP_TIME)
    runs = {
        preset: runner.closed_loop(
            RigParameters.preset(preset), PidParameters.preset(preset), reference, DURATION, PERIOD
        )
        for preset in presets
    }
    metrics = {
        preset: step_metrics(run.time, run.position, run.voltage, 0.0, TARGET, STEP_TIME)
        for preset, run in runs.items()
    }
    return StepResult(runs, metrics)


EXPERIMENT = Experiment(
    name="step",
    title="Step of 58 mm",
    source="section 6.2, Fig. 19",
    summary="At 0.52 MPa the PID controller moves the carriage from 0 to 58 mm.",
    run=lambda options: run_step(options.presets, options.runner),
    takes=("presets",),
    moves=True,
)
