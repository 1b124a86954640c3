# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the docs show of the code itself: pages and pictures, written from what the code gives."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from rodless_base.atomic_write import atomic_write
from rodless_lab.experiments.catalogue import EXPERIMENTS
from rodless_lab.experiments.experiment import Options
from rodless_lab.figures.animation import Film, write_animation
from rodless_lab.figures.step import save_step_picture
from rodless_lab.reports.faults import save_fault_picture
from rodless_lab.reports.heat import save_heat_picture
from rodless_lab.reports.options import OPTIONS, save_option
from rodless_lab.reports.page import write_page
from rodless_lab.reports.parameters import parameter_reference
from rodless_lab.reports.preset_step import AT, TARGET, preset_step
from rodless_sim import RigParameters


def write_docs(folder: Path, show: Callable[[str], None]) -> None:
    """Write everything into ``folder``; ``show`` hears the name of each experiment begun."""
    atomic_write(folder / "parameters.md", parameter_reference())
    save_preset_step(folder / "step_paper.png", "paper")
    save_fault_picture(folder / "supply_loss.png")
    save_animation(folder / "rig.gif")
    save_heat_picture(folder / "options" / "heat.png")
    for option in OPTIONS:
        save_option(folder / "options", option)
    for experiment in EXPERIMENTS.values():
        show(experiment.name)
        write_page(folder / "experiments", experiment, experiment.run(Options()))


def save_preset_step(path: Path, preset: str) -> None:
    """Draw the step of a preset."""
    run, _ = preset_step(preset)
    save_step_picture(
        path,
        f"0 to 58 mm at 0.52 MPa gauge, preset {preset}",
        position=(run.time, run.position),
        reference=(run.time, np.where(run.time < AT, 0.0, TARGET)),
        pressures={
            "chamber A": (run.time, run.pressure_a),
            "chamber B": (run.time, run.pressure_b),
        },
        voltage=(run.time, run.voltage),
    )


def save_animation(path: Path) -> None:
    """Draw the same step of the preset ``calibrated`` as a moving picture."""
    run, setpoint = preset_step("calibrated")
    film = Film(0.4, 1.2, 0.2, "0 to 58 mm, preset calibrated, a fifth of its speed")
    stroke = RigParameters().number("cylinder.stroke")
    write_animation(path, run, setpoint, stroke, film)
