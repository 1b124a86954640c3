# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the laws have to do: moves and sines, with what makes them hard."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rodless_control import references
from rodless_control.references import Reference
from rodless_lab.simulation.draw import draw
from rodless_sim import RigParameters, Scenario
from rodless_sim.instruments.instruments import DATA_SHEET, IDEAL

FRICTION = tuple(
    f"friction.{name}"
    for name in (
        "forward.static",
        "forward.coulomb",
        "forward.viscous",
        "reverse.static",
        "reverse.coulomb",
        "reverse.viscous",
        "high_speed_viscous",
    )
)


@dataclass(frozen=True)
class Steps:
    """A reference that jumps to one of ``positions`` (m) at each of ``times`` (s)."""

    start: float
    times: tuple[float, ...]
    positions: tuple[float, ...]

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        passed = int(np.searchsorted(self.times, time, side="right"))
        return (self.positions[passed - 1] if passed else self.start), 0.0


@dataclass(frozen=True)
class Task:
    """A reference, and what the rig is like on the way; at 1 kHz with the instruments of the paper.

    ``factors`` multiply parameters of the rig from ``at`` (s) on. ``delay`` is that of all readings
    (``sensors.delay``). Peak and RMS count from ``since`` (s). ``cycles`` are those of a sine in
    the whole run; a task without is a move, whose last step is judged.
    """

    name: str
    reference: Reference
    duration: float  # s
    period: float = 1e-3  # s
    position: float = 0.0  # m
    ideal: bool = False  # instruments without noise, lag and bias
    delay: float = 0.0  # s
    factors: Mapping[str, float] = field(default_factory=dict)
    at: float = 0.0  # s
    since: float = 0.0  # s
    cycles: float = 0.0

    def rig(self, drawn: RigParameters) -> RigParameters:
        """Return a drawn rig as this task begins with it."""
        values: dict[str, object] = dict(IDEAL if self.ideal else DATA_SHEET)
        if self.at == 0.0:
            values |= self.changed(drawn)
        return drawn.with_values({**values, "sensors.delay": self.delay})

    def scenario(self, rig: RigParameters) -> Scenario | None:
        """Return what happens to ``rig`` on the way."""
        return Scenario([(self.at, self.changed(rig))], self.name) if self.at > 0.0 else None

    def changed(self, rig: RigParameters) -> dict[str, object]:
        """Return the values that ``factors`` give ``rig``."""
        return {name: rig.number(name) * factor for name, factor in self.factors.items()}


def sine(name: str, frequency: float) -> Task:
    """20 mm about the middle, of which the first period does not count."""
    start, cycles = 0.1, 2.0
    return Task(
        name,
        references.sine(0.1, 0.02, frequency, at=start),
        start + (cycles + 1.0) / frequency,
        position=0.1,
        since=start + 1.0 / frequency,
        cycles=cycles + 1.0,
    )


def random_steps(seed: int, count: int = 4) -> Steps:
    """Targets from 20 to 180 mm, one a second from 0.1 s on."""
    targets = np.random.default_rng(seed).uniform(0.02, 0.18, count)
    return Steps(0.0, tuple(0.1 + k for k in range(count)), tuple(targets.tolist()))


def tasks(seed: int) -> list[Task]:
    """Return all tasks, in the order of the table."""
    step = references.step(0.0, 0.058, at=0.1)
    there_and_back = Steps(0.0, (0.1, 1.5), (0.058, 0.02))
    return [
        Task("58 mm step", step, 2.1),
        Task("58 mm step, ideal sensors", step, 2.1, ideal=True),
        Task("58 mm step, half the friction", step, 2.1, factors=dict.fromkeys(FRICTION, 0.5)),
        Task("random steps", random_steps(seed), 4.6),
        Task(
            "twice the load after 1 s",
            there_and_back,
            3.5,
            factors={"cylinder.moving_mass": 2.0},
            at=1.0,
        ),
        Task(
            "supply drops by a fifth after 1 s",
            there_and_back,
            3.5,
            factors={"supply.pressure": 0.8},
            at=1.0,
        ),
        Task("58 mm step, 1 ms delay", step, 2.1, delay=1e-3),
        Task("58 mm step, 5 ms delay", step, 2.1, delay=5e-3),
        Task("58 mm step at 100 Hz", step, 2.1, period=1e-2),
        sine("20 mm sine, 0.381 Hz", 0.381),
        sine("20 mm sine, 0.5 Hz", 0.5),
    ]


def rigs(count: int, seed: int) -> Sequence[RigParameters]:
    """Draw rigs around ``calibrated``: nobody knows mass, supply, friction and tubes."""
    base = RigParameters.preset("calibrated")
    ranges = {
        "cylinder.moving_mass": (0.7, 2.0),
        "supply.pressure": (501325.0, 701325.0),
        "cylinder.dead_volume_*": (10e-6, 30e-6),
    }
    factors = {
        "friction.*.static": (0.7, 1.3),
        "friction.*.coulomb": (0.7, 1.3),
        "friction.*viscous": (0.7, 1.3),
    }
    return list(draw(ranges, count, base=base, seed=seed, factors=factors))
