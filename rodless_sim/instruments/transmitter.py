# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One instrument: a model that turns a true value into a reading. Table 1 of the paper."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel

Array = npt.NDArray[np.float64]

# Volts that stand for nothing and for the range, those at which the output saturates (NAMUR NE 43:
# 3.8 and 20.5 mA of 4-20 mA), and the converter's input range.
OUTPUT_LOW = 1.0
OUTPUT_SPAN = 4.0
LOWEST_OUTPUT = 0.95
HIGHEST_OUTPUT = 5.125
CONVERTER_SPAN = 20.0


class Transmitter(NamedTuple):
    """One instrument with 1-5 V output, with the fixed errors of this specimen.

    Its unit is that of what it measures: m, Pa or m³/s.
    """

    span: float  # unit, what 4 V stand for
    offset: float = 0.0  # unit
    gain_error: float = 0.0  # -
    nonlinearity: float = 0.0  # unit, largest deviation from a line; one wave along the range
    noise: float = 0.0  # unit, standard deviation of a sample
    lag: float = 0.0  # s, time constant
    bits: int = 0  # of the converter; 0 means no rounding

    def measure(self, values: Array, period: float, generator: np.random.Generator) -> Array:
        """Return what is read of the true ``values``, shape (n,), sampled every ``period`` s."""
        true = np.asarray(values, dtype=np.float64)
        return read_all(self, true, period, generator.standard_normal(true.shape))


@kernel
def followed(behind: float, before: float, true: float, period: float, lag: float) -> float:
    """Return the output of a first-order lag one ``period`` (s) later.

    ``behind`` was its output and ``before`` its input, which has gone to ``true`` on a straight
    line: nothing is known of its course between samples. Without a lag the output is ``true`` at
    once.
    """
    if lag <= 0.0:
        return true
    if period <= 0.0:  # at the first sample
        return behind
    ratio = period / lag
    gone = -math.expm1(-ratio)
    return true + (1.0 - gone) * (behind - before) - (true - before) * gone / ratio


@kernel
def lagged(values: Array, period: float, lag: float) -> Array:
    """First-order lag of time constant ``lag`` (s), settled at the first sample; shape (n,)."""
    late: Array = values.copy()
    for k in range(1, values.size):
        late[k] = followed(late[k - 1], values[k - 1], values[k], period, lag)
    return late


@kernel
def is_ideal(instrument: Transmitter) -> bool:
    """Whether the instrument shows the true value: it has no error, and then no range either."""
    return (
        instrument.offset == 0.0
        and instrument.gain_error == 0.0
        and instrument.nonlinearity == 0.0
        and instrument.noise == 0.0
        and instrument.lag == 0.0
        and instrument.bits == 0
    )


@kernel
def saturated(value: float, span: float) -> float:
    """Limit a value to what the output can say; what is not a number stays none."""
    lowest = (LOWEST_OUTPUT - OUTPUT_LOW) / OUTPUT_SPAN * span
    highest = (HIGHEST_OUTPUT - OUTPUT_LOW) / OUTPUT_SPAN * span
    if value < lowest:
        return lowest
    if value > highest:
        return highest
    return value


def volts(value: float, span: float) -> float:
    """Return the output in V that stands for a value, in the unit of ``span``."""
    return OUTPUT_LOW + OUTPUT_SPAN * value / span


@kernel
def converted(value: float, span: float, bits: int) -> float:
    """Round to the steps of a converter of ``bits`` over ±10 V; 305 µV for 16 bits.

    What is not a finite number stays as it is.
    """
    if bits <= 0 or not math.isfinite(value):
        return value
    step = CONVERTER_SPAN / 2.0**bits
    volts = OUTPUT_LOW + OUTPUT_SPAN / span * value
    return (round(volts / step) * step - OUTPUT_LOW) * span / OUTPUT_SPAN


@kernel
def read(instrument: Transmitter, true: float, late: float, noise: float) -> float:
    """Return one reading of ``true``, which the lag shows as ``late``.

    ``noise`` is a standard normal number.
    """
    if is_ideal(instrument):
        return true
    seen = late * (1.0 + instrument.gain_error) + instrument.offset
    if instrument.nonlinearity != 0.0:
        seen += instrument.nonlinearity * math.sin(2.0 * math.pi * true / instrument.span)
    seen += instrument.noise * noise
    return converted(saturated(seen, instrument.span), instrument.span, instrument.bits)


@kernel
def read_all(instrument: Transmitter, values: Array, period: float, noise: Array) -> Array:
    """Return the readings of ``values`` with the noise of ``noise``; all of shape (n,)."""
    late = lagged(values, period, instrument.lag)
    readings = np.empty(values.size)
    for k in range(values.size):
        readings[k] = read(instrument, values[k], late[k], noise[k])
    return readings
