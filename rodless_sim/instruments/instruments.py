# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig's instruments: models that turn true values into readings.

Position KTC-V1-200, pressure MIK-P300, a volume-flow meter for sections 3.2 and 3.5, and the
16-bit converter all of them are read by: section 2 and Table 1 of the paper. Ideal until the
``sensors.*`` parameters say otherwise, each by itself, and then no wider than its range;
:data:`DATA_SHEET` holds those of the instruments the paper names, :data:`IDEAL` those of none
(``config/sensors``).
"""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.kernels import kernel
from rodless_base.measurement import Measurement
from rodless_base.one_line import shown
from rodless_base.parameter_file import preset_directory, read_parameter_file
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_sim.instruments.transmitter import Transmitter, followed, read, volts
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.full_rates import supply_at_valve
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.sources import JUDGEMENT, PAPER
from rodless_sim.physics.state import AnyMotion
from rodless_sim.physics.timed import now_supplied
from rodless_sim.trace import Trace

Array = npt.NDArray[np.float64]

# Ranges that 1-5 V stand for (paper, Table 1).
POSITION_RANGE = 0.2  # m
PRESSURE_RANGE = 1e6  # Pa
FLOW_RANGE = 200.0 / 6e4  # m³/s

PARAMETERS = declare(
    Parameter(
        "sensors.position_noise",
        0.0,
        "m",
        "noise of the position sensor, standard deviation",
        f"{JUDGEMENT}: 20 µm",
        0.0,
        1e-2,
    ),
    Parameter(
        "sensors.position_linearity",
        0.0,
        "",
        "largest nonlinearity of the position sensor, share of its range",
        f"{PAPER}, Table 1: 0.05 %",
        0.0,
        0.05,
    ),
    Parameter(
        "sensors.position_repeatability",
        0.0,
        "m",
        "largest offset of the position sensor in a run",
        f"{PAPER}, Table 1: 0.01 mm",
        0.0,
        1e-2,
    ),
    Parameter(
        "sensors.pressure_noise",
        0.0,
        "Pa",
        "noise of the pressure sensors, standard deviation",
        f"{JUDGEMENT}: 200 Pa",
        0.0,
        1e5,
    ),
    Parameter(
        "sensors.pressure_bias",
        0.0,
        "",
        "largest bias of a pressure sensor, share of its range",
        f"{PAPER}, Table 1: 0.5 %",
        0.0,
        0.1,
    ),
    Parameter(
        "sensors.pressure_lag",
        0.0,
        "s",
        "time constant of the pressure sensors",
        f"{JUDGEMENT}: 5 ms",
        0.0,
        1.0,
    ),
    Parameter(
        "sensors.flow_noise",
        0.0,
        "m³/s",
        "noise of the volume-flow meter, standard deviation",
        f"{JUDGEMENT}: 0.1 L/min",
        0.0,
        1e-3,
        in_runs=False,
    ),
    Parameter(
        "sensors.flow_gain_error",
        0.0,
        "",
        "largest error of the volume-flow meter, share of the reading",
        f"{JUDGEMENT}: 1 %",
        0.0,
        0.1,
        in_runs=False,
    ),
    Parameter(
        "sensors.converter_bits",
        0,
        "",
        "bits of the converter over ±10 V, 0 for no rounding",
        f"{PAPER}, section 2: 16",
        0.0,
        24.0,
    ),
    Parameter(
        "sensors.seed",
        1,
        "",
        "draws the fixed errors of the sensors and, from each reset on, their noise",
        "interface",
        0,
        2**31 - 1,
    ),
)


def _of_file(name: str) -> Mapping[str, object]:
    return MappingProxyType(
        read_parameter_file(preset_directory() / "sensors" / f"{name}.yaml", "plant")
    )


IDEAL, DATA_SHEET = _of_file("ideal"), _of_file("data_sheet")

# In the words of the command line, in place of a preset's instruments.
SENSORS = MappingProxyType({"ideal": IDEAL, "data-sheet": DATA_SHEET})


def sensors_of(choice: str) -> Mapping[str, object]:
    """Return what one of :data:`SENSORS` sets, nothing for ``base``; raises ValueError."""
    if choice not in ("base", *SENSORS):
        raise ValueError(f"{shown(choice)} refused, must be base, {' or '.join(SENSORS)}")
    return SENSORS.get(choice, {})


def position_range(parameters: ParameterSet) -> float:
    """Return the range of the position sensor in m: a longer cylinder has a longer one."""
    return max(POSITION_RANGE, parameters.number("cylinder.stroke"))


class Instruments(NamedTuple):
    """All instruments of one rig, with the fixed errors of these specimens."""

    position: Transmitter
    pressure_a: Transmitter
    pressure_b: Transmitter
    supply_pressure: Transmitter
    volume_flow: Transmitter

    @classmethod
    def specimen(cls, parameters: ParameterSet, generator: np.random.Generator) -> "Instruments":
        """Choose the fixed errors of every instrument, within the bounds ``parameters`` state."""

        def within(bound: float) -> float:
            return bound * float(generator.uniform(-1.0, 1.0))

        def fault(field: str, what: str) -> float:
            return number(f"fault.{field}.{what}")

        number = parameters.number
        bits = int(number("sensors.converter_bits"))
        reach = position_range(parameters)
        position = Transmitter(
            reach,
            offset=within(number("sensors.position_repeatability")) + fault("position", "offset"),
            nonlinearity=within(number("sensors.position_linearity") * reach),
            noise=math.hypot(number("sensors.position_noise"), fault("position", "noise")),
            bits=bits,
        )
        pressure = Transmitter(PRESSURE_RANGE, lag=number("sensors.pressure_lag"), bits=bits)
        bias = number("sensors.pressure_bias") * PRESSURE_RANGE
        a, b, supply = (
            pressure._replace(
                offset=within(bias) + fault(field, "offset"),
                noise=math.hypot(number("sensors.pressure_noise"), fault(field, "noise")),
            )
            for field in Measurement._fields[2:]
        )
        flow = Transmitter(
            FLOW_RANGE,
            gain_error=within(number("sensors.flow_gain_error")),
            noise=number("sensors.flow_noise"),
            bits=bits,
        )
        return cls(position, a, b, supply, flow)


def raw_voltages(instruments: Instruments, seen: Measurement) -> tuple[float, ...]:
    """Return the voltages (V) at the converter that the readings ``seen`` stand for, in order."""
    return tuple(
        volts(value, tool.span) for value, tool in zip(seen[1:], instruments[:4], strict=True)
    )


class Lags(NamedTuple):
    """What the instruments' lags remember of the sample before: the truth, and what they showed."""

    true: Measurement
    late: Measurement


@kernel
def truth(plant: Plant, stamp: int, state: AnyMotion) -> Measurement:
    """Return what instruments without errors would read at ``stamp`` (ns)."""
    supply = supply_at_valve(now_supplied(plant, stamp * SECONDS_PER_NANOSECOND), state)
    return Measurement(stamp, state.position, state.pressure_a, state.pressure_b, supply)


@kernel
def read_rig(
    instruments: Instruments, before: Lags, true: Measurement, noise: Array
) -> tuple[Measurement, Lags]:
    """Read the instruments at the stamp of ``true``, after the sample ``before``.

    ``noise``, shape (4,), are standard normal numbers. For the first sample ``before`` is
    ``Lags(true, true)``.
    """
    period = (true.stamp - before.true.stamp) * SECONDS_PER_NANOSECOND
    position, a, b, supply, _ = instruments
    late = Measurement(
        true.stamp,
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
    readings = Measurement(
        true.stamp,
        read(position, true.position, late.position, noise[0]),
        read(a, true.pressure_a, late.pressure_a, noise[1]),
        read(b, true.pressure_b, late.pressure_b, noise[2]),
        read(supply, true.supply_pressure, late.supply_pressure, noise[3]),
    )
    return readings, Lags(true, late)


def read_trace(
    trace: Trace,
    parameters: ParameterSet,
    generator: np.random.Generator,
    instruments: Instruments | None = None,
) -> Trace:
    """Return ``trace`` as the instruments of ``parameters`` show it.

    The noise comes from ``generator``, and so do the instruments unless given. Time and voltage
    are known; force is A (P_a - P_b) of the readings; velocity and mass flows, which nothing on
    the rig measures, are NaN.
    """
    tools = instruments or Instruments.specimen(parameters, generator)
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
