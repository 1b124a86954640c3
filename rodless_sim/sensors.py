"""The rig's instruments: what they make of a true run. Section 2 and Table 1 of the paper.

Position KTC-V1-200, pressure MIK-P300, a volume-flow meter for sections 3.2 and 3.5, and the
16-bit converter all of them are read by. Ideal until the ``sensors.*`` parameters say otherwise;
:data:`DATA_SHEET` holds the values of the instruments the paper names.
"""

import math
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from rodless_sim.parameters import RigParameters
from rodless_sim.trace import Trace

Array = npt.NDArray[np.float64]

# Ranges that 1-5 V stand for (paper, Table 1): m, Pa; the converter's input range in V.
POSITION_RANGE = 0.2
PRESSURE_RANGE = 1e6
FLOW_RANGE = 200.0 / 6e4
OUTPUT_LOW = 1.0
OUTPUT_SPAN = 4.0
CONVERTER_SPAN = 20.0

# Noise is what a 16-bit NI card shows on these instruments; the flow meter is a judgement.
DATA_SHEET = MappingProxyType(
    {
        "sensors.position_noise": 20e-6,
        "sensors.position_linearity": 5e-4,
        "sensors.position_repeatability": 1e-5,
        "sensors.pressure_noise": 200.0,
        "sensors.pressure_bias": 5e-3,
        "sensors.pressure_lag": 5e-3,
        "sensors.flow_noise": 0.1 / 6e4,
        "sensors.flow_gain_error": 0.01,
        "sensors.converter_bits": 16,
    }
)


@dataclass(frozen=True)
class Transmitter:
    """One instrument with 1-5 V output, with the fixed errors of this specimen.

    ``span`` is what 4 V stand for, in the unit measured. ``bow`` (that unit) is the largest
    deviation from a straight line, over one wave along the range; ``offset`` and ``gain_error`` are
    constant, ``noise`` is the standard deviation of a sample, ``lag`` a time constant in s.
    ``bits`` of the converter: 0 means no rounding.
    """

    span: float
    offset: float = 0.0
    gain_error: float = 0.0
    bow: float = 0.0
    noise: float = 0.0
    lag: float = 0.0
    bits: int = 0

    def measure(self, values: Array, period: float, generator: np.random.Generator) -> Array:
        """Return what is read of the true ``values``, shape (n,), sampled every ``period`` s."""
        true = np.asarray(values, dtype=np.float64)
        seen = lagged(true, period, self.lag) * (1.0 + self.gain_error) + self.offset
        seen = seen + self.bow * np.sin(2.0 * math.pi * true / self.span)
        if self.noise:
            seen = seen + generator.normal(0.0, self.noise, true.shape)
        return converted(seen, self.span, self.bits)


def lagged(values: Array, period: float, lag: float) -> Array:
    """First-order lag of time constant ``lag`` (s), settled at the first sample; shape (n,)."""
    if lag <= 0.0 or not len(values):
        return values
    keep = math.exp(-period / lag)
    change = lfilter([0.0, 1.0 - keep], [1.0, -keep], values - values[0])
    return np.asarray(values[0] + change)


def converted(values: Array, span: float, bits: int) -> Array:
    """Round to the steps of a converter of ``bits`` over ±10 V; 305 µV for 16 bits."""
    if bits <= 0:
        return values
    step = CONVERTER_SPAN / 2**bits
    volts = OUTPUT_LOW + OUTPUT_SPAN / span * values
    return np.asarray((np.round(volts / step) * step - OUTPUT_LOW) * span / OUTPUT_SPAN)


@dataclass(frozen=True)
class Instruments:
    """All instruments of one rig, as drawn for one run."""

    position: Transmitter
    pressure_a: Transmitter
    pressure_b: Transmitter
    supply_pressure: Transmitter
    volume_flow: Transmitter

    @classmethod
    def drawn(cls, parameters: RigParameters, generator: np.random.Generator) -> "Instruments":
        """Draw the fixed errors of every instrument within the bounds ``parameters`` state."""

        def within(bound: float) -> float:
            return float(generator.uniform(-bound, bound)) if bound else 0.0

        number = parameters.number
        bits = int(number("sensors.converter_bits"))
        position = Transmitter(
            POSITION_RANGE,
            offset=within(number("sensors.position_repeatability")),
            bow=within(number("sensors.position_linearity") * POSITION_RANGE),
            noise=number("sensors.position_noise"),
            bits=bits,
        )
        pressure = Transmitter(
            PRESSURE_RANGE,
            noise=number("sensors.pressure_noise"),
            lag=number("sensors.pressure_lag"),
            bits=bits,
        )
        bias = number("sensors.pressure_bias") * PRESSURE_RANGE
        a, b, supply = (replace(pressure, offset=within(bias)) for _ in range(3))
        flow = Transmitter(
            FLOW_RANGE,
            gain_error=within(number("sensors.flow_gain_error")),
            noise=number("sensors.flow_noise"),
            bits=bits,
        )
        return cls(position, a, b, supply, flow)


def measured(
    trace: Trace,
    parameters: RigParameters,
    generator: np.random.Generator,
    instruments: Instruments | None = None,
) -> Trace:
    """Return ``trace`` as the instruments of ``parameters`` show it.

    ``generator`` draws the noise, and the instruments unless given. Time and voltage are known;
    force is A (P_a - P_b) of the readings; velocity and mass flows, which nothing on the rig
    measures, are NaN.
    """
    tools = instruments or Instruments.drawn(parameters, generator)
    period = float(trace.time[1] - trace.time[0]) if len(trace.time) > 1 else 1.0
    pressure_a = tools.pressure_a.measure(trace.pressure_a, period, generator)
    pressure_b = tools.pressure_b.measure(trace.pressure_b, period, generator)
    nothing = np.full(trace.time.shape, np.nan)
    area = math.pi / 4.0 * parameters.number("cylinder.bore") ** 2
    return Trace(
        time=trace.time,
        position=tools.position.measure(trace.position, period, generator),
        velocity=nothing,
        pressure_a=pressure_a,
        pressure_b=pressure_b,
        voltage=trace.voltage,
        force=area * (pressure_a - pressure_b),
        mass_flow_a=nothing,
        mass_flow_b=nothing,
    )
