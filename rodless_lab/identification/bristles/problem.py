# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a fit of the bristles minimises: the position's residuals, and what is known beforehand.

The measured pressures drive the carriage, so the valve plays no part. What is fitted beside the
bristles, and not reported: the rest of friction in both directions, a constant force (the bias of
the pressure sensors), the force and the place the run starts from, and the position sensor's
nonlinearity. Forces are compared nowhere: below breakaway a force of a few N is a tenth of a
millimetre.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_lab.identification.bristles.carriage import carriage_path
from rodless_lab.identification.pressures.course import smoothed
from rodless_lab.identification.pressures.problem import (
    CONSTANT_ERRORS,
    ERRORS,
    WITHIN_BOUND,
    position_accuracy,
    position_errors,
)
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import PRESSURE_RANGE, Instruments, position_range
from rodless_sim.physics import rail
from rodless_sim.physics.bristles import Bristles
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.friction import Friction
from rodless_sim.physics.friction_forms.direction import Direction

Array = npt.NDArray[np.float64]

# No position is known better than this (m): a perfect sensor still meets a model that is not, of
# which the force is known at the samples alone.
FINEST_POSITION = 1e-7

# The stiffest bristles (N/m) that are looked for, as declared: they give way by 0.3 µm.
STIFFEST = RigParameters.DECLARATIONS["friction.bristle_stiffness"].maximum

# Position is compared at this many instants at most.
MOST_INSTANTS = 8000

# A constant force that no bias explains, such as a rail not quite level (N).
FINEST_FORCE = 0.05


class Quantity(NamedTuple):
    """What is fitted: where the search begins, its natural size, and its bounds."""

    start: float
    scale: float
    low: float
    high: float


# Of F_s - F_c, F_c (N), v_s (m/s) and B (N·s/m): natural size and bounds.
_FRICTION = ((10.0, 0.0, 1e3), (10.0, 0.0, 1e3), (1e-3, 2e-4, 0.1), (1e3, 0.0, 1e5))

# Places among the values: 1/σ₀, σ₁, friction forward and reverse, the force the bristles bear at
# the start, the start position, the constant force and the sizes of the position sensor's errors.
COMPLIANCE, BRISTLE_DAMPING = 0, 1
FORWARD, REVERSE = slice(2, 6), slice(6, 10)
START_FORCE, START_POSITION, BIAS = 10, 11, 12
SHAPES = slice(13, 13 + ERRORS - 1)


class Problem:
    """Residuals of a run: readings at chosen instants, then what is known against its accuracy."""

    def __init__(self, run: MeasuredRun, parameters: RigParameters) -> None:
        """Compare ``run`` with a rig that is, but for what is fitted, as ``parameters``."""
        self._period = run.period
        self._mass = parameters.number("cylinder.moving_mass")
        self._lag = parameters.number("sensors.pressure_lag")
        self._friction = Friction.of(parameters)
        self._bristles = Bristles.of(parameters)
        self._reach = position_range(parameters)
        area = self._area = piston_area(parameters)
        self._sensors = parameters.with_values(dict.fromkeys(CONSTANT_ERRORS, 0.0))
        self._mean_pressure = 0.5 * float(np.mean(run.pressure_a + run.pressure_b))
        self._weight = rail.of(parameters).weight
        self.force = self._pushing(area * (run.pressure_a - run.pressure_b))
        self.noise = max(parameters.number("sensors.position_noise"), FINEST_POSITION)
        stride = max(1, math.ceil(len(run.time) / MOST_INSTANTS))
        self.chosen = slice(None, None, stride)
        self.spacing = stride * run.period
        self._measured = run.position[self.chosen]
        self.readings = len(self._measured)
        bias = area * parameters.number("sensors.pressure_bias") * PRESSURE_RANGE
        # The constant force that both sensors as stated may make between them, N.
        self.stated_force = 2.0 * bias + FINEST_FORCE
        self._accuracy = np.array(
            [
                max(math.sqrt(2.0) * bias * WITHIN_BOUND, FINEST_FORCE),
                *position_accuracy(parameters)[1:],
            ]
        )
        quantities = self._quantities(parameters, float(run.position[:10].mean()))
        self.start, self.scale, low, high = np.array(quantities).T
        self.bounds = (low, high)

    def _pushing(self, measured: Array) -> Array:
        """What the pressures push with (N), of what their late sensors show: no lag, less noise."""
        return without_lag(smoothed(measured, self._period), self._period, self._lag)

    def _quantities(self, parameters: RigParameters, position: float) -> list[Quantity]:
        found = [
            Quantity(1.0 / self._bristles.stiffness, 1e-6, 1.0 / STIFFEST, 1e-3),
            Quantity(self._bristles.damping, 300.0, 0.0, 1e5),
        ]
        for side in ("forward", "reverse"):
            direction = Direction.of(parameters, side)
            starts = (direction.static - direction.coulomb, *direction[1:])
            found += [
                Quantity(min(max(start, low), high), scale, low, high)
                for start, (scale, low, high) in zip(starts, _FRICTION, strict=True)
            ]
        found += [
            Quantity(float(self.force[0]) - self._weight, 1.0, -1e3, 1e3),
            Quantity(position, 1e-5, position - 1e-2, position + 1e-2),
            Quantity(0.0, 1.0, -100.0, 100.0),
            *[Quantity(0.0, 1e-4, -1e-2, 1e-2)] * (ERRORS - 1),
        ]
        return found

    def residuals(self, values: Array) -> Array:
        """Readings, then what is known beforehand, each over its standard error."""
        apart = (self._measured - self.modelled(values)[self.chosen]) / self.noise
        return np.concatenate([apart, values[BIAS:] / self._accuracy])

    def modelled(self, values: Array) -> Array:
        """What the position sensor would read, shape (n,), m."""
        place = self._path(values, self.force) + values[START_POSITION]
        # Along the modelled path: the measured one's noise would look like the position's own.
        return np.asarray(place + position_errors(place, self._reach)[:, 1:] @ values[SHAPES])

    def draws(self, values: Array, count: int, generator: np.random.Generator) -> Array:
        """Draw residuals that the sensors leave of a rig that is as ``values`` say.

        Shape (count, m), over the noise: the position's own, and what the pressures' does to a
        model that is driven by them.
        """
        place = self._path(values, self.force) + values[START_POSITION]
        half = 0.5 * self.force / self._area
        pressures = self._mean_pressure + half, self._mean_pressure - half
        return np.stack([self._drawn(values, place, pressures, generator) for _ in range(count)])

    def _drawn(
        self,
        values: Array,
        place: Array,
        pressures: tuple[Array, Array],
        generator: np.random.Generator,
    ) -> Array:
        tools, period = Instruments.specimen(self._sensors, generator), self._period
        read_a = tools.pressure_a.measure(pressures[0], period, generator)
        read_b = tools.pressure_b.measure(pressures[1], period, generator)
        force = self._pushing(self._area * (read_a - read_b))
        again = self._path(values, force) + values[START_POSITION]
        apart = (tools.position.measure(place, period, generator) - again)[self.chosen]
        own = math.sqrt(max(self.noise**2 - tools.position.noise**2, 0.0))
        return np.asarray((apart + generator.normal(0.0, own, apart.shape)) / self.noise)

    def _path(self, values: Array, force: Array) -> Array:
        stiffness = 1.0 / float(values[COMPLIANCE])
        return carriage_path(
            self._bristles._replace(stiffness=stiffness, damping=float(values[BRISTLE_DAMPING])),
            self._friction._replace(forward=_side(values[FORWARD]), reverse=_side(values[REVERSE])),
            self._mass,
            force - self._weight - values[BIAS],
            float(values[START_FORCE] - values[BIAS]) / stiffness,
            self._period,
        )


def without_lag(shown: Array, period: float, lag: float) -> Array:
    """Return what a first-order ``lag`` (s) shows as ``shown``, shape (n,), every ``period`` s."""
    keep = math.exp(-period / lag) if lag > 0.0 else 0.0
    if not keep:
        return shown
    # Along a straight line this is the value at that share of the way to the next sample.
    share = 1.0 / (1.0 - keep) - lag / period
    at = np.arange(len(shown))
    return np.interp(at, at[:-1] + share, (shown[1:] - keep * shown[:-1]) / (1.0 - keep))


def _side(values: Array) -> Direction:
    """Return friction of one direction, of F_s - F_c, F_c, v_s and B."""
    drop, coulomb, velocity, viscous = values.tolist()
    return Direction(coulomb + drop, coulomb, velocity, viscous)
