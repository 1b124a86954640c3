# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The slope of friction in a linear model, against the forms' derivatives by hand."""

import math

import numpy as np
import pytest

from rodless_lab import linearise
from rodless_sim import RigParameters

SPEEDS = (0.0, 1e-9, 1e-7, 5e-7, 1e-6, 1e-5, 7e-5, 1e-3, 0.05)
STEEP: dict[str, object] = {
    "friction.forward.stribeck_velocity": 1e-4,
    "friction.forward.viscous": 100.0,
    "friction.reverse.stribeck_velocity": 1e-4,
}
BENT: dict[str, object] = {"friction.form": "saturating", "friction.saturation_velocity": 1e-4}


def slope(parameters: RigParameters, side: str, speed: float) -> float:
    """The derivative of eq. (29), or of the form that bends, in N·s/m."""
    static, coulomb, knee, viscous = (
        parameters.number(f"friction.{side}.{name}")
        for name in ("static", "coulomb", "stribeck_velocity", "viscous")
    )
    dry = -2.0 * speed / knee**2 * (static - coulomb) * math.exp(-((speed / knee) ** 2))
    if parameters.text("friction.form") == "stribeck":
        return dry + viscous
    high = parameters.number("friction.high_speed_viscous")
    bend = math.exp(-speed / parameters.number("friction.saturation_velocity"))
    return dry + high + (viscous - high) * bend


@pytest.mark.parametrize("values", [{}, STEEP, BENT, {**STEEP, **BENT}])
@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("side", ["forward", "reverse"])
def test_the_slope_of_friction_is_that_of_its_formula(
    values: dict[str, object], speed: float, side: str
) -> None:
    """At rest, next to it and beyond, in either direction; at rest a carriage slides forward."""
    parameters = RigParameters(values)
    velocity = speed if side == "forward" else -speed
    found = linearise(parameters, 0.1, 5.5, velocity=velocity).A[1, 1]
    side = side if speed else "forward"
    expected = -slope(parameters, side, speed) / parameters.number("cylinder.moving_mass")
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-5)


def test_friction_rises_at_rest_and_falls_a_little_faster() -> None:
    """As docs/linear-model.md says: at v_s/√2 a pole is unstable, at rest none is."""
    parameters = RigParameters()
    rest = linearise(parameters, 0.1, 5.3, velocity=0.0)
    assert (rest.poles.real < 1e-6).all()
    knee = parameters.number("friction.forward.stribeck_velocity")
    steepest = linearise(parameters, 0.1, 5.3, velocity=knee / math.sqrt(2.0))
    assert steepest.poles.real.max() > 1e3
    nearby = [linearise(parameters, 0.1, 5.3, velocity=v).A[1, 1] for v in np.linspace(0, 3e-3, 61)]
    assert steepest.A[1, 1] >= max(nearby)
