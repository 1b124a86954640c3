# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
from rodless_base.parameters import (
    Parameter,
    ParameterError,
    ParameterSet,
    collect,
    declare,
)
from rodless_base.sockets import check_kernel, choices, chooser
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
    chooser("friction.form", FORMS, f"{PAPER}, eq. (29)"),
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
            check_kernel(form, "force", Drag(12.0, 0.0), form.of(parameters), forward, 0.01)
        return cls(
            form=parameters.choice("friction.form"),
            own=tuple(form.of(parameters) for form in FORMS),
            forward=forward,
            reverse=Direction.of(parameters, "reverse"),
            capture_velocity=parameters.number("friction.capture_velocity"),
        )


# Speeds in m/s at which friction is looked at before a rig is made.
SPEEDS = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)


def check(parameters: ParameterSet) -> None:
    """Refuse a breakaway force below the Coulomb force, and friction that drives the carriage."""
    for name in ("forward", "reverse"):
        check_direction(parameters, name)
        check_drag(FORMS[parameters.choice("friction.form")], parameters, name)


def check_drag(form: ModuleType, parameters: ParameterSet, direction: str) -> None:
    """Raise ParameterError where a form's friction has the direction of the motion."""
    constants, side = form.of(parameters), Direction.of(parameters, direction)
    force = getattr(form.force, "py_func", form.force)
    for speed in SPEEDS:
        try:
            found = float(force(constants, side, speed)[0])
        except (ArithmeticError, ValueError, TypeError, LookupError):  # for those who call it
            continue
        if found < 0.0:
            raise ParameterError(
                f"friction.form: {form.NAME} refused, its friction is {found:g} N at {speed:g} m/s "
                f"{direction} and would drive the carriage; must be 0 or more, check friction.*"
            )


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
