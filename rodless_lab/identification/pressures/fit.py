# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Grey-box fit of valve and chambers: the rig's own equations against measured pressures.

The carriage's measured motion drives the chambers, so friction plays no part. What is fitted
beside the parameters, and not reported: where both pressures start, each pressure sensor's bias and
the position sensor's offset and nonlinearity, which are known beforehand to be within the
sensors' accuracy.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import optimize

from rodless_base.parameters import ParameterError
from rodless_lab.identification.estimate import Estimate, covariance, judged, symmetric
from rodless_lab.identification.parameter_writer import Finding
from rodless_lab.identification.pressures.chamber_model import (
    LONGEST_STEP,
    chamber_pressures,
    smoothed_motion,
)
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import POSITION_RANGE, PRESSURE_RANGE
from rodless_sim.instruments.transmitter import lagged
from rodless_sim.physics.heat import ENERGY_BALANCE
from rodless_sim.physics.plant import Plant

Array = npt.NDArray[np.float64]

SUPPLY = "supply.pressure"

# A run whose pressures stay within this many standard deviations of their noise informs nothing.
LEAST_CHANGE = 20.0

# Standard deviation taken for a value within ±1: 0.58 if it is anywhere alike, 1 if always at the
# edge. What it is on a real rig nobody knows.
WITHIN_BOUND = 0.7

# Pressures are compared at this many instants at most, evenly spread: more cost time, and say
# little more, since the model carries one sample into the next.
MOST_INSTANTS = 3000

# No pressure is known better than this (Pa): a perfect sensor still meets a model that is not.
FINEST_PRESSURE = 20.0

# How many shapes the position sensor's error is made of; a shape no larger than this (m) is none.
ERRORS = 5
FINEST_POSITION = 1e-7

# Standard errors are those of a linear model with Gaussian errors, which neither the chambers nor a
# sensor's bound are; in 100 hidden rigs they came out true, and this is the margin on top.
MARGIN = 1.2

# Relative step of the solver's finite differences.
DIFFERENCE = 1e-5

# Residuals beyond this many standard errors count linearly instead of squared.
ROBUST = 3.0


@dataclass(frozen=True)
class Unknown:
    """A quantity to fit, in ``unit``, and how it changes the plant.

    ``start`` is where the search begins, ``scale`` the natural size, ``low`` and ``high`` bound it.
    """

    name: str
    unit: str
    start: float
    scale: float
    low: float
    high: float
    apply: Callable[[Plant, float], Plant]

    @classmethod
    def parameter(
        cls,
        name: str,
        parameters: RigParameters,
        scale: float,
        apply: Callable[[Plant, float], Plant],
    ) -> "Unknown":
        """Return a parameter of the rig as an unknown, within the range it is declared with."""
        declared = RigParameters.DECLARATIONS[name]
        start, low, high = parameters.number(name), declared.minimum, declared.maximum
        return cls(name, declared.unit, start, scale, low, high, apply)


@dataclass(frozen=True)
class PressureFit:
    """Estimates by name, and how the model follows the run.

    ``pressure_a`` and ``pressure_b`` (Pa, shape (n,)) are the model's readings; ``scatter`` (Pa) is
    that of the measured about them; ``correlation_time`` (s) that of the scatter.
    """

    estimates: Mapping[str, Estimate]
    pressure_a: Array
    pressure_b: Array
    scatter: float
    correlation_time: float


def fit_pressures(
    run: MeasuredRun, parameters: RigParameters, unknowns: Sequence[Unknown]
) -> PressureFit:
    """Fit ``unknowns`` to the chamber pressures of ``run``; everything else is as ``parameters``.

    Intervals come from the Jacobian and the scatter of the residuals, widened by how far these are
    correlated in time, and by the bias of the sensors as ``parameters`` state it. Raises
    :class:`UninformativeRunError` where no pressure changes, ParameterError for chambers with
    temperatures and for a spool that does not follow at once.
    """
    if parameters.text("chambers.thermodynamics") == ENERGY_BALANCE:
        raise ParameterError(
            f"chambers.thermodynamics: {ENERGY_BALANCE} refused, the fit knows no temperatures; "
            "identify with adiabatic, and expect other dead volumes where heat matters"
        )
    if Plant.of(parameters).drive:
        raise ParameterError(
            "valve.dynamics, valve.hysteresis, valve.dead_time: refused, the fit takes the spool "
            "to be where the command says; identify without, and expect other curves near closed"
        )
    problem = _Problem(run, parameters, unknowns)
    change = max(float(np.ptp(run.pressure_a)), float(np.ptp(run.pressure_b)))
    if change < LEAST_CHANGE * problem.noise:
        raise UninformativeRunError(f"the pressures change by only {change:.3g} Pa")
    # In natural sizes, so that the solver's finite differences suit every one.
    scale = problem.scale

    def residuals_of(scaled: Array) -> Array:
        return problem.residuals(scaled * scale)

    found = optimize.least_squares(
        residuals_of,
        problem.start / scale,
        bounds=(problem.bounds[0] / scale, problem.bounds[1] / scale),
        diff_step=np.full(scale.shape, DIFFERENCE),
        loss="soft_l1",
        f_scale=ROBUST,
        xtol=1e-7,
        ftol=1e-7,
        gtol=1e-7,
        max_nfev=40,
    )
    values = np.asarray(found.x) * scale
    residuals = problem.residuals(values)[: problem.readings]
    spacing, inflation = problem.spacing, _correlation(residuals.reshape(2, -1))
    freedom = problem.readings - len(values)
    variance = max(float(residuals @ residuals) / freedom, 1.0)
    jacobian = np.asarray(found.jac) / scale
    # What is known beforehand of the biases does not share the residuals' scatter.
    jacobian[: problem.readings] /= math.sqrt(variance * inflation)
    errors = MARGIN * np.sqrt(np.diag(covariance(jacobian, 1.0)))
    effective = freedom / inflation
    estimates = {
        unknown.name: judged(
            symmetric(float(value), float(error), effective, unknown.unit),
            "the run leaves it open within half its value",
        )
        for unknown, value, error in zip(unknowns, values, errors, strict=False)
    }
    supply = symmetric(problem.supply - float(values[-1]), float(errors[-1]), effective, "Pa")
    estimates[SUPPLY] = supply
    modelled = problem.modelled(values)
    return PressureFit(
        estimates,
        modelled[:, 0],
        modelled[:, 1],
        float(np.std(residuals)) * problem.noise,
        inflation * spacing,
    )


def _correlation(residuals: Array) -> float:
    """Factor by which correlation in time multiplies a mean's variance; residuals shape (2, n).

    One plus twice the sum of the autocorrelation up to its first value within chance of zero.
    """
    factors = []
    for row in residuals:
        centred = row - row.mean()
        power = float(centred @ centred)
        if power == 0.0:
            return 1.0
        longest = len(row) // 4
        spectrum = np.fft.rfft(centred, 2 * len(row))
        correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:longest] / power
        chance = np.flatnonzero(correlation < 2.0 / math.sqrt(len(row)))
        last = int(chance[0]) if len(chance) else longest
        factors.append(1.0 + 2.0 * float(np.sum(correlation[1:last])))
    return max(*factors, 1.0)


def _position_errors(position: Array) -> tuple[Array, Array]:
    """Shapes a position sensor's error may have, shape (n, ERRORS), and their slopes by position.

    An offset, and two waves along the range with either phase: what a nonlinear scale looks like.
    """
    angle = 2.0 * math.pi / POSITION_RANGE * position
    shapes, slopes = [np.ones(position.shape)], [np.zeros(position.shape)]
    for wave in (1.0, 2.0):
        rate = 2.0 * math.pi / POSITION_RANGE * wave
        shapes += [np.sin(wave * angle), np.cos(wave * angle)]
        slopes += [rate * np.cos(wave * angle), -rate * np.sin(wave * angle)]
    return np.stack(shapes, axis=1), np.stack(slopes, axis=1)


def _position_accuracy(parameters: RigParameters) -> Array:
    """Standard deviation in m of each of those shapes' sizes; the second wave's is half."""
    nonlinearity = parameters.number("sensors.position_linearity") * POSITION_RANGE
    offset = parameters.number("sensors.position_repeatability")
    sizes = np.array([offset, nonlinearity, nonlinearity, 0.5 * nonlinearity, 0.5 * nonlinearity])
    return np.asarray(np.maximum(sizes * WITHIN_BOUND, FINEST_POSITION))


class _Problem:
    """Residuals of a run: readings at chosen instants, then the biases against their accuracy."""

    def __init__(
        self, run: MeasuredRun, parameters: RigParameters, unknowns: Sequence[Unknown]
    ) -> None:
        self._run = run
        self._unknowns = unknowns
        self._plant = Plant.of(parameters)
        self._lag = parameters.number("sensors.pressure_lag")
        bias = parameters.number("sensors.pressure_bias") * PRESSURE_RANGE
        self._accuracy = max(bias * WITHIN_BOUND, 1.0)
        self.noise = max(parameters.number("sensors.pressure_noise"), FINEST_PRESSURE)
        self._position, self._velocity = smoothed_motion(run)
        self._error, self._error_slope = _position_errors(self._position)
        self._position_accuracy = _position_accuracy(parameters)
        self._steps = max(1, math.ceil(run.period / LONGEST_STEP - 1e-9))
        stride = max(1, math.ceil(len(run.time) / MOST_INSTANTS))
        self._chosen = slice(None, None, stride)
        self.spacing = stride * run.period
        self._measured = np.stack([run.pressure_a, run.pressure_b], axis=1)[self._chosen]
        self.readings = self._measured.size
        count = min(10, len(run.time))
        first = np.array([run.pressure_a[:count].mean(), run.pressure_b[:count].mean()])
        self.supply = float(run.supply_pressure.mean())
        extra = np.array([*np.zeros(ERRORS), *first, 0.0, 0.0, 0.0])
        span = np.array([*self._position_accuracy, 1e3, 1e3, 1e3, 1e3, 1e3])
        wide = np.array([*np.full(ERRORS, 1e-2), 1e5, 1e5, 5e4, 5e4, 5e4])
        self.start = np.concatenate([[unknown.start for unknown in unknowns], extra])
        self.scale = np.concatenate([[unknown.scale for unknown in unknowns], span])
        self.bounds = (
            np.concatenate([[unknown.low for unknown in unknowns], extra - wide]),
            np.concatenate([[unknown.high for unknown in unknowns], extra + wide]),
        )

    def residuals(self, values: Array) -> Array:
        """Readings of A and of B, then the sensors' errors, each over its standard error."""
        distance = (self._measured - self.modelled(values)[self._chosen]) / self.noise
        shape = values[-5 - ERRORS : -5] / self._position_accuracy
        return np.concatenate([distance.T.ravel(), shape, values[-3:] / self._accuracy])

    def modelled(self, values: Array) -> Array:
        """What the sensors would read, shape (n, 2), Pa."""
        start_a, start_b, bias_a, bias_b, bias_supply = values[-5:]
        plant = self._plant._replace(supply_pressure=self.supply - bias_supply)
        for unknown, value in zip(self._unknowns, values, strict=False):
            plant = unknown.apply(plant, float(value))
        shape = values[-5 - ERRORS : -5]
        pressures = chamber_pressures(
            plant,
            self._run.voltage,
            self._position - self._error @ shape,
            self._velocity * (1.0 - self._error_slope @ shape),
            (start_a - bias_a, start_b - bias_b),
            self._run.period,
            self._steps,
        )
        seen = [
            lagged(pressures[:, side], self._run.period, self._lag) + bias
            for side, bias in enumerate((bias_a, bias_b))
        ]
        return np.stack(seen, axis=1)


def findings_of(fit: PressureFit, names: Sequence[str]) -> list[Finding]:
    """Return the parameters ``names`` as the fit has them."""
    return [
        Finding(name, estimate.value if estimate.informed else None, {name: estimate})
        for name in names
        for estimate in [fit.estimates[name]]
    ]
