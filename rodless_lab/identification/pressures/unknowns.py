# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""What a run's pressures can be asked for: parameters of valve, chambers and leaks as unknowns."""

from typing import Any

from rodless_lab.identification.pressures.problem import Unknown, of_plant
from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant

VOLUMES = ("cylinder.dead_volume_a", "cylinder.dead_volume_b")
GAP = "valve.gap_height"
CLOSED = "valve.closed_voltage"
AREA_FACTOR = "area factor"
HEAT_TRANSFER = "chambers.heat_transfer_coefficient"
POLYTROPIC = "chambers.polytropic_index"


def _of_part(name: str, parameters: RigParameters, scale: float, part: str, field: str) -> Unknown:
    """Return the parameter ``name``, which the plant has as ``field`` of its ``part``."""

    def apply(plant: Plant, value: float) -> Plant:
        changed: Any = getattr(plant, part)._replace(**{field: value})
        return plant._replace(**{part: changed})

    return Unknown.parameter(name, parameters, scale, apply)


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


def leak(parameters: RigParameters, where: str) -> Unknown:
    """Return the effective area of the leak ``where``: across, a or b."""

    def apply(plant: Plant, value: float) -> Plant:
        changed: dict[str, Any] = {"open": True, where: value}
        return plant._replace(leak=plant.leak._replace(**changed))

    return Unknown.parameter(f"leak.{where}", parameters, 1e-9, apply)
