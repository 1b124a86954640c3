"""The rig's instruments: what they make of a true run. Section 2 and Table 1 of the paper.

Position KTC-V1-200, pressure MIK-P300, a volume-flow meter for sections 3.2 and 3.5, and the
16-bit converter all of them are read by. Ideal until the ``sensors.*`` parameters say otherwise;
:data:`DATA_SHEET` holds those of the instruments the paper names (``config/sensors``).
"""

from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_base.parameter_file import preset_directory, read_parameter_file
from rodless_sim.instruments.transmitter import Transmitter, followed, read
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.plant import piston_area
from rodless_sim.trace import Trace

Array = npt.NDArray[np.float64]

# Ranges that 1-5 V stand for (paper, Table 1): m, Pa.
POSITION_RANGE = 0.2
PRESSURE_RANGE = 1e6
FLOW_RANGE = 200.0 / 6e4

DATA_SHEET = MappingProxyType(
    read_parameter_file(preset_directory() / "sensors" / "data_sheet.yaml", "plant")
)


class Readings(NamedTuple):
    """One sample of what the rig measures, true or read: m, and Pa absolute."""

    position: float
    pressure_a: float
    pressure_b: float
    supply_pressure: float


class Instruments(NamedTuple):
    """All instruments of one rig, with the fixed errors of these specimens."""

    position: Transmitter
    pressure_a: Transmitter
    pressure_b: Transmitter
    supply_pressure: Transmitter
    volume_flow: Transmitter

    @classmethod
    def drawn(cls, parameters: RigParameters, generator: np.random.Generator) -> "Instruments":
        """Draw the fixed errors of every instrument within the bounds ``parameters`` state."""

        def within(bound: float) -> float:
            return bound * float(generator.uniform(-1.0, 1.0))

        number = parameters.number
        bits = int(number("sensors.converter_bits"))
        position = Transmitter(
            POSITION_RANGE,
            offset=within(number("sensors.position_repeatability")),
            nonlinearity=within(number("sensors.position_linearity") * POSITION_RANGE),
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
        a, b, supply = (pressure._replace(offset=within(bias)) for _ in range(3))
        flow = Transmitter(
            FLOW_RANGE,
            gain_error=within(number("sensors.flow_gain_error")),
            noise=number("sensors.flow_noise"),
            bits=bits,
        )
        return cls(position, a, b, supply, flow)


class Lags(NamedTuple):
    """What the instruments' lags remember of the sample before: the truth, and what they showed."""

    true: Readings
    late: Readings


@kernel
def read_rig(
    instruments: Instruments, before: Lags, true: Readings, period: float, noise: Array
) -> tuple[Readings, Lags]:
    """Read the instruments ``period`` s after the sample ``before``; ``noise``, shape (4,).

    For the first sample ``before`` is ``Lags(true, true)`` and ``period`` 0.
    """
    position, a, b, supply, _ = instruments
    late = Readings(
        followed(before.late.position, before.true.position, true.position, period, position.lag),
        followed(before.late.pressure_a, before.true.pressure_a, true.pressure_a, period, a.lag),
        followed(before.late.pressure_b, before.true.pressure_b, true.pressure_b, period, b.lag),
        followed(
            before.late.supply_pressure,
            before.true.supply_pressure,
            true.supply_pressure,
            period,
            supply.lag,
        ),
    )
    readings = Readings(
        read(position, true.position, late.position, noise[0]),
        read(a, true.pressure_a, late.pressure_a, noise[1]),
        read(b, true.pressure_b, late.pressure_b, noise[2]),
        read(supply, true.supply_pressure, late.supply_pressure, noise[3]),
    )
    return readings, Lags(true, late)


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
    area = piston_area(parameters)
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
