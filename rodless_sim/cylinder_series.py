# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The cylinders of the CY3R series: what a model number such as CY3R32-500 says of a rig.

Bore, stroke and holding force are the catalogue's. The rest is a judgement that begins at the
CY3R25 of the paper:

- Friction grows with the area of the piston. The catalogue's minimum operating pressure is much the
  same for all bores, so the force that moves the carriage is in proportion to it. Velocities stay.
- So does the moving mass, as the holding force of the magnets does within 40 %.
- Of the dead volume the end cavity grows with the area; tube and fittings stay.
"""

import math
import re
from collections.abc import Collection
from typing import NamedTuple

from rodless_base.one_line import shown
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare
from rodless_sim.physics import cylinder, friction

# SMC catalogue ES20-172C, series CY3R.
# Holding force of the magnets in N by bore in mm.
HOLDING_FORCES = {
    6: 19.6,
    10: 53.9,
    15: 137.0,
    20: 231.0,
    25: 363.0,
    32: 588.0,
    40: 922.0,
    50: 1471.0,
    63: 2256.0,
}
BORES = tuple(HOLDING_FORCES)  # mm
PAPERS_BORE = 0.025  # m
MODEL = "cylinder.model"
OTHER = "other"

# Of the default dead volume: 5 cm³ are the end cavity of a CY3R25.
END_CAVITY = 5e-6  # m³

GIVEN = ("cylinder.bore", "cylinder.stroke")
GROWING = (
    "cylinder.moving_mass",
    "friction.forward.static",
    "friction.forward.coulomb",
    "friction.forward.viscous",
    "friction.reverse.static",
    "friction.reverse.coulomb",
    "friction.reverse.viscous",
    "friction.high_speed_viscous",
)
DEAD_VOLUMES = ("cylinder.dead_volume_a", "cylinder.dead_volume_b")

_DEFAULTS = {**cylinder.PARAMETERS, **friction.PARAMETERS}
_MODEL = re.compile(r"CY3R(\d{1,3})-(\d{1,4})", re.ASCII)

PARAMETERS = declare(
    Parameter(
        MODEL,
        "CY3R25-200",
        "",
        "model number, bore and stroke in mm: sets cylinder.bore, .stroke, .moving_mass, "
        ".dead_volume_*, coupling.holding_force and the forces of friction.* that are not given "
        "beside it; other: none",
        "SMC CY3R catalogue",
    )
)


def _default(name: str) -> float:
    default = _DEFAULTS[name].default
    assert isinstance(default, float)
    return default


def values_of(model: str) -> dict[str, float]:
    """Return the parameters of a cylinder by its model number, such as ``CY3R32-500``.

    Raises
    ------
    ParameterError
        For a number that is none, and for a bore or a stroke that the series does not have.

    Examples
    --------
    >>> values_of("CY3R32-500")["cylinder.bore"]
    0.032

    """
    bore, stroke = sizes(model)
    scale = (bore / PAPERS_BORE) ** 2
    values = {"cylinder.bore": bore, "cylinder.stroke": stroke}
    values["coupling.holding_force"] = HOLDING_FORCES[round(bore * 1e3)]
    values |= {name: _default(name) * scale for name in GROWING}
    values |= {name: _default(name) + END_CAVITY * (scale - 1.0) for name in DEAD_VOLUMES}
    return values


class Sizes(NamedTuple):
    """What a model number says."""

    bore: float  # m
    stroke: float  # m


def sizes(model: str) -> Sizes:
    """Return bore and stroke by the model number; raises as :func:`values_of`."""
    found = _MODEL.fullmatch(model)
    if found is None:
        raise ParameterError(
            f"cylinder.model: {shown(model)} refused, must be {OTHER} or CY3R<bore>-<stroke> in "
            "mm, such as CY3R32-500"
        )
    bore, stroke = int(found[1]), int(found[2])
    if bore not in BORES:
        raise ParameterError(
            f"cylinder.model: {model} refused, the series has the bores "
            f"{', '.join(map(str, BORES))} mm; for another set cylinder.bore"
        )
    declared = _DEFAULTS["cylinder.stroke"]
    if not declared.minimum <= stroke / 1000 <= declared.maximum:
        raise ParameterError(
            f"cylinder.model: {model} refused, the stroke must be from "
            f"{declared.minimum * 1e3:g} to {declared.maximum * 1e3:g} mm"
        )
    return Sizes(bore / 1000, stroke / 1000)


def _fits(parameters: ParameterSet, values: dict[str, float]) -> bool:
    return all(math.isclose(parameters.number(name), values[name]) for name in GIVEN)


def derived(
    parameters: ParameterSet, named: Collection[str], changed: Collection[str]
) -> dict[str, float | str]:
    """Return what follows from a new model; a new bore or stroke makes it another cylinder."""
    model = parameters.text(MODEL)
    if model == OTHER:
        return {}
    values = values_of(model)
    if MODEL in changed:
        return {name: value for name, value in values.items() if name not in named}
    return {} if _fits(parameters, values) else {MODEL: OTHER}


def check(parameters: ParameterSet) -> None:
    """Refuse a bore or a stroke that is not the model's."""
    model = parameters.text(MODEL)
    if model == OTHER:
        return
    values = values_of(model)
    for name in GIVEN:
        if not math.isclose(parameters.number(name), values[name]):
            raise ParameterError(
                f"{name}: {parameters.number(name):g} m refused, cylinder.model {model} has "
                f"{values[name]:g} m; leave one of them out, or set cylinder.model to {OTHER}"
            )
