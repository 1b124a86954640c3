# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The work that every solver does alike: the rig at 1 kHz, in closed loop and open loop."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_control import Pid, references
from rodless_control.laws.pid import Gains, gains_of
from rodless_control.references import Reference, sampled
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig
from rodless_lab.simulation.closed_loop import closed_loop, limits_of, loop_of, sample_count
from rodless_sim import RigParameters
from rodless_sim.instruments.sampling import NOISE_CHANNELS, instruments_and_noise
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.state import AnyMotion
from rodless_sim.rig import starting_motion
from rodless_sim.timing import nanoseconds, sample_times
from rodless_sim.trace import COLUMNS, run_open_loop

Array = npt.NDArray[np.float64]

# Samples of a run, shape (n, 4 or more): those of Motion, then what else there is.
Run = Callable[[float], Array]

DURATION = 6.0  # s
PERIOD = 1e-3  # s


class Task(NamedTuple):
    """What the carriage should follow, and where it starts (m)."""

    reference: Reference
    start: float


TASKS = {
    "step": Task(references.step(0.0, 0.058, at=0.5), 0.0),
    "sine": Task(references.sine(0.1, 0.02, 0.381, at=0.2), 0.1),
}

# The converged solution is this package's at this share of its usual tolerance. Solvers that share
# no method with it agree with it the better the smaller their tolerance: docs/benchmarks.md.
CONVERGED = 1e-4


class Errors(NamedTuple):
    """Largest differences from the converged solution."""

    position: float  # m
    pressure: float  # Pa, of either chamber


@dataclass(frozen=True, eq=False)
class Work:
    """Six seconds of one rig; with ``voltages`` (V, shape (n,)) open loop, otherwise closed."""

    rig: str  # one of BARE_RIGS
    task: str
    voltages: Array | None = None

    @property
    def name(self) -> str:
        """What it is, in words."""
        kind = "closed loop" if self.is_closed else "open loop"
        return f"{kind}, {self.task}, {self.rig}"

    @property
    def is_closed(self) -> bool:
        """Whether the controller is in the loop."""
        return self.voltages is None

    @property
    def reference(self) -> Reference:
        """What the carriage should follow."""
        return TASKS[self.task].reference

    @property
    def start(self) -> float:
        """Where the carriage starts, in m."""
        return TASKS[self.task].start

    @cached_property
    def parameters(self) -> RigParameters:
        """Those of the rig."""
        return bare_rig(self.rig)

    @cached_property
    def plant(self) -> Plant:
        """The rig's constants."""
        return Plant.of(self.parameters)

    @cached_property
    def law(self) -> Pid:
        """The controller."""
        return Pid(bare_pid(self.rig))

    @cached_property
    def gains(self) -> Gains:
        """The controller's constants."""
        return gains_of(bare_pid(self.rig))

    @cached_property
    def state(self) -> AnyMotion:
        """The rig at rest where it starts."""
        return starting_motion(self.plant, self.parameters, self.start)

    @cached_property
    def references(self) -> Array:
        """Position (m) and velocity (m/s) wanted at each sample, shape (n, 2)."""
        period = nanoseconds(PERIOD)
        times = sample_times(sample_count(nanoseconds(DURATION), period), period)
        return sampled(self.reference, times)

    @property
    def samples(self) -> int:
        """How many there are, the start among them."""
        return len(self.references) if self.voltages is None else len(self.voltages) + 1

    @cached_property
    def run(self) -> Run:
        """The compiled loop of this package: samples for a tolerance (``time.tolerance``)."""
        voltages = self.voltages
        if voltages is not None:
            return lambda tolerance: run_open_loop(
                self.plant, voltages, self.state, (), nanoseconds(PERIOD), tolerance, len(COLUMNS)
            )[0]
        loop, gains = loop_of(self.law)
        instruments, _ = instruments_and_noise(self.parameters)
        no_noise = np.zeros((len(self.references), NOISE_CHANNELS))
        return lambda tolerance: loop(
            self.plant,
            instruments,
            no_noise,
            gains,
            limits_of(self.law),
            self.references,
            self.state,
            (),
            tolerance,
            nanoseconds(PERIOD),
            len(COLUMNS),
            1 + len(self.law.TERMS),
        )[0]

    @cached_property
    def converged(self) -> Array:
        """The samples that all others are compared with."""
        return self.run(CONVERGED)

    def errors(self, rows: Array) -> Errors:
        """Compare samples with the converged ones."""
        difference = np.abs(rows[:, :4] - self.converged[:, :4]).max(axis=0)
        return Errors(float(difference[0]), float(difference[2:].max()))


def all_work() -> list[Work]:
    """Return step and sine of both rigs in closed loop, then the same voltages open loop."""
    closed = [Work(rig, task) for rig in BARE_RIGS for task in TASKS]
    return closed + [Work(one.rig, one.task, voltages_of(one)) for one in closed]


def voltages_of(work: Work) -> Array:
    """Return the commands of a closed loop, shape (n,), V; the last has no sample after it."""
    run = closed_loop(work.parameters, work.law, work.reference, DURATION, PERIOD, work.start)
    commands: Array = run.voltage[:-1].copy()
    return commands
