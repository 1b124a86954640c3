"""Seal and guide friction, eqs. (28)-(29), in one of several forms: values for each direction.

A form is one module of ``friction_forms`` with ``NAME``, ``MEANING``, its own ``PARAMETERS``, its
constants ``of(parameters)``, and a kernel ``force(constants, side, speed)`` for speeds from 0 up:
the :class:`~rodless_sim.physics.friction_forms.direction.Drag` on a carriage that slides. Where it
has ``check(parameters)``, that raises ParameterError for values that contradict each other,
whichever form is in use.
"""

from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

from rodless_base.kernels import dispatch, kernel
from rodless_base.one_line import shown
from rodless_base.parameters import Parameter, ParameterSet, collect, declare
from rodless_base.sockets import choices
from rodless_sim.physics.friction_forms.direction import (
    Direction,
    Drag,
    check_direction,
    declare_direction,
)
from rodless_sim.physics.sources import JUDGEMENT, PAPER

FORMS = choices(
    "rodless_sim.physics.friction_forms",
    (
        "stribeck",
        "saturating",
    ),
    kernels=("force",),
)

PARAMETERS = collect(
    declare(
        Parameter(
            "friction.form",
            "stribeck",
            "",
            "; ".join(f"{form.NAME}: {form.MEANING}" for form in FORMS),
            f"{PAPER}, eq. (29)",
            choices=tuple(form.NAME for form in FORMS),
        )
    ),
    declare_direction("forward", Direction(29.0, 12.0, 1.3e-3, 4500.0)),
    declare_direction("reverse", Direction(36.0, 12.5, 3.6e-3, 4800.0)),
    *(form.PARAMETERS for form in FORMS),
    declare(
        Parameter(
            "friction.capture_velocity",
            1e-5,
            "m/s",
            "speed α below which a force within F_s holds the carriage, eq. (28)",
            JUDGEMENT,
            0.0,
            1e-4,
        )
    ),
)


class Friction(NamedTuple):
    """Constants of the friction."""

    form: int  # place in FORMS of the form in use
    own: tuple[Any, ...]  # each form's own constants
    forward: Direction
    reverse: Direction
    capture_velocity: float  # m/s

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Friction":
        """Return the constants for ``parameters``."""
        forward = Direction.of(parameters, "forward")
        for form in FORMS:
            check_drag(form, form.of(parameters), forward)
        return cls(
            form=parameters.choice("friction.form"),
            own=tuple(form.of(parameters) for form in FORMS),
            forward=forward,
            reverse=Direction.of(parameters, "reverse"),
            capture_velocity=parameters.number("friction.capture_velocity"),
        )


def check_drag(form: ModuleType, constants: Any, side: Direction) -> None:
    """Raise TypeError, with the form, where its force is no Drag; the compiler names none."""
    try:
        found = getattr(form.force, "py_func", form.force)(constants, side, side.stribeck_velocity)
    except ArithmeticError:  # compiled code goes on with infinity
        return
    if not (isinstance(found, Drag) and all(isinstance(value, float) for value in found)):
        raise TypeError(
            f"{form.__name__} ({form.NAME}): force returns {shown(found)}, but must return a Drag "
            "of two floats; write 0.0 for 0"
        )


def check(parameters: ParameterSet) -> None:
    """Refuse a breakaway force below the Coulomb force, in either direction."""
    check_direction(parameters, "forward")
    check_direction(parameters, "reverse")


form_force: Callable[..., Drag] = dispatch([form.force for form in FORMS])


@kernel
def side_of(friction: Friction, direction: int) -> Direction:
    """Return the values for motion in ``direction`` (+1 or -1)."""
    return friction.forward if direction > 0 else friction.reverse


@kernel
def sliding(friction: Friction, velocity: float, direction: int) -> Drag:
    """Friction on a sliding carriage, eq. (29), signed like ``direction`` (+1 or -1).

    Speeds below zero, which an integrator tries before it finds where the carriage stops, continue
    in a straight line what the form gives at zero.
    """
    speed = velocity * direction
    side = side_of(friction, direction)
    found = form_force(friction.form, friction.own, side, max(speed, 0.0))
    force = found.force + found.by_speed * min(speed, 0.0)
    return Drag(direction * force, found.by_speed)


@kernel
def sliding_friction(friction: Friction, velocity: float, direction: int) -> float:
    """Friction force in N of a carriage that :func:`slides <sliding>`."""
    return sliding(friction, velocity, direction).force
