# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Pictures of what the paper leaves out: the step to 58 mm with each option and without."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rodless_base.atomic_write import atomic_write
from rodless_control import references
from rodless_lab.bare_rigs import bare_pid, bare_rig
from rodless_lab.figures.comparison import draw_comparison
from rodless_lab.figures.files import png
from rodless_lab.runs.measured_run import MeasuredRun, run_of_trace
from rodless_lab.simulation.closed_loop import closed_loop

DURATION = 1.5  # s
AT = 0.1  # s
TARGET = 0.058  # m
BASE = "saturating"


class Option(NamedTuple):
    """An option as its page shows it."""

    page: str  # docs/options/<page>.md, and the picture's name
    name: str  # in the picture
    values: Mapping[str, object]


# It begins at its highest pressure, and one step takes little of 24 L.
COMPRESSOR = {
    "supply.kind": "compressor",
    "supply.pressure": 0.7e6,
    "supply.receiver_volume": 1e-3,
}

OPTIONS = (
    Option("flow-law", "iso_6358", {"valve.flow_law": "iso_6358"}),
    Option("leak", "0.05 mm² across the piston", {"leak.across": 5e-8}),
    Option("tilt", "upright", {"rail.tilt": math.pi / 2.0}),
    Option(
        "thermodynamics",
        "isothermal",
        {"chambers.thermodynamics": "polytropic", "chambers.polytropic_index": 1.0},
    ),
    Option("spool", "115 Hz", {"valve.dynamics": "second_order"}),
    Option("hysteresis", "0.4 %", {"valve.hysteresis": 0.004}),
    Option("dead-time", "1 ms", {"valve.dead_time": 1e-3}),
    Option("tubes", "0.6 m of 4 mm", {"tubes.model": "delay"}),
    Option("ripple", "20 kPa, 10 Hz", {"supply.ripple_amplitude": 2e4}),
    Option("droop", "20 kPa for 100 L/min", {"supply.droop": 1.2e7}),
    Option("compressor", "0.6 to 0.7 MPa", COMPRESSOR),
    Option("discharge", "constant 0.9", {"valve.discharge": "constant"}),
    Option("lugre", "lugre", {"friction.dynamics": "lugre"}),
    Option("coupling", "magnetic", {"coupling.kind": "magnetic"}),
    Option("friction-drift", "0.3 a √s", {"friction.drift": 0.3}),
)


def step(values: Mapping[str, object]) -> MeasuredRun:
    """Run the step to 58 mm of the bare rig ``saturating`` with ``values``."""
    parameters = bare_rig(BASE).with_values(values)
    run = closed_loop(
        parameters, bare_pid(BASE), references.step(0.0, TARGET, at=AT), DURATION, 1e-3
    )
    return run_of_trace(run, parameters.number("supply.pressure"))


def save_option(folder: Path, option: Option) -> None:
    """Draw the step without and with ``option`` into ``folder``."""
    runs = step({}), step(option.values)
    time = np.arange(0.0, DURATION, 1e-3)
    names = BASE, option.name
    picture = png(lambda: draw_comparison(names, runs, time))
    atomic_write(folder / f"{option.page}.png", picture)
