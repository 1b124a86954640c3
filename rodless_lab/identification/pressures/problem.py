# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""The least-squares problem of valve and chambers: what is fitted, and the residuals.

The carriage's measured motion drives the chambers, so friction plays no part. What is fitted
beside the parameters, and not reported: where both pressures start, and both temperatures where the
chambers have any; each pressure sensor's bias and the position sensor's offset and nonlinearity,
which are known beforehand to be within the sensors' accuracy.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.pressures.chamber_model import chamber_pressures
from rodless_lab.identification.pressures.course import smoothed
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import PRESSURE_RANGE, Instruments, position_range
from rodless_sim.instruments.transmitter import lagged
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.spool import Drive
from rodless_sim.physics.state import HeatedMotion, Motion

Array = npt.NDArray[np.float64]

# Standard deviation taken for a value within ±1: 0.58 if it is anywhere alike, 1 if always at the
# edge. What it is on a real rig nobody knows.
WITHIN_BOUND = 0.7

# Pressures are compared at this many instants at most, evenly spread: more cost time, and say
# little more, since the model carries one sample into the next.
MOST_INSTANTS = 6000

# No pressure is known better than this (Pa): a perfect sensor still meets a model that is not.
FINEST_PRESSURE = 20.0

# How many shapes the position sensor's error is made of; a shape no larger than this (m) is none.
ERRORS = 5
FINEST_POSITION = 1e-7

# How far the air of a chamber may be from the wall's temperature when a run starts (K, standard
# deviation): what rigs are that wait with the valve leaking.
START_TEMPERATURE = 5.0

# Samples of all draws that are smoothed together: a few MB.
SMOOTHED_AT_ONCE = 400_000

# No sensor's bias is looked for beyond this (Pa), or so many times what is stated of it.
LARGEST_BIAS = 5e4
TIMES_STATED = 4.0

# Errors of the sensors that do not change in a run; they are among what is fitted.
CONSTANT_ERRORS = (
    "sensors.position_linearity",
    "sensors.position_repeatability",
    "sensors.pressure_bias",
)


class Model(NamedTuple):
    """What a fit changes. The plant has no drive: a fit's dead time is no whole number of ns."""

    plant: Plant
    drive: Drive
    dead_time: float  # s
    spool_start: float  # V, from where the first command would hold the spool

    @classmethod
    def of(cls, parameters: RigParameters) -> "Model":
        """Return the model of a rig with ``parameters``."""
        plant = Plant.of(parameters)
        drive = plant.drive or Drive(0, 0.0, 0.0, parameters.number("valve.damping"))
        dead_time = parameters.number("valve.dead_time")
        return cls(plant._replace(drive=()), drive, dead_time, 0.0)


@dataclass(frozen=True)
class Unknown:
    """A quantity to fit, in ``unit``, and how it changes the model.

    ``start`` is where the search begins, ``scale`` the natural size, ``low`` and ``high`` bound it.
    Below ``blur`` the model hardly changes with it: derivatives there are taken over so much.
    """

    name: str
    unit: str
    start: float
    scale: float
    low: float
    high: float
    apply: Callable[[Model, float], Model]
    blur: float = 0.0

    @classmethod
    def parameter(
        cls,
        name: str,
        parameters: RigParameters,
        scale: float,
        apply: Callable[[Model, float], Model],
    ) -> "Unknown":
        """Return a parameter of the rig as an unknown, within the range it is declared with."""
        declared = RigParameters.DECLARATIONS[name]
        start, low, high = parameters.number(name), declared.minimum, declared.maximum
        return cls(name, declared.unit, start, scale, low, high, apply)


def of_plant(apply: Callable[[Plant, float], Plant]) -> Callable[[Model, float], Model]:
    """Return a change of the plant as one of the model."""
    return lambda model, value: model._replace(plant=apply(model.plant, value))


def position_errors(position: Array, reach: float) -> Array:
    """Shapes a position sensor's error may have, shape (n, ERRORS).

    An offset, and two waves along its range of ``reach`` (m) with either phase: what a nonlinear
    scale looks like.
    """
    angle = 2.0 * math.pi / reach * position
    shapes = [np.ones(position.shape)]
    for wave in (1.0, 2.0):
        shapes += [np.sin(wave * angle), np.cos(wave * angle)]
    return np.stack(shapes, axis=1)


def position_accuracy(parameters: RigParameters) -> Array:
    """Standard deviation in m of each of those shapes' sizes; the second wave's is half."""
    nonlinearity = parameters.number("sensors.position_linearity") * position_range(parameters)
    offset = parameters.number("sensors.position_repeatability")
    sizes = np.array([offset, nonlinearity, nonlinearity, 0.5 * nonlinearity, 0.5 * nonlinearity])
    return np.asarray(np.maximum(sizes * WITHIN_BOUND, FINEST_POSITION))


def reading_noise(parameters: RigParameters) -> float:
    """Standard deviation in Pa of a pressure's reading."""
    return max(parameters.number("sensors.pressure_noise"), FINEST_PRESSURE)


class Problem:
    """Residuals of a run: readings at chosen instants, then what is known against its accuracy.

    Values are the unknowns, then sizes of the position sensor's errors, temperatures (K) at the
    start where there are any, pressures (Pa) at the start, biases (Pa) of A, B and the supply.
    """

    def __init__(
        self,
        run: MeasuredRun,
        parameters: RigParameters,
        unknowns: Sequence[Unknown],
        known: Sequence[tuple[Unknown, float]] = (),
    ) -> None:
        """Compare ``run`` with a rig of ``parameters`` in which ``known`` have these sizes."""
        self._run = run
        self._unknowns = unknowns
        self._model = Model.of(parameters)
        for unknown, size in known:
            self._model = unknown.apply(self._model, size)
        self._lag = parameters.number("sensors.pressure_lag")
        self.bias = parameters.number("sensors.pressure_bias") * PRESSURE_RANGE
        self.noise = reading_noise(parameters)
        self._sensors = parameters.with_values(dict.fromkeys(CONSTANT_ERRORS, 0.0))
        self._reach = position_range(parameters)
        self._position = smoothed(run.position, run.period)
        stride = max(1, math.ceil(len(run.time) / MOST_INSTANTS))
        self._chosen = slice(None, None, stride)
        self.spacing = stride * run.period
        self._measured = np.stack([run.pressure_a, run.pressure_b], axis=1)[self._chosen]
        self.readings = self._measured.size
        count = min(10, len(run.time))
        first = [run.pressure_a[:count].mean(), run.pressure_b[:count].mean()]
        self.supply = float(run.supply_pressure.mean())
        self._shapes = slice(len(unknowns), len(unknowns) + ERRORS)
        plant = self._model.plant
        heat = plant.heat if plant.heated else ()
        warm = [heat.wall_temperature] * 2 if heat else []
        self._temperatures = slice(self._shapes.stop, self._shapes.stop + len(warm))
        expected = [0.0] * ERRORS + warm
        shape_accuracy = position_accuracy(parameters)
        accuracy = [*shape_accuracy, *[START_TEMPERATURE] * len(warm)]
        # Of what is known beforehand: where it is expected, and how far it may be from there.
        self._prior = np.array([*expected, 0.0, 0.0, 0.0])
        self._accuracy = np.array([*accuracy, *[max(self.bias * WITHIN_BOUND, 1.0)] * 3])
        extra = np.array([*expected, *first, 0.0, 0.0, 0.0])
        span = np.array([*accuracy, 1e3, 1e3, 1e3, 1e3, 1e3])
        largest_bias = max(LARGEST_BIAS, TIMES_STATED * self.bias)
        wide = np.array([*[1e-2] * ERRORS, *[100.0] * len(warm), 1e5, 1e5, *[largest_bias] * 3])
        self.start = np.concatenate([[unknown.start for unknown in unknowns], extra])
        self.scale = np.concatenate([[unknown.scale for unknown in unknowns], span])
        blur = [unknown.blur for unknown in unknowns]
        self.blur = np.concatenate([blur, np.zeros(span.shape)]) / self.scale
        self.bounds = (
            np.concatenate([[unknown.low for unknown in unknowns], extra - wide]),
            np.concatenate([[unknown.high for unknown in unknowns], extra + wide]),
        )

    def residuals(self, values: Array) -> Array:
        """Readings of A and of B, then what is known beforehand, each over its standard error."""
        distance = (self._measured - self.modelled(values)[self._chosen]) / self.noise
        known = np.concatenate([values[self._shapes.start : self._temperatures.stop], values[-3:]])
        return np.concatenate([distance.T.ravel(), (known - self._prior) / self._accuracy])

    def modelled(self, values: Array) -> Array:
        """What the sensors would read, shape (n, 2), Pa."""
        return self._shown(self._pressures(values, self._position), values)

    def draws(self, values: Array, count: int, generator: np.random.Generator) -> Array:
        """Draw residuals that the sensors leave of a rig that is as ``values`` say.

        Shape (count, 2, m), over the noise: the readings' own, and what the position's does to a
        model that is driven by it.
        """
        true = self._pressures(values, self._position)
        found = []
        # Smoothed some at a time: each smoothing alone would make the same filters anew.
        at_once = max(SMOOTHED_AT_ONCE // len(true), 1)
        for first in range(0, count, at_once):
            shown = [self._read(true, generator) for _ in range(first, min(first + at_once, count))]
            courses = smoothed(np.stack([position for position, _ in shown]), self._run.period)
            found += [
                self._left(values, course, read)
                for course, (_, read) in zip(courses, shown, strict=True)
            ]
        return np.stack(found)

    def _read(self, true: Array, generator: np.random.Generator) -> tuple[Array, Array]:
        """Draw what sensors read: position (m), shape (n,), and pressures (Pa), shape (2, n)."""
        tools = Instruments.specimen(self._sensors, generator)
        period = self._run.period
        position = tools.position.measure(self._position, period, generator)
        read = np.stack(
            [
                tool.measure(true[:, side], period, generator)
                for side, tool in enumerate((tools.pressure_a, tools.pressure_b))
            ]
        )
        own = math.sqrt(max(self.noise**2 - tools.pressure_a.noise**2, 0.0))
        return position, read + generator.normal(0.0, own, read.shape)

    def _left(self, values: Array, course: Array, read: Array) -> Array:
        """Return what a model driven by ``course`` leaves of pressures ``read``, over the noise."""
        again = self._pressures(values, course)
        shown = [lagged(again[:, side], self._run.period, self._lag) for side in range(2)]
        return np.asarray((read - np.stack(shown))[:, self._chosen] / self.noise)

    def supply_residuals(self) -> Array:
        """How far the readings of the supply are from their mean, over the noise, shape (m,)."""
        return np.asarray((self._run.supply_pressure[self._chosen] - self.supply) / self.noise)

    def _shown(self, pressures: Array, values: Array) -> Array:
        seen = [
            lagged(pressures[:, side], self._run.period, self._lag) + values[side - 3]
            for side in range(2)
        ]
        return np.stack(seen, axis=1)

    def _pressures(self, values: Array, position: Array) -> Array:
        start_a, start_b, bias_a, bias_b, bias_supply = values[-5:].tolist()
        plant = self._model.plant._replace(supply_pressure=self.supply - bias_supply)
        model = self._model._replace(plant=plant)
        for unknown, size in zip(self._unknowns, values.tolist(), strict=False):
            model = unknown.apply(model, size)
        start = (0.0, 0.0, start_a - bias_a, start_b - bias_b)
        warm = values[self._temperatures].tolist()
        return chamber_pressures(
            model.plant,
            model.drive,
            model.dead_time,
            float(self._run.voltage[0]) + model.spool_start,
            self._run.voltage,
            position - position_errors(position, self._reach) @ values[self._shapes],
            HeatedMotion(*start, *warm) if warm else Motion(*start),
            self._run.period,
        )
