# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""The plant's friction forms as functions to fit: force over speed, and its turning points."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.kernels import kernel
from rodless_lab.identification.friction.curve import Stribeck, TurningPoints, turning_points
from rodless_sim import RigParameters
from rodless_sim.physics.friction import FORMS, form_force
from rodless_sim.physics.friction_forms import stribeck
from rodless_sim.physics.friction_forms.direction import Direction

Array = npt.NDArray[np.float64]

# Where turning points are looked for, in Stribeck velocities: what falls does so before.
_REACH = np.linspace(0.0, 6.0, 601)


@kernel
def drag(code: int, own: tuple[Any, ...], side: Direction, speeds: Array) -> Array:
    """Friction in N and its slope in N·s/m at ``speeds`` >= 0 (m/s, shape (n,)); shape (n, 2)."""
    found = np.empty((speeds.size, 2))
    for k in range(speeds.size):
        here = form_force(code, own, side, speeds[k])
        found[k, 0] = here.force
        found[k, 1] = here.by_speed
    return found


@dataclass(frozen=True)
class FrictionForm:
    """One of the plant's forms, ``code`` in FORMS, with all forms' own constants."""

    code: int
    own: tuple[Any, ...]

    @classmethod
    def of(cls, parameters: RigParameters) -> "FrictionForm":
        """Return the form of ``parameters``, its own constants as they have them.

        Examples
        --------
        >>> form = FrictionForm.of(RigParameters({"friction.form": "saturating"}))
        >>> curve = Stribeck(29.0, 12.0, 1.3e-3, 4500.0)
        >>> form.name, form.force(curve, np.array([0.0, 0.1])).round(1).tolist()
        ('saturating', [29.0, 42.1])
        """
        code = parameters.choice("friction.form")
        return cls(code, tuple(form.of(parameters) for form in FORMS))

    @property
    def name(self) -> str:
        """What ``friction.form`` calls it."""
        return str(FORMS[self.code].NAME)

    def force(self, curve: Stribeck, speeds: Array) -> Array:
        """Friction in N at ``speeds`` >= 0 (m/s), shape (n,)."""
        return np.asarray(self._drag(curve, speeds)[:, 0])

    def slope(self, curve: Stribeck, speeds: Array) -> Array:
        """How friction changes with the speed, N·s/m, shape (n,)."""
        return np.asarray(self._drag(curve, speeds)[:, 1])

    def turning_points(self, curve: Stribeck) -> TurningPoints:
        """Return the first local maximum and the minimum after it.

        Both are the place of the least slope where friction nowhere falls.
        """
        if FORMS[self.code] is stribeck:
            return turning_points(curve)
        speeds = _REACH * curve.stribeck_velocity
        slope = self.slope(curve, speeds)
        falls = np.flatnonzero(slope < 0.0)
        if not len(falls):
            hump = valley = float(speeds[np.argmin(slope)])
        else:
            rises = falls[0] + np.flatnonzero(slope[falls[0] :] >= 0.0)
            hump = _zero(speeds, slope, int(falls[0]))
            valley = _zero(speeds, slope, int(rises[0])) if len(rises) else float(speeds[-1])
        low, high = self.force(curve, np.array([hump, valley]))
        return TurningPoints(hump, float(low), valley, float(high))

    def _drag(self, curve: Stribeck, speeds: Array) -> Array:
        side = Direction(*(float(value) for value in curve))
        return drag(self.code, self.own, side, np.asarray(speeds, dtype=np.float64))


def _zero(speeds: Array, slope: Array, after: int) -> float:
    """Speed at which the slope passes zero before sample ``after``."""
    if after == 0:
        return float(speeds[0])
    share = slope[after - 1] / (slope[after - 1] - slope[after])
    return float(speeds[after - 1] + share * (speeds[after] - speeds[after - 1]))


PRINTED = FrictionForm.of(RigParameters())
