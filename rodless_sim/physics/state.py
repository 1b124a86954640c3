# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rig's states, each with unit and meaning: traces, records and docs follow from this list.

A rig has the states that its options need. A plant whose chambers have temperatures of their own
moves as :class:`HeatedMotion`; one with an option that needs more than that as :class:`FullMotion`,
which has the states of all of them. Which of the three a state is, is known when the equations are
compiled: what differs between them is a version of its own. Which states of a full motion act is
known when it runs: :mod:`rodless_sim.physics.full`.
"""

from collections.abc import Sequence
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, cast

from rodless_base.columns import quantities
from rodless_base.kernels import kernel, kernel_by_type, version_for

Position = Annotated[float, "m", "position of the carriage, 0 at chamber A's end"]
Velocity = Annotated[float, "m/s", "velocity of the carriage, positive toward chamber B's end"]
PressureA = Annotated[float, "Pa", "absolute pressure in chamber A"]
PressureB = Annotated[float, "Pa", "absolute pressure in chamber B"]
TemperatureA = Annotated[float, "K", "temperature of the air in chamber A"]
TemperatureB = Annotated[float, "K", "temperature of the air in chamber B"]
BristleDeflection = Annotated[float, "m", "deflection of the bristles between carriage and bore"]
PistonPosition = Annotated[float, "m", "position of the piston, 0 at chamber A's end"]
PistonVelocity = Annotated[float, "m/s", "velocity of the piston, positive toward chamber B's end"]
PistonBristleDeflection = Annotated[float, "m", "deflection of the bristles of the piston's seals"]
Coupled = Annotated[float, "", "1 while the magnets hold piston and carriage together, else 0"]
SupplyPressure = Annotated[float, "Pa", "absolute pressure of the supply at the valve"]
ReceiverPressure = Annotated[float, "Pa", "absolute pressure in the compressor's receiver"]
Compressor = Annotated[float, "", "1 while the compressor runs, else 0"]
FrictionClock = Annotated[float, "s", "time since friction drifted last"]
FrictionDice = Annotated[float, "", "the dice of the friction's drift"]
StaticDrift = Annotated[float, "", "ln of what F_s has drifted to, over its value"]
CoulombDrift = Annotated[float, "", "ln of what F_c has drifted to, over its value"]
ViscousDrift = Annotated[float, "", "ln of what B has drifted to, over its value"]
Voltage = Annotated[
    float, "V", "voltage that the valve follows: the command, or what a fault makes of it"
]
Time = Annotated[float, "s", "plant time since the start or the last reset"]
PneumaticForce = Annotated[float, "N", "pneumatic force on the carriage, A (P_a − P_b)"]
MassFlowA = Annotated[float, "kg/s", "mass flow into chamber A"]
MassFlowB = Annotated[float, "kg/s", "mass flow into chamber B"]
SpoolVoltage = Annotated[float, "V", "where the valve's spool is: the command that would hold it"]


Kind = TypeVar("Kind", bound=type)


def documented(kind: Kind) -> Kind:
    """Give each annotated field of a named tuple its meaning and unit as docstring."""
    for name, unit, meaning in quantities(kind):
        getattr(kind, name).__doc__ = f"{meaning}, {unit}"
    return kind


@documented
class Motion(NamedTuple):
    """What the plant integrates: its state, or the rate of change of its state."""

    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB


@documented
class HeatedMotion(NamedTuple):
    """:class:`Motion` of a rig whose chambers have temperatures of their own."""

    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB
    temperature_a: TemperatureA
    temperature_b: TemperatureB


@documented
class FullMotion(NamedTuple):
    """:class:`Motion` of a rig with options that need further states.

    It has those of all options. Of one that is off they stay where they do nothing.
    """

    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB
    temperature_a: TemperatureA
    temperature_b: TemperatureB
    bristle_deflection: BristleDeflection
    piston_position: PistonPosition
    piston_velocity: PistonVelocity
    piston_bristle_deflection: PistonBristleDeflection
    coupled: Coupled
    supply_pressure: SupplyPressure
    receiver_pressure: ReceiverPressure
    compressor: Compressor
    friction_clock: FrictionClock
    friction_dice: FrictionDice
    static_drift: StaticDrift
    coulomb_drift: CoulombDrift
    viscous_drift: ViscousDrift


AnyMotion = Motion | HeatedMotion | FullMotion


@kernel_by_type
def moved(state: Motion, rate: Motion, duration: float) -> Motion:
    """State after ``duration`` seconds at a constant rate; also state + factor · change."""
    return Motion(
        state.position + duration * rate.position,
        state.velocity + duration * rate.velocity,
        state.pressure_a + duration * rate.pressure_a,
        state.pressure_b + duration * rate.pressure_b,
    )


@version_for(HeatedMotion, moved)
def _moved(state: HeatedMotion, rate: HeatedMotion, duration: float) -> HeatedMotion:
    return HeatedMotion(
        state.position + duration * rate.position,
        state.velocity + duration * rate.velocity,
        state.pressure_a + duration * rate.pressure_a,
        state.pressure_b + duration * rate.pressure_b,
        state.temperature_a + duration * rate.temperature_a,
        state.temperature_b + duration * rate.temperature_b,
    )


@kernel_by_type
def carried(state: Motion, position: float, velocity: float) -> Motion:
    """Return the same state with the carriage at ``position`` (m) and ``velocity`` (m/s)."""
    return Motion(position, velocity, state.pressure_a, state.pressure_b)


@version_for(HeatedMotion, carried)
def _carried(state: HeatedMotion, position: float, velocity: float) -> HeatedMotion:
    return HeatedMotion(
        position,
        velocity,
        state.pressure_a,
        state.pressure_b,
        state.temperature_a,
        state.temperature_b,
    )


@kernel
def stopped(state: AnyMotion) -> AnyMotion:
    """Return the same state with the carriage at rest, exactly."""
    return carried(state, state.position, 0.0)


NO_TEMPERATURES = (
    "the chambers have no temperatures: all air has supply.temperature, unless "
    "chambers.thermodynamics is energy_balance"
)


@documented
class State(NamedTuple):
    """The rig at one instant: the time, all of :class:`Motion`, and what follows from it.

    Examples
    --------
    >>> from rodless_sim import Rig
    >>> state = Rig().advance(voltage=6.0, duration=0.5)
    >>> f"{state.time} s: {state.position * 1e3:.1f} mm, {state.force:.0f} N"
    '0.5 s: 9.1 mm, 120 N'

    """

    time: Time
    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB
    voltage: Voltage
    force: PneumaticForce
    mass_flow_a: MassFlowA
    mass_flow_b: MassFlowB

    @property
    def temperature_a(self) -> float:
        """Chamber A has no temperature of its own; a :class:`HeatedState` has one, in K."""
        raise AttributeError(NO_TEMPERATURES)

    @property
    def temperature_b(self) -> float:
        """Chamber B has no temperature of its own; a :class:`HeatedState` has one, in K."""
        raise AttributeError(NO_TEMPERATURES)

    @property
    def spool_voltage(self) -> float:
        """Where the valve's spool is: the command that would hold it there, in V.

        It is ``voltage`` where the spool follows at once; else the state has it as a field.
        """
        return self.voltage


@documented
class HeatedState(NamedTuple):
    """:class:`State` of a rig with ``chambers.thermodynamics`` ``energy_balance``.

    Type checkers are told that it is a :class:`State`: it has all that one has, in its order.

    Examples
    --------
    >>> from rodless_sim import Rig, RigParameters
    >>> rig = Rig(RigParameters({"chambers.thermodynamics": "energy_balance"}))
    >>> state = rig.advance(voltage=6.0, duration=0.5)
    >>> f"A {state.temperature_a:.0f} K, B {state.temperature_b:.0f} K"
    'A 303 K, B 284 K'

    """

    time: Time
    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB
    voltage: Voltage
    force: PneumaticForce
    mass_flow_a: MassFlowA
    mass_flow_b: MassFlowB
    temperature_a: TemperatureA
    temperature_b: TemperatureB

    @property
    def spool_voltage(self) -> float:
        """Where the valve's spool is, as of a :class:`State`."""
        return self.voltage


# Of nobody's interest.
HIDDEN = ("friction_clock", "friction_dice")

# What a state has behind its other fields where an option makes it a state of its own.
FURTHER = {
    **{
        name: kind
        for name, kind in FullMotion.__annotations__.items()
        if name not in (*Motion._fields, *HIDDEN)
    },
    "spool_voltage": SpoolVoltage,
}
TEMPERATURES = ("temperature_a", "temperature_b")
PISTON = ("piston_position", "piston_velocity")
DRIFTS = ("static_drift", "coulomb_drift", "viscous_drift")
SPOOL = ("spool_voltage",)


def piston_of(state: State) -> tuple[float, ...]:
    """Return position (m) and velocity (m/s) of the piston; nothing where it is the carriage."""
    return tuple(getattr(state, name) for name in PISTON if name in state._fields)


@cache
def state_with(further: tuple[str, ...]) -> type[State]:
    """Return the kind of state with the fields ``further``, some of ``FURTHER`` in its order.

    Type checkers are told that it is a :class:`State`: it has all that one has, in its order.
    """
    if not further:
        return State
    if further == TEMPERATURES:
        return cast(type[State], HeatedState)
    fields = {**State.__annotations__, **{name: FURTHER[name] for name in further}}
    kind = cast(Any, NamedTuple)("State", list(fields.items()))
    kind.__doc__ = f"A :class:`State` that has {' and '.join(further)}, too."
    if not set(SPOOL) <= {*further}:
        kind.spool_voltage = State.spool_voltage
    # Pickle looks for a class by its name, which all of these share.
    kind.__reduce__ = lambda state: (_state_of, (further, tuple(state)))
    return cast(type[State], documented(kind))


def _state_of(further: tuple[str, ...], values: Sequence[float]) -> State:
    return state_with(further)(*values)
