"""`rodless docs`: write what the docs show of the code itself."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rodless_base.start import Stop
from rodless_control import PidParameters, references
from rodless_lab.experiments.catalogue import EXPERIMENTS, Options
from rodless_lab.figures.step import save_step_picture
from rodless_lab.reports.page import write_page
from rodless_lab.reports.parameters import parameter_reference
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.settled import settled_pressures


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Write the pages into a folder."""
    parser = argparse.ArgumentParser(prog="rodless docs", description=__doc__)
    parser.add_argument("folder", type=Path, help="where the docs are")
    folder = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "parameters.md").write_text(parameter_reference(), encoding="utf-8")
    save_blocked_piston_picture(folder / "blocked_piston_force.png")
    for preset in ("paper", "calibrated"):
        save_preset_step(folder / f"step_{preset}.png", preset)
    for experiment in EXPERIMENTS.values():
        print(experiment.name, flush=True)
        write_page(folder / "experiments", experiment, experiment.run(Options()))
    return 0


def blocked_piston_force(assembly: str, voltages: Sequence[float]) -> list[float]:
    """Force in N on a held piston once its chambers have settled, at 0.5 MPa gauge supply."""
    parameters = RigParameters({"valve.assembly": assembly, "supply.pressure": 0.5e6 + 101325.0})
    plant = Plant.of(parameters)
    pressures = (settled_pressures(plant, voltage) for voltage in voltages)
    return [plant.cylinder.piston_area * (a - b) for a, b in pressures]


def save_blocked_piston_picture(path: Path) -> None:
    """Draw the settled force on a held piston against voltage, for both assemblies."""
    figure = Figure(figsize=(8.0, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    voltages = np.concatenate(
        [np.linspace(4.0, 5.08, 300, endpoint=False), np.linspace(5.08, 6.2, 300)]
    )
    for assembly in ("printed", "reconciled"):
        axes.plot(voltages, blocked_piston_force(assembly, voltages.tolist()), label=assembly)
    axes.axvline(5.08, color="k", linestyle=":", linewidth=1.0, label="closed position, 5.08 V")
    axes.set_xlabel("valve voltage / V")
    axes.set_ylabel("settled force on a held piston / N")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


def save_preset_step(path: Path, preset: str) -> None:
    """Draw the step of section 6.2, 0 to 58 mm at 0.52 MPa gauge, in process."""
    run = closed_loop(
        RigParameters.preset(preset),
        PidParameters.preset(preset),
        references.step(0.0, 0.058, at=0.5),
        duration=5.0,
        period=1e-3,
    )
    save_step_picture(
        path,
        f"0 to 58 mm at 0.52 MPa gauge, preset {preset}",
        position=(run.time, run.position),
        reference=(run.time, run.reference),
        pressures={
            "chamber A": (run.time, run.pressure_a),
            "chamber B": (run.time, run.pressure_b),
        },
        voltage=(run.time, run.voltage),
    )
