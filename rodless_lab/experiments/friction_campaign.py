# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Runs at constant voltage on a simulated rig, and the friction identified from all of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_lab.experiments.runner import IN_PROCESS, Runner
from rodless_lab.identification.friction.fit import (
    FINEST_FORCE,
    DirectionFit,
    FrictionFit,
    fit_friction,
)
from rodless_lab.identification.friction.run import (
    EVENT_ACCURACY,
    FrictionPoints,
    bias_force,
    friction_points,
    speed_stretch,
)
from rodless_lab.identification.friction.uniform_motion import uniform_parts
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, Trace
from rodless_sim.instruments.instruments import Instruments, read_trace
from rodless_sim.physics.cylinder import piston_area

Array = npt.NDArray[np.float64]

PERIOD = 1e-3
LONGEST = 20.0

# Where runs start, and the ends at which they stop before the carriage reaches an end cap.
START, END = 0.02, 0.185

# A ramp this slow breaks the carriage loose again and again, V/s; it starts from closed.
RAMP_RATE = 0.005


@dataclass(frozen=True)
class FrictionRun:
    """One run as measured, what it tells, and its voltage in V (a ramp: the last one)."""

    voltage: float
    ramp: bool
    trace: Trace
    points: FrictionPoints

    @property
    def name(self) -> str:
        """The run by its voltage."""
        return f"ramp to {self.voltage:g} V" if self.ramp else f"{self.voltage:g} V"

    @property
    def representative(self) -> tuple[float, float]:
        """Speed (m/s) and force (N) of the uniform part of median speed."""
        order = np.argsort(np.abs(self.points.speeds))
        middle = order[len(order) // 2]
        return float(self.points.speeds[middle]), float(self.points.forces[middle])

    @property
    def verdict(self) -> str:
        """What the run is used for, or why its motion is left out."""
        events = self.points.events
        used = []
        if len(self.points.speeds):
            low, high = np.abs(self.points.speeds).min(), np.abs(self.points.speeds).max()
            used.append(f"uniform, {low * 1e3:.2f} to {high * 1e3:.2f} mm/s")
        else:
            used.append(f"left out of uniform motion ({self.points.reason})")
        if len(events.breakaways) or len(events.stops):
            used.append(f"{len(events.breakaways)} breakaways and {len(events.stops)} stops")
        return "; ".join(used)


@dataclass(frozen=True)
class Identification:
    """All runs of one campaign and the friction found from them.

    ``uniform`` rests on uniform motion alone, ``complete`` on breakaways and stops too.
    """

    runs: tuple[FrictionRun, ...]
    uniform: FrictionFit
    complete: FrictionFit


def constant_run(rig: RigParameters, voltage: float, runner: Runner = IN_PROCESS) -> Trace:
    """Hold ``voltage`` (V) from rest near one end until the carriage is near the other."""
    forward = voltage > CLOSED_VOLTAGE
    stroke = rig.number("cylinder.stroke")
    start = START if forward else stroke - START
    run = runner.open_loop(rig, np.full(round(LONGEST / PERIOD), voltage), PERIOD, start)
    done = run.position > END if forward else run.position < stroke - END
    return cut(run, int(np.argmax(done)) if done.any() else len(done))


def ramp_run(rig: RigParameters, end: float, runner: Runner = IN_PROCESS) -> Trace:
    """Ramp the voltage slowly from closed to ``end`` (V), the carriage at mid-stroke."""
    count = round(abs(end - CLOSED_VOLTAGE) / RAMP_RATE / PERIOD)
    return runner.open_loop(
        rig, np.linspace(CLOSED_VOLTAGE, end, count), PERIOD, 0.5 * rig.number("cylinder.stroke")
    )


def cut(run: Trace, count: int) -> Trace:
    """Return the first ``count`` samples."""
    return type(run)(**{name: values[:count] for name, values in run.columns().items()})


def identified(
    traces: Sequence[tuple[float, bool, Trace]], sensors: RigParameters, seed: int
) -> Identification:
    """Measure the traces with one set of instruments and fit eq. (29) to all of them."""
    generator = np.random.default_rng(seed)
    tools = Instruments.specimen(sensors, generator)
    runs = []
    for voltage, ramp, trace in traces:
        seen = read_trace(trace, sensors, generator, tools)
        runs.append(FrictionRun(voltage, ramp, seen, read_off(seen, sensors)))
    found = [run.points for run in runs]
    return Identification(tuple(runs), fitted(found, sensors, False), fitted(found, sensors, True))


def read_off(seen: Trace, sensors: RigParameters) -> FrictionPoints:
    """Return uniform motion and stick-slip events of a measured run.

    As the paper's campaign has a run for every speed, it can be stricter than an identification
    from a single bag: only parts whose speed stays within 5 % count.
    """
    read = friction_points(run_of_trace(seen, sensors.number("supply.pressure")), sensors)
    found = uniform_parts(seen.time, seen.position)
    mass = sensors.number("cylinder.moving_mass")
    scatter = piston_area(sensors) * math.sqrt(2.0)
    scatter *= sensors.number("sensors.pressure_noise")
    speeds = np.array([part.speed for part in found.parts])
    nonlinearity = math.pi * sensors.number("sensors.position_linearity") * np.abs(speeds)
    return replace(
        read,
        speeds=speeds,
        speed_errors=np.hypot([part.speed_error for part in found.parts], nonlinearity),
        forces=np.array([part.mean(seen.force) - mass * part.acceleration for part in found.parts]),
        force_errors=np.array(
            [math.hypot(scatter / math.sqrt(p.last - p.first), FINEST_FORCE) for p in found.parts]
        ),
        reason=found.reason,
    )


def fitted(points: Sequence[FrictionPoints], sensors: RigParameters, events: bool) -> FrictionFit:
    """Fit eq. (29) to all points together, with or without stick-slip ``events``."""

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(point, name) for point in points])

    kept = [point.events for point in points] if events else []
    breakaways = [(e.breakaways, e.breakaway_errors) for e in kept if len(e.breakaways)]
    stops = [(e.stops, e.stop_errors) for e in kept if len(e.stops)]
    fit = fit_friction(
        all_of("speeds"),
        all_of("forces"),
        speed_errors=all_of("speed_errors"),
        force_errors=all_of("force_errors"),
        # Events of one run repeat one motion, with the same error of finding their moment: they
        # count once, or the interval would shrink below what they are worth.
        breakaways=[np.mean(forces) for forces, _ in breakaways],
        breakaway_errors=[shared(errors, len(breakaways)) for _, errors in breakaways],
        stops=[np.mean(forces) for forces, _ in stops],
        stop_errors=[shared(errors, len(stops)) for _, errors in stops],
    )
    return FrictionFit(biased(fit.forward, sensors), biased(fit.reverse, sensors))


def shared(errors: Array, runs: int) -> float:
    """Standard error in N of a run's events, with the part that ``runs`` runs do not average."""
    return float(math.hypot(np.mean(errors), EVENT_ACCURACY * math.sqrt(runs)))


def biased(fit: DirectionFit, sensors: RigParameters) -> DirectionFit:
    """Widen the intervals by what noise cannot show: bias and nonlinearity of sensors."""
    force, stretch = bias_force(sensors), speed_stretch(sensors)
    return replace(
        fit,
        static=fit.static.widened(force),
        coulomb=fit.coulomb.widened(force),
        stribeck_velocity=fit.stribeck_velocity.widened(stretch * fit.stribeck_velocity.value),
        viscous=fit.viscous.widened(stretch * fit.viscous.value),
    )
