# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The magnets between piston and carriage: a spring that lets go.

The paper takes both for one mass. In truth the carriage follows the piston through the wall of the
tube by its magnets, which lag by δ = x_p − x_c:

    F = F_max sin(π δ / 2 δ_m) + d dδ/dt          |δ| < δ_m

At δ_m the force is the holding force; past it they have parted, and nothing pulls the carriage
until piston and carriage are within the catching distance again.
"""

import math
from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics.sources import JUDGEMENT

MAGNETIC = "magnetic"
CATALOGUE = "SMC catalogue ES20-172C, CY3R25"

PARAMETERS = declare(
    Parameter(
        "coupling.kind",
        "rigid",
        "",
        "what joins piston and carriage: rigid: they are one mass; magnetic: magnets that lag and "
        "may part",
        "docs/options/coupling.md",
        choices=("rigid", MAGNETIC),
        fixed=True,
    ),
    Parameter(
        "coupling.holding_force",
        363.0,
        "N",
        f"force F_max at which the magnets part ({MAGNETIC})",
        CATALOGUE,
        1.0,
        1e5,
    ),
    Parameter(
        "coupling.slip_distance",
        3e-3,
        "m",
        f"lag δ_m of the carriage at which they part ({MAGNETIC})",
        f"{JUDGEMENT}: half the width of a magnet ring",
        1e-4,
        0.05,
    ),
    Parameter(
        "coupling.catch_distance",
        1.5e-3,
        "m",
        f"distance at which they catch each other again ({MAGNETIC})",
        f"{JUDGEMENT}: half the slip distance",
        1e-5,
        0.05,
    ),
    Parameter(
        "coupling.damping",
        20.0,
        "N·s/m",
        f"damping d of the relative motion ({MAGNETIC})",
        f"{JUDGEMENT}: damping ratio 0.05; magnets in a tube of steel lose little",
        0.0,
        1e4,
    ),
    Parameter(
        "coupling.piston_mass",
        0.35,
        "",
        f"share of cylinder.moving_mass that the piston is ({MAGNETIC})",
        f"{JUDGEMENT}: piston with its magnets 0.35 kg",
        0.05,
        0.95,
    ),
    Parameter(
        "coupling.piston_friction",
        0.7,
        "",
        f"share of friction.* that is on the piston ({MAGNETIC}); the rest is on the carriage",
        f"{JUDGEMENT}: the piston's seals are pressed on by the air, the scrapers are not",
        0.0,
        1.0,
    ),
)


class Coupling(NamedTuple):
    """Constants of what joins piston and carriage."""

    magnetic: bool
    broken: bool  # the magnets hold nothing
    holding_force: float  # N
    slip_distance: float  # m
    catch_distance: float  # m
    damping: float  # N·s/m
    piston_mass: float  # share
    piston_friction: float  # share

    @classmethod
    def of(cls, parameters: ParameterSet) -> "Coupling":
        """Return the constants for ``parameters``."""
        return cls(
            parameters.text("coupling.kind") == MAGNETIC,
            False,
            *(parameters.number(f"coupling.{name}") for name in cls._fields[2:]),
        )


def check(parameters: ParameterSet) -> None:
    """Refuse magnets that would catch where they part."""
    catch, slip = (parameters.number(f"coupling.{name}_distance") for name in ("catch", "slip"))
    if catch >= slip:
        raise ParameterError(
            f"coupling.catch_distance: {catch:g} m refused, must be below "
            f"coupling.slip_distance ({slip:g} m)"
        )


@kernel
def pull(coupling: Coupling, lag: float, lag_rate: float) -> float:
    """Force in N on the carriage of magnets that hold; on the piston it is the opposite."""
    angle = 0.5 * math.pi * lag / coupling.slip_distance
    return coupling.holding_force * math.sin(angle) + coupling.damping * lag_rate
