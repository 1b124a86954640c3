# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig's instruments at work, sample after sample."""

import math
from typing import Any

import numpy as np

from rodless_base.kernels import specialise
from rodless_base.measurement import Measurement
from rodless_base.parameters import ParameterSet
from rodless_sim.faults import FROZEN, sensor_states
from rodless_sim.instruments.acquisition import Acquisition
from rodless_sim.instruments.instruments import Instruments, Lags, read_rig
from rodless_sim.instruments.transmitter import is_ideal

# Random numbers for each sample: position, chambers A and B, supply.
NOISE_CHANNELS = 4


def instruments_and_noise(parameters: ParameterSet) -> tuple[Instruments, np.random.Generator]:
    """Return the instruments that ``sensors.seed`` stands for, and the generator of their noise."""
    generator = np.random.default_rng(int(parameters.number("sensors.seed")))
    return Instruments.specimen(parameters, generator), generator


def are_ideal(instruments: Instruments) -> bool:
    """Whether position and pressures are read without errors."""
    return all(is_ideal(tool) for tool in instruments[:NOISE_CHANNELS])


class Sampling:
    """Reads the instruments of a rig; each start with the same seed gives the same readings."""

    def __init__(self, parameters: ParameterSet) -> None:
        """Take the instruments of ``parameters``."""
        self._acquisition = Acquisition(parameters)
        self._take(parameters)
        self._compile()
        self.start()

    def _compile(self) -> None:
        example = Measurement(0, 0.0, 0.0, 0.0, 0.0)
        self._read = specialise(
            read_rig, self._instruments, Lags(example, example), example, np.zeros(NOISE_CHANNELS)
        )

    def __getstate__(self) -> dict[str, object]:
        """Leave the compiled function out: :mod:`pickle` cannot have it."""
        return {name: value for name, value in vars(self).items() if name != "_read"}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Compile again."""
        vars(self).update(state)
        self._compile()

    def configure(self, parameters: ParameterSet) -> None:
        """Change the instruments; their noise goes on, unless the seed is another.

        What is under way in converter and lags stays, as does what is frozen.
        """
        before = self._parameters["sensors.seed"]
        self._acquisition.configure(parameters)
        self._take(parameters)
        if parameters["sensors.seed"] != before:
            self._draw()

    def _take(self, parameters: ParameterSet) -> None:
        self._instruments, _ = instruments_and_noise(parameters)
        self._parameters = parameters
        self._ideal = are_ideal(self._instruments)
        self._states = sensor_states(parameters)

    def start(self) -> None:
        """Begin anew: what is read next is sample 0, its lags settled."""
        self._shown: Measurement | None = None  # as read, its faults included
        self._acquisition.start()
        self._instant: int | None = None
        self._held: Measurement | None = None  # as the converter has it, at _instant
        self._before: Lags | None = None
        self._after: Lags | None = None
        self._stamp: int | None = None
        self._draw()

    def _draw(self) -> None:
        """Begin the noise that ``sensors.seed`` stands for."""
        _, self._generator = instruments_and_noise(self._parameters)
        self._noise = self._generator.standard_normal(NOISE_CHANNELS)

    def read(self, true: Measurement) -> Measurement:
        """Return the readings of the true values ``true``.

        Another stamp than before is the next sample, with noise of its own; at one stamp the same
        is read.
        """
        if self._stamp not in (None, true.stamp):
            self._next()
        self._stamp = true.stamp
        at_once = self._acquisition.at_once
        readings = self._converted(true) if at_once else self._acquired(true)
        self._shown = self._disturbed(readings) if self._states else readings
        return self._shown

    def _acquired(self, true: Measurement) -> Measurement:
        """Return the last sample of the converter, as a reading at the stamp of ``true``."""
        sample = self._acquisition.sampled(true)
        if self._held is None or sample.stamp != self._instant:
            self._instant, self._held = sample.stamp, self._converted(sample)
        return self._held._replace(stamp=true.stamp)

    def _converted(self, true: Measurement) -> Measurement:
        """Return what the instruments show at the stamp of ``true``."""
        if self._ideal:
            self._after = None
            return true
        before = self._before or Lags(true, true)
        readings, self._after = self._read(self._instruments, before, true, self._noise)
        return readings

    def _disturbed(self, readings: Measurement) -> Measurement:
        """Return ``readings`` of which some are frozen at what was shown last, or gone."""
        frozen = self._shown or readings
        values: dict[str, Any] = {
            field: getattr(frozen, field) if state == FROZEN else math.nan
            for field, state in self._states.items()
        }
        return readings._replace(**values)

    def _next(self) -> None:
        self._before = self._after
        if not self._ideal:
            self._noise = self._generator.standard_normal(NOISE_CHANNELS)
