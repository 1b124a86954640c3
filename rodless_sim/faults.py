# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Faults of the rig: what each is called, and what it does to plant, valve and readings.

Each is a parameter ``fault.*`` that does nothing at its default. Where the rig has what a fault
needs, such as a leak, the fault works on that.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from rodless_base.constants import CLOSED_VOLTAGE, MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare

if TYPE_CHECKING:
    from rodless_sim.physics.plant import Plant

FAULT = "fault, off by default"

# Effective area of a tube of 4 mm that is torn off: 12.6 mm² with a discharge coefficient of 0.8.
TORN_TUBE = 1e-5  # m²

# Twice that of a worn seal and more: of a piston whose seal is gone.
LARGEST_PISTON_LEAK = 1e-5  # m²

# What the instruments read, by field of Measurement: what of, unit, and the largest error.
READINGS = {
    "position": ("the position sensor", "m", 0.1),
    "pressure_a": ("the sensor of chamber A", "Pa", 1e6),
    "pressure_b": ("the sensor of chamber B", "Pa", 1e6),
    "supply_pressure": ("the supply's sensor", "Pa", 1e6),
}

WORKS, FROZEN, GONE = "works", "frozen", "gone"


def _of_sensor(field: str) -> tuple[Parameter, ...]:
    """Declare the faults of one instrument."""
    what, unit, largest = READINGS[field]
    states = f"{FROZEN}: {what} shows the last reading for ever; {GONE}: it reads NaN"
    name = f"fault.{field}"
    return (
        Parameter(f"{name}.sensor", WORKS, "", states, FAULT, choices=(WORKS, FROZEN, GONE)),
        Parameter(f"{name}.offset", 0.0, unit, f"offset of {what}", FAULT, -largest, largest),
        Parameter(
            f"{name}.noise",
            0.0,
            unit,
            f"further noise of {what}, standard deviation",
            FAULT,
            0.0,
            largest,
        ),
    )


PARAMETERS = declare(
    Parameter(
        "fault.valve.spool",
        "free",
        "",
        "stuck: the valve stays as it is, whatever the command; stuck_at: it stays at "
        "fault.valve.stuck_voltage",
        FAULT,
        choices=("free", "stuck", "stuck_at"),
    ),
    Parameter(
        "fault.valve.stuck_voltage",
        CLOSED_VOLTAGE,
        "V",
        "command at which the valve has stuck (stuck_at)",
        FAULT,
        MINIMUM_VOLTAGE,
        MAXIMUM_VOLTAGE,
    ),
    Parameter(
        "fault.valve.offset", 0.0, "V", "added to every command of the valve", FAULT, -10.0, 10.0
    ),
    Parameter(
        "fault.supply.loss",
        0.0,
        "",
        "share of its gauge pressure that the supply has lost; 1 is ambient pressure",
        FAULT,
        0.0,
        1.0,
    ),
    *(
        Parameter(
            f"fault.tube_{chamber}.burst",
            0.0,
            "m²",
            f"effective area of a hole in the tube of chamber {chamber.upper()}, beside leak."
            f"{chamber}; {TORN_TUBE:g} m² for a tube of 4 mm torn off",
            FAULT,
            0.0,
            TORN_TUBE,
        )
        for chamber in ("a", "b")
    ),
    Parameter(
        "fault.piston.leak",
        0.0,
        "m²",
        "effective area of a leak across the piston, beside leak.across",
        FAULT,
        0.0,
        LARGEST_PISTON_LEAK,
    ),
    Parameter(
        "fault.carriage.seized", False, "", "the carriage stays where it is at any force", FAULT
    ),
    Parameter(
        "fault.carriage.decoupled",
        False,
        "",
        "the magnets hold nothing: the piston leaves the carriage behind (coupling.kind magnetic)",
        FAULT,
    ),
    *(parameter for field in READINGS for parameter in _of_sensor(field)),
)


def active(parameters: ParameterSet) -> dict[str, str]:
    """Return the faults that are not at their default, each value with its unit as a text."""
    found = {
        name: _text(parameters, name)
        for name, declared in PARAMETERS.items()
        if parameters[name] != declared.default and name != "fault.valve.stuck_voltage"
    }
    if found.get("fault.valve.spool") == "stuck_at":
        found["fault.valve.spool"] = f"stuck at {_text(parameters, 'fault.valve.stuck_voltage')}"
    return found


def _text(parameters: ParameterSet, name: str) -> str:
    value, unit = parameters[name], PARAMETERS[name].unit
    text = f"{value:g}" if isinstance(value, float) else str(value).lower()
    return f"{text} {unit}".rstrip()


def cleared() -> dict[str, object]:
    """Return the values of a rig without any fault, by name.

    Examples
    --------
    >>> from rodless_sim import RigParameters
    >>> broken = RigParameters({"fault.valve.offset": 0.2})
    >>> broken.with_values(cleared()) == RigParameters()
    True
    """
    return {name: declared.default for name, declared in PARAMETERS.items()}


def check(parameters: ParameterSet) -> None:
    """Refuse magnets that let go where there are none."""
    if parameters["fault.carriage.decoupled"] and parameters.text("coupling.kind") != "magnetic":
        raise ParameterError(
            "fault.carriage.decoupled: true refused, coupling.kind is "
            f"{parameters.text('coupling.kind')}; start the rig with magnetic"
        )


def damaged(plant: "Plant", parameters: ParameterSet) -> "Plant":
    """Return ``plant`` with the faults that are in its air and on its carriage."""
    number = parameters.number
    across, a, b = (
        number(f"fault.{name}") for name in ("piston.leak", "tube_a.burst", "tube_b.burst")
    )
    loss, seized = number("fault.supply.loss"), bool(parameters["fault.carriage.seized"])
    leak, cylinder, full = plant.leak, plant.cylinder, plant.full
    if parameters["fault.carriage.decoupled"]:
        full = full._replace(coupling=full.coupling._replace(broken=True))
    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    # Not P_e + (1 - loss)(P_s - P_e): without loss, the supply's pressure has its own bits.
    left = supply - loss * (supply - ambient)
    ripple = plant.ripple
    if full:
        full = full._replace(supply=full.supply._replace(set_pressure=left, loss=loss))
    if ripple:
        ripple = ripple._replace(amplitude=(1.0 - loss) * ripple.amplitude)
    return plant._replace(
        leak=leak._replace(
            open=leak.open or across + a + b > 0.0,
            across=leak.across + across,
            a=leak.a + a,
            b=leak.b + b,
        ),
        cylinder=cylinder._replace(locked=cylinder.locked or seized),
        supply_pressure=left,
        full=full,
        ripple=ripple,
    )


class ValveFault(NamedTuple):
    """What is wrong with the valve."""

    stuck: bool
    stuck_voltage: float | None  # V; None for where it was
    offset: float  # V

    @classmethod
    def of(cls, parameters: ParameterSet) -> "ValveFault":
        """Return the faults of the valve for ``parameters``."""
        spool = parameters.text("fault.valve.spool")
        at = parameters.number("fault.valve.stuck_voltage") if spool == "stuck_at" else None
        return cls(spool != "free", at, parameters.number("fault.valve.offset"))

    @property
    def present(self) -> bool:
        """Whether anything is."""
        return self.stuck or self.offset != 0.0

    @property
    def stays(self) -> bool:
        """Whether the spool has stuck where it was."""
        return self.stuck and self.stuck_voltage is None

    def voltage(self, command: float, before: float) -> float:
        """Return the voltage (V) that the valve follows at ``command``, after ``before``."""
        if self.stuck:
            return before if self.stuck_voltage is None else self.stuck_voltage
        if self.offset == 0.0:
            return command
        return min(max(command + self.offset, MINIMUM_VOLTAGE), MAXIMUM_VOLTAGE)


def sensor_states(parameters: ParameterSet) -> Mapping[str, str]:
    """Return the readings that do not follow what is measured: frozen or gone, by field."""
    states = {field: parameters.text(f"fault.{field}.sensor") for field in READINGS}
    return {field: state for field, state in states.items() if state != WORKS}
