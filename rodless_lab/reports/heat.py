# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The picture of docs/options/heat.md: what chambers with temperatures of their own change."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rodless_base.atomic_write import atomic_write
from rodless_base.constants import CLOSED_VOLTAGE
from rodless_control import references
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig
from rodless_lab.figures.files import png
from rodless_lab.figures.style import PRESET_COLOURS, label, panels
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters, Trace, simulate
from rodless_sim.physics.heat import ENERGY_BALANCE

ON = {"chambers.thermodynamics": ENERGY_BALANCE}
PERIOD = 1e-3  # s
VENTING_VOLTAGE = 4.4
SETTLED, VENTED = 0.2, 2.0  # s


def held(values: Mapping[str, object]) -> Trace:
    """Return the carriage held at mid-stroke: closed, then A vented and B filled."""
    rig = RigParameters({"cylinder.locked": True, "cylinder.initial_position": 0.1, **values})
    lengths = [round(time / PERIOD) for time in (SETTLED, VENTED)]
    return simulate(rig, np.repeat([CLOSED_VOLTAGE, VENTING_VOLTAGE], lengths), PERIOD)


def step(name: str, values: Mapping[str, object]) -> Trace:
    """Return the step of section 6.2, 0 to 58 mm, of a bare rig."""
    rig = bare_rig(name).with_values(values)
    reference = references.step(0.0, 0.058, at=SETTLED)
    return closed_loop(rig, bare_pid(name), reference, SETTLED + VENTED, PERIOD)


def save_heat_picture(path: Path) -> None:
    """Draw held chambers with and without temperatures, and what they change of the step."""
    off, on = held({}), held(ON)
    apart = {name: (step(name, ON).position - step(name, {}).position) * 1e3 for name in BARE_RIGS}

    def draw() -> Figure:
        figure, (pressure, temperature, change) = panels(3, height=1.9, share_x=True)
        figure.suptitle("Chambers with temperatures of their own")
        for side, colour in (("a", "tab:blue"), ("b", "tab:orange")):
            for run, style, name in ((on, "-", "on"), (off, "--", "off")):
                values = getattr(run, f"pressure_{side}") * 1e-6
                pressure.plot(
                    run.time, values, style, color=colour, label=f"{side.upper()}, {name}"
                )
            warmth = getattr(on, f"temperature_{side}")
            temperature.plot(on.time, warmth, color=colour, label=f"{side.upper()}, on")
        for (name, millimetres), colour in zip(apart.items(), PRESET_COLOURS.values(), strict=True):
            time = np.arange(len(millimetres)) * PERIOD
            change.plot(time, millimetres, color=colour, label=name)
        label(pressure, "", "held: pressure / MPa")
        label(temperature, "", "held: temperature / K")
        label(change, "plant time / s", "step, on − off: position / mm")
        return figure

    atomic_write(path, png(draw))
