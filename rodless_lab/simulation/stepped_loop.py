# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rig and law step by step: for faults and scenarios, which the compiled loop does not know.

It does what the nodes do in lock-step, with the same objects: :class:`rodless_sim.Rig`, the law.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.measurement import Measurement
from rodless_control import ReferencePoint
from rodless_control.controller import Law, output_limits
from rodless_lab.simulation.asked_law import ask
from rodless_sim import Rig, RigParameters
from rodless_sim.faults import ValveFault, sensor_states
from rodless_sim.instruments.acquisition import Acquisition
from rodless_sim.physics.state import State
from rodless_sim.trace import columns_of_states

Array = npt.NDArray[np.float64]

# What a run has of readings, and not of the truth.
READ = ("position", "pressure_a", "pressure_b")


def needs_steps(parameters: RigParameters) -> bool:
    """Whether the valve or the readings have what the compiled loop does not know."""
    late = not Acquisition(parameters).at_once
    return late or ValveFault.of(parameters).present or bool(sensor_states(parameters))


class SteppedRun(NamedTuple):
    """A run: the columns of a trace by name, as read, and what else there is of it."""

    columns: dict[str, Array]
    commands: Array  # shape (n, 1 + terms): V, and the law's terms
    true_position: Array  # m
    areas: Array  # of the piston, m²


def run_stepped(rig: Rig, law: Law, references: Array, period: int) -> SteppedRun:
    """Control ``rig``, which has just been reset, along ``references`` (shape (n, 2): m, m/s).

    ``period`` is in ns. A sample of which something that the law uses is not finite is answered as
    the controller node does: the valve closes, and the law holds.
    """
    answers = Answers(law)
    seen: list[Measurement] = []
    states: list[State] = []
    areas = np.empty(len(references))
    commands = np.empty((len(references), 1 + len(law.TERMS)))
    for k, reference in enumerate(references):
        seen.append(rig.read())
        commands[k] = answers.answer(seen[k], ReferencePoint(*reference.tolist()))
        states.append(rig.command(commands[k, 0]))
        areas[k] = rig.plant.cylinder.piston_area
        # A run ends with its last sample: nobody sees what comes after it.
        if k + 1 < len(references):
            rig.advance(commands[k, 0], period * SECONDS_PER_NANOSECOND)
    columns = columns_of_states(states, period)
    true_position = columns["position"]
    columns |= {name: np.array([getattr(one, name) for one in seen]) for name in READ}
    return SteppedRun(columns, commands, true_position, areas)


class Answers:
    """Commands of a law, as safe as those of the node."""

    def __init__(self, law: Law) -> None:
        """Ask ``law``, which has been reset."""
        self._law = law
        self._low, self._high = output_limits(law.parameters)
        self._neutral = law.parameters.number("controller.neutral_voltage")
        self._last: int | None = None

    def answer(self, seen: Measurement, reference: ReferencePoint) -> tuple[float, ...]:
        """Return voltage (V) and terms, NaN without the law; raises LawError with the time."""
        _, position, *pressures = seen
        used = (position, *pressures) if self._law.USES_PRESSURES else (position,)
        if not all(map(math.isfinite, used)):
            self._law.hold()
            return (self._neutral, *(math.nan for _ in self._law.TERMS))
        last = seen.stamp if self._last is None else self._last
        interval = (seen.stamp - last) * SECONDS_PER_NANOSECOND
        self._last = seen.stamp
        voltage, *terms = ask(self._law, seen, reference, interval)
        return (min(max(voltage, self._low), self._high), *terms)
