# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Friction of bristles along a measured motion, beside scipy's integration of the LuGre model."""

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp

from rodless_lab.identification.friction.bristle_motion import BristleMotion
from rodless_lab.identification.friction.curve import Stribeck, friction_force
from rodless_lab.identification.friction.form import PRINTED
from rodless_lab.identification.friction.uniform_motion import UniformPart
from rodless_sim import RigParameters

Array = npt.NDArray[np.float64]

CURVE = Stribeck(29.0, 12.0, 1.3e-3, 4500.0)
STIFFNESS, DAMPING, DAMPING_SPEED = 2e5, 600.0, 0.01
RIG = RigParameters({"friction.dynamics": "lugre", "friction.bristle_stiffness": STIFFNESS})
PERIOD = 1e-3


def parts(*spans: tuple[int, int]) -> list[UniformPart]:
    """Parts from sample to sample, of which nothing else counts."""
    return [UniformPart(first, last, 0.0, 0.0, 0.0, 0.0, 0.0) for first, last in spans]


def scipys_force(time: Array, velocity: Array) -> Array:
    """Canudas de Wit et al. 1995, with a damping that fades, along ``velocity`` (m/s) > 0."""

    def level(speed: float) -> float:
        drop = (CURVE.static - CURVE.coulomb) * np.exp(-((speed / CURVE.stribeck_velocity) ** 2))
        return float(CURVE.coulomb + drop)

    def rate(at: float, deflection: Array) -> Array:
        speed = float(np.interp(at, time, velocity))
        return np.asarray(speed - STIFFNESS * speed / level(speed) * deflection)

    found = solve_ivp(
        rate, (time[0], time[-1]), [0.0], "Radau", time, rtol=1e-8, atol=1e-12, max_step=0.01
    )
    forces = [
        STIFFNESS * z
        + DAMPING * np.exp(-((v / DAMPING_SPEED) ** 2)) * rate(at, np.array([z]))[0]
        + CURVE.viscous * v
        for at, z, v in zip(time, found.y[0], velocity, strict=True)
    ]
    return np.array(forces)


@pytest.mark.parametrize("acceleration", [1e-3, 5e-3])
def test_a_carriage_that_gathers_speed_has_the_force_that_scipy_gives(acceleration: float) -> None:
    """Slow at first, where friction lags by up to newtons, then past the drop of eq. (29)."""
    time = np.arange(2001) * PERIOD
    velocity = 1e-4 + acceleration * time
    position = 1e-4 * time + 0.5 * acceleration * time**2
    spans = [(first, first + 250) for first in range(250, 1800, 250)]
    motion = BristleMotion.of(RIG, position, PERIOD, parts(*spans))
    force = scipys_force(time, velocity)
    expected = [force[first:last].mean() for first, last in spans]
    found = motion.forces(PRINTED, CURVE)
    np.testing.assert_allclose(found, expected, atol=0.03)
    # As if it followed at once it would be another.
    at_once = [friction_force(CURVE, velocity[first:last]).mean() for first, last in spans]
    assert np.max(np.abs(np.array(at_once) - expected)) > 0.3


def test_what_has_slid_for_long_has_the_force_of_the_curve() -> None:
    """At one speed, in either direction: eq. (29)."""
    for speed in (1e-3, 5e-3, 0.02):
        position = speed * np.arange(4000) * PERIOD
        motion = BristleMotion.of(RIG, position, PERIOD, parts((3000, 3990)))
        (force,) = motion.forces(PRINTED, CURVE)
        assert force == pytest.approx(friction_force(CURVE, np.array([speed]))[0], rel=1e-6)
        back = BristleMotion.of(RIG, -position, PERIOD, parts((3000, 3990)))
        forward = back.along(-1.0, np.array([True]))
        assert forward.forces(PRINTED, CURVE)[0] == pytest.approx(force)


@pytest.mark.parametrize("count", [4000, 4001, 4009])
@pytest.mark.parametrize("period", [PERIOD, 0.02])
def test_a_part_may_end_with_the_run(count: int, period: float) -> None:
    """Its last step is the run's, not what lies behind it in memory: eq. (29) as before."""
    speed = 5e-3
    position = speed * np.arange(count) * period
    motion = BristleMotion.of(RIG, position, period, parts((count - 300, count)))
    assert motion.lasts[0] <= len(motion.speeds)
    (force,) = motion.forces(PRINTED, CURVE)
    assert force == pytest.approx(friction_force(CURVE, np.array([speed]))[0], rel=1e-6)


def test_only_the_chosen_parts_count() -> None:
    """Those of the other direction are left out, and the rest keeps its order."""
    position = 1e-3 * np.arange(2000) * PERIOD
    motion = BristleMotion.of(RIG, position, PERIOD, parts((100, 350), (900, 1150), (1500, 1750)))
    every = motion.forces(PRINTED, CURVE)
    some = motion.along(1.0, np.array([True, False, True])).forces(PRINTED, CURVE)
    assert some.tolist() == every[[0, 2]].tolist()


@pytest.mark.parametrize("speed", [5e-4, 1e-3, 5e-3])
def test_the_error_that_is_stated_holds_that_of_the_positions_noise(speed: float) -> None:
    """20 µm of noise, 100 draws: the force's error is no greater, and not beyond all measure.

    A part's mean is better than one place of it by up to the number of independent ones.
    """
    generator = np.random.default_rng(1)
    place = speed * np.arange(2000) * PERIOD
    part = parts((1500, 1750))
    drawn = []
    for _ in range(100):
        seen = place + generator.normal(0.0, 2e-5, place.shape)
        motion = BristleMotion.of(RIG, seen, PERIOD, part)
        drawn.append(motion.forces(PRINTED, CURVE)[0])
    (clean,) = BristleMotion.of(RIG, place, PERIOD, part).forces(PRINTED, CURVE)
    (stated,) = motion.force_errors(np.array([speed]), np.array([clean]))
    error = float(np.sqrt(np.mean((np.array(drawn) - clean) ** 2)))
    assert 0.1 * stated < error < 1.5 * stated
