# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which parameters pages offer, in which groups; another panel is another entry.

A field is shown where a running node has its parameter: of the laws, that of the one in force.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from rodless_control.laws import LAWS
from rodless_control.parameters import LAW
from rodless_sim.physics.coupling import MAGNETIC


@dataclass(frozen=True)
class Field:
    """A slider: one of ``unit`` is ``scale`` of the parameter's own; bounds are in ``unit``."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    scale: float = 1.0
    offset: float = 0.0  # in the parameter's unit, of what is shown as 0

    def shown(self, value: float) -> float:
        """Return a parameter's value in ``unit``."""
        return round((value - self.offset) / self.scale, 6)

    def own(self, value: float) -> float:
        """Return what is shown as ``value`` in the parameter's unit, to twelve digits."""
        return float(f"{self.offset + value * self.scale:.12g}")


@dataclass(frozen=True)
class Choice:
    """One of several values, each with what the page calls it."""

    name: str
    label: str
    options: Mapping[str, str] | Mapping[bool, str]
    where: tuple[str, object] | None = None  # shown where this parameter has this value


@dataclass(frozen=True)
class Panel:
    """A group of fields under a title."""

    title: str
    fields: tuple[Field | Choice, ...]
    is_open: bool = False  # from the start


def _sensor(name: str, label: str) -> Choice:
    states = {"works": "works", "frozen": "frozen", "gone": "gone: reads nothing"}
    return Choice(f"fault.{name}.sensor", label, states)


PANELS = (
    Panel(
        "Control law",
        (
            Choice(LAW, "Law", {law: law.replace("_", " ") for law in LAWS} | {"pid": "PID"}),
            Field("controller.kp", "Proportional", "V/m", 0.0, 5000.0, 10.0),
            Field("controller.ki", "Integral", "V/(m·s)", 0.0, 500.0, 5.0),
            Field("controller.kd", "Derivative", "V·s/m", 0.0, 200.0, 1.0),
            Field("controller.feedforward", "Feed-forward", "V·s/m", 0.0, 200.0, 1.0),
            Field("state_feedback.position_gain", "Position", "V/m", 0.0, 10000.0, 10.0),
            Field("state_feedback.velocity_gain", "Velocity", "V·s/m", 0.0, 300.0, 1.0),
            Field("state_feedback.integral_gain", "Integral", "V/(m·s)", 0.0, 500.0, 1.0),
            Field("state_feedback.pressure_damping", "Pressure", "V/MPa", 0.0, 10.0, 0.05, 1e-6),
            Field("cascade.position_gain", "Position", "1/s²", 0.0, 20000.0, 10.0),
            Field("cascade.velocity_gain", "Velocity", "1/s", 0.0, 500.0, 1.0),
            Field("cascade.force_gain", "Force", "1/s", 0.0, 500.0, 1.0),
            Field("cascade.rejection", "Disturbance rejected", "%", 0.0, 100.0, 1.0, 1e-2),
            Field("mode_switching.rest_time", "Rest before the PID", "s", 0.0, 1.0, 0.01),
            Field("sliding_mode.surface_bandwidth", "Surface", "rad/s", 1.0, 200.0, 1.0),
            Field("sliding_mode.reaching_voltage", "Reaching", "V", 0.0, 10.0, 0.1),
            Field("sliding_mode.boundary_layer", "Boundary layer", "mm", 0.01, 10.0, 0.01, 1e-3),
            Field("adrc.bandwidth", "Bandwidth", "rad/s", 1.0, 200.0, 0.1),
            Field("adrc.input_gain", "Input gain", "m/(s²·V)", 0.1, 100.0, 0.01),
        ),
        is_open=True,
    ),
    Panel(
        "Supply and load",
        (
            Field("supply.pressure", "Supply, absolute", "kPa", 50.0, 1200.0, 5.0, 1e3),
            Field("cylinder.moving_mass", "Moving mass", "kg", 0.5, 20.0, 0.1),
        ),
        is_open=True,
    ),
    Panel(
        "Friction",
        (
            Field("friction.forward.static", "Static, forward", "N", 0.0, 100.0, 1.0),
            Field("friction.reverse.static", "Static, reverse", "N", 0.0, 100.0, 1.0),
            Field("friction.forward.coulomb", "Coulomb, forward", "N", 0.0, 100.0, 0.5),
            Field("friction.reverse.coulomb", "Coulomb, reverse", "N", 0.0, 100.0, 0.5),
            Field("friction.forward.viscous", "Viscous, forward", "N·s/m", 0.0, 8000.0, 50.0),
            Field("friction.reverse.viscous", "Viscous, reverse", "N·s/m", 0.0, 8000.0, 50.0),
        ),
    ),
    Panel(
        "Faults",
        (
            Choice(
                "fault.valve.spool",
                "Spool",
                {"free": "free", "stuck": "stuck where it is", "stuck_at": "stuck at this voltage"},
            ),
            Field("fault.valve.stuck_voltage", "Stuck at", "V", 0.0, 10.0, 0.05),
            Choice("fault.carriage.seized", "Carriage", {False: "free", True: "seized"}),
            Choice(
                "fault.carriage.decoupled",
                "Magnets of the carriage",
                {False: "hold", True: "let go"},
                ("coupling.kind", MAGNETIC),
            ),
            _sensor("position", "Position sensor"),
            _sensor("pressure_a", "Sensor of chamber A"),
            _sensor("pressure_b", "Sensor of chamber B"),
            _sensor("supply_pressure", "Sensor of the supply"),
            Field("fault.valve.offset", "Valve offset", "V", -2.0, 2.0, 0.05),
            Field("fault.supply.loss", "Supply lost", "%", 0.0, 100.0, 1.0, 1e-2),
            Field("fault.piston.leak", "Leak across the piston", "mm²", 0.0, 10.0, 0.1, 1e-6),
            Field("fault.tube_a.burst", "Hole in the tube of A", "mm²", 0.0, 10.0, 0.1, 1e-6),
            Field("fault.tube_b.burst", "Hole in the tube of B", "mm²", 0.0, 10.0, 0.1, 1e-6),
            Field("fault.position.offset", "Position sensor, offset", "mm", -10.0, 10.0, 0.1, 1e-3),
            Field("fault.position.noise", "Position sensor, noise", "mm", 0.0, 1.0, 0.01, 1e-3),
        ),
    ),
)

# What each reference type is given beside its name; lengths in mm.
_VELOCITY = Field("reference.velocity", "Velocity", "mm/s", 1.0, 500.0, 1.0, 1e-3)
REFERENCES: dict[str, tuple[Field, ...]] = {
    "setpoint": (),
    "ramp": (_VELOCITY,),
    "move": (
        _VELOCITY,
        Field("reference.acceleration", "Acceleration", "mm/s²", 10.0, 5000.0, 10.0, 1e-3),
    ),
    "step": (
        Field("reference.start", "From", "mm", 0.0, 200.0, 1.0, 1e-3),
        Field("reference.target", "To", "mm", 0.0, 200.0, 1.0, 1e-3),
    ),
    "sine": (
        Field("reference.centre", "Centre", "mm", 0.0, 200.0, 1.0, 1e-3),
        Field("reference.amplitude", "Amplitude", "mm", 0.0, 100.0, 1.0, 1e-3),
        Field("reference.frequency", "Frequency", "Hz", 0.01, 5.0, 0.01),
    ),
}

# Those that begin at a plant time of their own, reference.at.
TIMED = ("step", "sine")
