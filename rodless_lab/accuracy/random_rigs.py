# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Random rigs and what is done with them, each known by its number alone.

A third is drawn around the preset ``paper``, a third around ``saturating`` of
:mod:`rodless_lab.bare_rigs`: every number between half and twice its value. The last third takes
every parameter of the physics from its whole declared range at once: 5 mm of bore with a mass of
100 kg, dead volumes a thousand times the usual, friction of 10 kN.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.constants import CLOSED_VOLTAGE, MAXIMUM_VOLTAGE, MINIMUM_VOLTAGE
from rodless_base.parameters import Parameter, ParameterError
from rodless_control import PidParameters, references
from rodless_control.references import Reference
from rodless_lab.bare_rigs import BARE_RIGS, bare_pid, bare_rig
from rodless_sim import RigParameters
from rodless_sim.physics.air import critical_ratio
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.valve import scaled_amplitudes

Array = npt.NDArray[np.float64]

WHOLE_RANGE = "whole range"
PERIOD = 1e-3  # s
DURATION = 1.2  # s
RANGE = MINIMUM_VOLTAGE, MAXIMUM_VOLTAGE  # V

# What is drawn: the paper's physics, and nothing that a newer option declares, so that each number
# stays the same rig. A locked carriage stays where it is, the start is drawn by itself, and the
# critical ratio follows from the isentropic index.
DRAWN = (
    "supply.pressure",
    "supply.temperature",
    "atmosphere.pressure",
    "atmosphere.temperature",
    "air.gas_constant",
    "air.isentropic_index",
    "air.viscosity",
    "valve.assembly",
    "valve.gap_fade_voltage",
    "valve.closed_voltage",
    "valve.curve_centre",
    "valve.area_coefficients",
    "valve.flow_coefficients",
    "valve.spool_diameter",
    "valve.sleeve_diameter",
    "valve.gap_length",
    "valve.gap_height",
    "cylinder.bore",
    "cylinder.stroke",
    "cylinder.moving_mass",
    "cylinder.dead_volume_a",
    "cylinder.dead_volume_b",
    "end_stop.restitution",
    "friction.form",
    "friction.forward.static",
    "friction.forward.coulomb",
    "friction.forward.stribeck_velocity",
    "friction.forward.viscous",
    "friction.reverse.static",
    "friction.reverse.coulomb",
    "friction.reverse.stribeck_velocity",
    "friction.reverse.viscous",
    "friction.high_speed_viscous",
    "friction.saturation_velocity",
    "friction.capture_velocity",
)
# Measured curves. Drawn number by number they are no valve's: done for half of the rigs.
AREA = "valve.area_coefficients"
CURVES = (AREA, "valve.flow_coefficients")
# How many decades below its maximum a value is drawn whose least is zero.
DECADES = 5.0

# Around what cases are, in turn, and how each of them is driven, in turn.
NEIGHBOURHOODS = (*BARE_RIGS[::-1], WHOLE_RANGE)
OPEN_LOOP, CLOSED_LOOP = "open loop", "closed loop"


class Case(NamedTuple):
    """A rig and its task: voltages in open loop, or a reference in closed loop."""

    number: int
    around: str  # one of BARE_RIGS, or WHOLE_RANGE
    parameters: RigParameters
    position: float  # m, at the start
    voltages: Array | None  # V, one for each period
    law: PidParameters | None
    reference: Reference | None

    @property
    def drive(self) -> str:
        """Open loop or closed loop."""
        return CLOSED_LOOP if self.voltages is None else OPEN_LOOP


def neighbourhood_and_drive(number: int) -> tuple[str, str]:
    """Return around which rig case ``number`` is, and how it is driven."""
    driven, around = divmod(number, len(NEIGHBOURHOODS))
    return NEIGHBOURHOODS[around], (OPEN_LOOP, CLOSED_LOOP)[driven % 2]


def case(number: int) -> Case:
    """Return case ``number``: the same each time."""
    generator = np.random.default_rng([20220211, number])
    around, drive = neighbourhood_and_drive(number)
    parameters = drawn_rig(generator, around)
    position = parameters.number("cylinder.stroke") * _share_of_stroke(generator)
    if drive == OPEN_LOOP:
        return Case(number, around, parameters, position, drawn_voltages(generator), None, None)
    law = drawn_law(generator, around)
    reference = drawn_reference(generator, parameters.number("cylinder.stroke"), position)
    return Case(number, around, parameters, position, None, law, reference)


def drawn_rig(generator: np.random.Generator, around: str) -> RigParameters:
    """Return a random rig; what is no rig is drawn anew."""
    while True:
        try:
            found = _drawn_rig(generator, around)
        except ParameterError:
            continue
        if _can_move(found):
            return found


def _drawn_rig(generator: np.random.Generator, around: str) -> RigParameters:
    if around == WHOLE_RANGE:
        return RigParameters(_from_whole_range(generator))
    rig = bare_rig(around)
    return rig.with_values(_nearby(generator, rig))


def _can_move(parameters: RigParameters) -> bool:
    """Whether the supply can break the carriage away: the others teach nothing about motion."""
    push = parameters.number("supply.pressure") - parameters.number("atmosphere.pressure")
    static = min(parameters.number(f"friction.{side}.static") for side in ("forward", "reverse"))
    return push * piston_area(parameters) > static


def _drawn_parameters() -> list[Parameter]:
    return [RigParameters.DECLARATIONS[name] for name in DRAWN]


def _from_whole_range(generator: np.random.Generator) -> dict[str, object]:
    with_curves = generator.random() < 0.5
    values: dict[str, object] = {}
    for parameter in _drawn_parameters():
        if parameter.name in CURVES and not with_curves:
            continue
        values[parameter.name] = _within_range(generator, parameter)
    values["air.critical_ratio"] = critical_ratio(float(str(values["air.isentropic_index"])))
    return _ordered(values)


def _ordered(values: dict[str, object]) -> dict[str, object]:
    """Exchange values of which the second must not be below the first."""
    pairs = (
        ("friction.forward.coulomb", "friction.forward.static"),
        ("friction.reverse.coulomb", "friction.reverse.static"),
        ("atmosphere.pressure", "supply.pressure"),
        ("valve.spool_diameter", "valve.sleeve_diameter"),
    )
    for low, high in pairs:
        if low not in values:
            continue
        one, other = float(str(values[low])), float(str(values[high]))
        values[low], values[high] = min(one, other), max(one, other)
    return values


def _within_range(generator: np.random.Generator, parameter: Parameter) -> object:
    if parameter.choices:
        return str(generator.choice(parameter.choices))
    low, high = parameter.minimum, parameter.maximum
    if isinstance(parameter.default, tuple):
        drawn = tuple(
            float(generator.choice([-1.0, 1.0])) * high * 10.0 ** -generator.uniform(0.0, DECADES)
            for _ in parameter.default
        )
        # Amplitudes in mm²: their declared range is that of the angles.
        return scaled_amplitudes(drawn, -6) if parameter.name == AREA else drawn
    if low == 0.0:
        # Nothing at all is a value of its own.
        share = 0.0 if generator.random() < 0.1 else 10.0 ** -generator.uniform(0.0, DECADES)
        return high * share
    if high / low > 10.0:
        return low * (high / low) ** generator.random()
    return float(generator.uniform(low, high))


def _nearby(generator: np.random.Generator, rig: Mapping[str, object]) -> dict[str, object]:
    values: dict[str, object] = {}
    for parameter in _drawn_parameters():
        value = rig[parameter.name]
        if isinstance(value, float) and not parameter.name.startswith(("air.", "atmosphere.")):
            spread = 0.1 if parameter.unit in ("V", "K") else 1.0
            drawn = value * 2.0 ** generator.uniform(-spread, spread)
            values[parameter.name] = min(max(drawn, parameter.minimum), parameter.maximum)
    # The printed assembly's gap grows with the third power of the play.
    values["valve.sleeve_diameter"] = float(str(values["valve.spool_diameter"])) + 23e-6 * float(
        2.0 ** generator.uniform(-1.0, 1.0)
    )
    values["valve.assembly"] = str(generator.choice(["reconciled", "reconciled", "printed"]))
    return _ordered(values)


def _share_of_stroke(generator: np.random.Generator) -> float:
    """At an end as often as anywhere else that is rare by itself."""
    kind = generator.random()
    return 0.0 if kind < 0.1 else 1.0 if kind < 0.2 else float(generator.random())


def drawn_voltages(generator: np.random.Generator) -> Array:
    """Return steps held for 50 to 300 ms: half of them within 1 V of closed, where it creeps."""
    voltages: list[Array] = []
    left = round(DURATION / PERIOD)
    while left > 0:
        length = min(int(generator.integers(50, 300)), left)
        near = generator.random() < 0.5
        voltage = generator.normal(CLOSED_VOLTAGE, 0.5) if near else generator.uniform(*RANGE)
        voltages.append(np.full(length, np.clip(voltage, *RANGE)))
        left -= length
    return np.concatenate(voltages)


def drawn_law(generator: np.random.Generator, around: str) -> PidParameters:
    """Return gains between half and twice a rig's."""
    tuned = bare_pid(around)
    gains = ("controller.kp", "controller.ki", "controller.kd", "controller.feedforward")
    return tuned.with_values(
        {name: tuned.number(name) * 2.0 ** generator.uniform(-1.0, 1.0) for name in gains}
    )


def drawn_reference(generator: np.random.Generator, stroke: float, position: float) -> Reference:
    """Return a step or a sine within the stroke."""
    if generator.random() < 0.5:
        return references.step(position, stroke * float(generator.random()), at=0.1)
    amplitude = 0.5 * stroke * float(generator.random())
    centre = float(generator.uniform(amplitude, stroke - amplitude))
    return references.sine(centre, amplitude, float(generator.uniform(0.2, 3.0)), at=0.1)
