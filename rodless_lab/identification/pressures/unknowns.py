# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""What a run's pressures can be asked for: parameters of valve, chambers and leaks as unknowns."""

import math
from dataclasses import replace
from typing import Any

from rodless_base.constants import MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_lab.identification.pressures.problem import Model, Unknown, of_plant
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant

VOLUMES = ("cylinder.dead_volume_a", "cylinder.dead_volume_b")
GAP = "valve.gap_height"
CLOSED = "valve.closed_voltage"
AREA_FACTOR = "area factor"
HEAT_TRANSFER = "chambers.heat_transfer_coefficient"
POLYTROPIC = "chambers.polytropic_index"
LEAKS = ("leak.across", "leak.a", "leak.b")
FREQUENCY = "valve.natural_frequency"
DAMPING = "valve.damping"
HYSTERESIS = "valve.hysteresis"
DEAD_TIME = "valve.dead_time"
SPOOL_START = "start of the spool"
TIME_CONSTANT = "time constant of the spool"

# A spool whose time constant is this (s) follows at once: it moves between two steps of the model.
SHORTEST_TIME = 1e-7


def _of_part(name: str, parameters: RigParameters, scale: float, part: str, field: str) -> Unknown:
    """Return the parameter ``name``, which the plant has as ``field`` of its ``part``."""

    def apply(plant: Plant, value: float) -> Plant:
        changed: Any = getattr(plant, part)._replace(**{field: value})
        return plant._replace(**{part: changed})

    return Unknown.parameter(name, parameters, scale, of_plant(apply))


def dead_volumes(parameters: RigParameters) -> list[Unknown]:
    """Return both dead volumes."""
    return [
        _of_part(name, parameters, 1e-5, "cylinder", f"dead_volume_{side}")
        for name, side in zip(VOLUMES, "ab", strict=True)
    ]


def gap(parameters: RigParameters) -> Unknown:
    """Return the effective height of the valve's gaps."""
    return _of_part(GAP, parameters, 1e-6, "valve", "gap_height")


def closed_voltage(parameters: RigParameters) -> list[Unknown]:
    """Return the voltage at which the valve is closed."""
    return [_of_part(CLOSED, parameters, 0.1, "valve", "closed_voltage")]


def area_factor(parameters: RigParameters) -> list[Unknown]:  # noqa: ARG001
    """Return a factor on the whole area curve, eq. (5)."""

    def apply(plant: Plant, value: float) -> Plant:
        old = plant.valve.area_coefficients
        # Every third number, from the first, is the amplitude of a sine.
        new: Any = tuple(n if place % 3 else n * value for place, n in enumerate(old))
        return plant._replace(valve=plant.valve._replace(area_coefficients=new))

    return [Unknown(AREA_FACTOR, "", 1.0, 0.1, 0.05, 20.0, of_plant(apply))]


def heat_transfer(parameters: RigParameters) -> list[Unknown]:
    """Return the heat transfer coefficient of the chambers' walls."""
    return [_of_part(HEAT_TRANSFER, parameters, 10.0, "heat", "coefficient")]


def polytropic_index(parameters: RigParameters) -> list[Unknown]:
    """Return the exponent of polytropic chambers."""
    return [_of_part(POLYTROPIC, parameters, 0.1, "air", "chamber_index")]


def leak(name: str, parameters: RigParameters) -> Unknown:
    """Return the effective area of one of LEAKS."""

    def apply(plant: Plant, value: float) -> Plant:
        changed: dict[str, Any] = {"open": True, name.removeprefix("leak."): value}
        return plant._replace(leak=plant.leak._replace(**changed))

    return Unknown.parameter(name, parameters, 1e-9, of_plant(apply))


def _of_drive(name: str, parameters: RigParameters, scale: float, field: str, by: float) -> Unknown:
    """Return the parameter ``name``, which the drive has ``by`` times as ``field``."""

    def apply(model: Model, value: float) -> Model:
        changed: dict[str, Any] = {field: by * value}
        return model._replace(drive=model.drive._replace(**changed))

    return Unknown.parameter(name, parameters, scale, apply)


def spool_dynamics(parameters: RigParameters) -> list[Unknown]:
    """Return the natural frequency and the damping ratio of the spool."""
    frequency = _of_drive(FREQUENCY, parameters, 10.0, "natural_frequency", 2.0 * math.pi)
    return [frequency, spool_damping(parameters)]


def spool_damping(parameters: RigParameters) -> Unknown:
    """Return the damping ratio of the spool."""
    return _of_drive(DAMPING, parameters, 0.1, "damping", 1.0)


def time_constant(parameters: RigParameters) -> Unknown:
    """Return 1/ω of the spool, in s: the faster the spool, the nearer to 0."""

    def apply(model: Model, value: float) -> Model:
        frequency = 1.0 / max(value, SHORTEST_TIME)
        return model._replace(drive=model.drive._replace(natural_frequency=frequency))

    declared = RigParameters.DECLARATIONS[FREQUENCY]
    start, slowest, fastest = (
        1.0 / (2.0 * math.pi * frequency)
        for frequency in (parameters.number(FREQUENCY), declared.minimum, declared.maximum)
    )
    return Unknown(TIME_CONSTANT, "s", start, 1e-3, 0.0, slowest, apply, blur=fastest)


def hysteresis(parameters: RigParameters) -> list[Unknown]:
    """Return the width of the spool's hysteresis, and where in it the spool is at the start."""
    by = 0.5 * (MAXIMUM_VOLTAGE - MINIMUM_VOLTAGE)
    width = _of_drive(HYSTERESIS, parameters, 1e-3, "play", by)
    # At no hysteresis at all, nothing says where in it the spool is.
    return [replace(width, start=max(width.start, 1e-3)), spool_start()]


def spool_start() -> Unknown:
    """Return where the spool rests at the start, from where the first command would hold it."""

    def apply(model: Model, value: float) -> Model:
        return model._replace(spool_start=value)

    return Unknown(SPOOL_START, "V", 0.0, 0.01, -0.2, 0.2, apply)


def dead_time(parameters: RigParameters) -> Unknown:
    """Return how late a command reaches the valve."""

    def apply(model: Model, value: float) -> Model:
        return model._replace(dead_time=value)

    found = Unknown.parameter(DEAD_TIME, parameters, 1e-3, apply)
    return replace(found, start=max(found.start, 1e-3))
