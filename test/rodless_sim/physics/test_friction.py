# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction of eqs. (28)-(29) against hand-computed points of Table 2."""

import math
from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

from rodless_base.sockets import check_kernel
from rodless_sim import ParameterError, RigParameters
from rodless_sim.physics.equations import breakaway_limits
from rodless_sim.physics.friction import Friction, check_drag, sliding_friction
from rodless_sim.physics.friction_forms.direction import Drag
from rodless_sim.physics.plant import Plant

STRIBECK = Plant.of(RigParameters()).friction
SATURATING = Plant.of(RigParameters({"friction.form": "saturating"})).friction


@pytest.mark.parametrize("friction", [STRIBECK, SATURATING])
def test_breakaway_force_has_its_own_value_for_each_direction(friction: Friction) -> None:
    """29 N hold against a forward push, 36 N against a reverse one (Table 2).

    A cap holds any push into it.
    """
    plant = Plant.of(RigParameters())._replace(friction=friction)
    assert breakaway_limits(plant, 0.1) == (-36.0, 29.0)
    assert breakaway_limits(plant, 0.0) == (-math.inf, 29.0)
    assert breakaway_limits(plant, 0.2) == (-36.0, math.inf)


@pytest.mark.parametrize("friction", [STRIBECK, SATURATING])
def test_sliding_friction_starts_at_the_breakaway_force(friction: Friction) -> None:
    """As the speed goes to zero the sliding force goes to F_s: slip joins stick without a jump."""
    assert sliding_friction(friction, 0.0, 1) == pytest.approx(29.0, rel=1e-12)
    assert sliding_friction(friction, 0.0, -1) == pytest.approx(-36.0, rel=1e-12)


def test_stribeck_curve_by_hand() -> None:
    """At v = v_s eq. (29) gives F_c + (F_s - F_c)/e + B v_s for each direction."""
    # forward: 12 + 17*0.367879 + 4500*0.0013 = 12 + 6.253950 + 5.85
    assert sliding_friction(STRIBECK, 1.3e-3, 1) == pytest.approx(24.103950, rel=1e-7)
    # reverse: 12.5 + 23.5*0.367879 + 4800*0.0036 = 12.5 + 8.645167 + 17.28
    assert sliding_friction(STRIBECK, -3.6e-3, -1) == pytest.approx(-38.425167, rel=1e-7)


def test_saturating_curve_by_hand() -> None:
    """At v = v_k = 5 mm/s F_v = B₂ v + (B₁ - B₂) v_k (1 - 1/e); the Stribeck drop is spent."""
    # forward: (5/1.3)² = 14.7929, e^-14.7929 = 3.763e-7, 17*3.763e-7 = 6.4e-6
    # 12 + 6.4e-6 + 80*0.005 + 4420*0.005*0.632121 = 12 + 0.4 + 13.969865
    assert sliding_friction(SATURATING, 5e-3, 1) == pytest.approx(26.369871, rel=1e-7)


@pytest.mark.parametrize("friction", [STRIBECK, SATURATING])
@pytest.mark.parametrize("direction", [1, -1])
def test_friction_always_opposes_motion(friction: Friction, direction: int) -> None:
    """At every speed up to 0.5 m/s the force takes power out of the carriage, at least F_c v."""
    coulomb = 12.0 if direction > 0 else 12.5
    for speed in np.linspace(1e-6, 0.5, 2001):
        force = sliding_friction(friction, direction * speed, direction)
        assert direction * force >= coulomb


def test_both_forms_share_their_slope_at_creep_and_part_at_speed() -> None:
    """Saturating friction starts with Table 2's B and ends with B₂ = 80 N·s/m, forward."""
    step = 1e-7
    creep = viscous_slope(SATURATING, 0.0, step)
    fast = viscous_slope(SATURATING, 0.4, step)
    assert creep == pytest.approx(viscous_slope(STRIBECK, 0.0, step), rel=1e-4)
    assert fast == pytest.approx(80.0, rel=1e-4)
    assert viscous_slope(STRIBECK, 0.4, step) == pytest.approx(4500.0, rel=1e-4)


def viscous_slope(friction: Friction, speed: float, step: float) -> float:
    """Slope in N·s/m of the forward curve beyond its Stribeck drop, by a difference."""
    rise = sliding_friction(friction, speed + step, 1) - sliding_friction(friction, speed, 1)
    drop = 17.0 * (math.exp(-(((speed + step) / 1.3e-3) ** 2)) - math.exp(-((speed / 1.3e-3) ** 2)))
    return (rise - drop) / step


@pytest.mark.parametrize("answer", [3.0, None, Drag(3, 0.0), (3.0, 0.0)])
def test_a_form_that_returns_no_drag_is_named(answer: object) -> None:
    """Form and answer, instead of the compiler's pages."""
    odd = form_of(lambda *_: answer)
    with pytest.raises(TypeError, match=r"^own\.odd: force returns .*must return a Drag, such as"):
        check_kernel(odd, "force", Drag(12.0, 0.0), None, STRIBECK.forward, 0.01)


def test_a_form_that_drives_the_carriage_is_refused() -> None:
    """Friction below zero at some speed is named, with speed and direction; zero is none."""
    driving = form_of(lambda _own, side, speed: Drag(side.coulomb - 5e3 * speed, -5e3))
    expected = (
        r"^friction\.form: odd refused, its friction is -38 N at 0\.01 m/s forward and would drive "
    )
    with pytest.raises(ParameterError, match=expected):
        check_drag(driving, RigParameters(), "forward")
    check_drag(form_of(lambda *_: Drag(0.0, 0.0)), RigParameters(), "reverse")


def form_of(force: Callable[..., object]) -> ModuleType:
    """Return a form of the test's own."""
    odd = ModuleType("own.odd")
    vars(odd).update(NAME="odd", force=force, of=lambda _: None)
    return odd
