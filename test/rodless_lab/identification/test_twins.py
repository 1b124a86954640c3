# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Equations that identification has over arrays are those of the plant, which has them compiled."""

import numpy as np
import pytest

from rodless_lab.identification import FlowCoefficientCurve, Stribeck, friction_force, three_sines
from rodless_lab.identification.estimate import symmetric
from rodless_sim import RigParameters
from rodless_sim.physics.friction import sliding_friction
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.valve import effective_area, flow_coefficient

SAME = 1e-12
SEEDS = range(5)


@pytest.mark.parametrize("seed", SEEDS)
def test_three_sines_are_the_plants_area(seed: int) -> None:
    """Eq. (5), any nine coefficients: within 1e-12 of the largest area, 0 to 10 V."""
    generator = np.random.default_rng(seed)
    coefficients = generator.uniform(0.1, 3.0, 9) * np.tile([1e-6, 1.0, 1.0], 3)
    values = {"valve.area_coefficients": tuple(coefficients.tolist())}
    valve = Plant.of(RigParameters(values)).valve
    voltages = generator.uniform(0.0, 10.0, 200)
    expected = np.array([effective_area(valve, float(voltage)) for voltage in voltages])
    found = three_sines(coefficients, voltages)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=SAME * np.abs(expected).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_the_polynomial_is_the_plants_flow_coefficient(seed: int) -> None:
    """Eq. (25), any six coefficients, either side of the closed position, to 1e-12."""
    generator = np.random.default_rng(seed)
    coefficients = generator.uniform(0.1, 1.0, 6) * 10.0 ** -np.arange(6)
    values = {"valve.flow_coefficients": tuple(coefficients.tolist())}
    valve = Plant.of(RigParameters(values)).valve
    curve = FlowCoefficientCurve(tuple(symmetric(value, 0.0, 1, "") for value in coefficients), 0.0)
    deflections = generator.uniform(-5.0, 5.0, 200)
    expected = [flow_coefficient(valve, float(deflection)) for deflection in deflections]
    np.testing.assert_allclose(curve.coefficient(deflections), expected, rtol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("side", "sign"), [("forward", 1), ("reverse", -1)])
def test_the_curve_is_the_plants_friction(seed: int, side: str, sign: int) -> None:
    """Eq. (29), any four values, both directions, from rest to 0.2 m/s, to 1e-12."""
    generator = np.random.default_rng(seed)
    coulomb = generator.uniform(5.0, 20.0)
    curve = Stribeck(
        coulomb + generator.uniform(0.0, 30.0),
        coulomb,
        generator.uniform(1e-3, 1e-2),
        generator.uniform(0.0, 6000.0),
    )
    values = {f"friction.{side}.{name}": value for name, value in curve._asdict().items()}
    friction = Plant.of(RigParameters(values)).friction
    speeds = generator.uniform(0.0, 1.0, 200) ** 3 * 0.2
    expected = [sign * sliding_friction(friction, sign * float(speed), sign) for speed in speeds]
    np.testing.assert_allclose(friction_force(curve, speeds), expected, rtol=SAME)
