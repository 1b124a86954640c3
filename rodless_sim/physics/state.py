"""The rig's states, each with unit and meaning: traces, records and docs follow from this list."""

from typing import Annotated, NamedTuple, TypeVar

from rodless_base.columns import quantities
from rodless_base.kernels import kernel

Position = Annotated[float, "m", "position of the carriage, 0 at chamber A's end"]
Velocity = Annotated[float, "m/s", "velocity of the carriage, positive toward chamber B's end"]
PressureA = Annotated[float, "Pa", "absolute pressure in chamber A"]
PressureB = Annotated[float, "Pa", "absolute pressure in chamber B"]


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


@kernel
def moved(state: Motion, rate: Motion, duration: float) -> Motion:
    """State after ``duration`` seconds at a constant rate; also state + factor · change."""
    return Motion(
        state.position + duration * rate.position,
        state.velocity + duration * rate.velocity,
        state.pressure_a + duration * rate.pressure_a,
        state.pressure_b + duration * rate.pressure_b,
    )


@kernel
def stopped(state: Motion) -> Motion:
    """Return the same state with the carriage at rest, exactly."""
    return Motion(state.position, 0.0, state.pressure_a, state.pressure_b)


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

    time: Annotated[float, "s", "plant time since the start or the last reset"]
    position: Position
    velocity: Velocity
    pressure_a: PressureA
    pressure_b: PressureB
    voltage: Annotated[float, "V", "command that the valve follows"]
    force: Annotated[float, "N", "pneumatic force on the carriage, A (P_a − P_b)"]
    mass_flow_a: Annotated[float, "kg/s", "mass flow into chamber A"]
    mass_flow_b: Annotated[float, "kg/s", "mass flow into chamber B"]
