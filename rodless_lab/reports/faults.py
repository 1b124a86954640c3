# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The picture of docs/faults.md: a controller while the supply fails."""

from pathlib import Path

from matplotlib.figure import Figure

from rodless_base.atomic_write import atomic_write
from rodless_base.constants import SECONDS_PER_NANOSECOND, STANDARD_ATMOSPHERE
from rodless_control import PidParameters, references
from rodless_lab.figures.files import png
from rodless_lab.figures.style import label, panels
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
from rodless_sim import RigParameters, Scenario
from rodless_sim.scenario import shipped_scenario

SCENARIO = "supply_loss"
DURATION = 4.0  # s
PERIOD = 1e-3  # s
CENTRE, AMPLITUDE, FREQUENCY = 0.1, 0.02, 0.5  # m, m, Hz


def run(scenario: Scenario | None) -> ClosedLoopTrace:
    """Return the preset ``calibrated`` following a sine."""
    reference = references.sine(CENTRE, AMPLITUDE, FREQUENCY)
    rig, law = RigParameters.preset("calibrated"), PidParameters.preset("calibrated")
    return closed_loop(rig, law, reference, DURATION, PERIOD, CENTRE, scenario)


def save_fault_picture(path: Path) -> None:
    """Draw position and pressures with the scenario and without."""
    scenario = Scenario.from_file(shipped_scenario(SCENARIO))
    sound, faulty = run(None), run(scenario)

    def draw() -> Figure:
        figure, (position, pressure) = panels(2, height=1.9, share_x=True)
        figure.suptitle(f"scenario {SCENARIO}")
        position.plot(sound.time, sound.reference * 1e3, "k--", linewidth=0.8, label="reference")
        position.plot(sound.time, sound.position * 1e3, color="tab:grey", label="without")
        position.plot(faulty.time, faulty.position * 1e3, color="tab:blue", label="with faults")
        for side, colour in (("a", "tab:blue"), ("b", "tab:orange")):
            gauge = (getattr(faulty, f"pressure_{side}") - STANDARD_ATMOSPHERE) * 1e-6
            pressure.plot(faulty.time, gauge, color=colour, label=f"chamber {side.upper()}")
        for panel in (position, pressure):
            for entry in scenario.entries:
                panel.axvline(
                    entry.stamp * SECONDS_PER_NANOSECOND,
                    color="tab:red",
                    linewidth=0.8,
                    linestyle=":",
                )
        label(position, "", "position / mm", loc="lower left")
        label(pressure, "plant time / s", "pressure, gauge / MPa")
        return figure

    atomic_write(path, png(draw))
