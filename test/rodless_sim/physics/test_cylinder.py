# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The cylinder: volumes and pressure rates, each against a closed form."""

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.cylinder import pressure_rate, volume_a, volume_b
from rodless_sim.physics.plant import Plant

PLANT = Plant.of(RigParameters())
CYLINDER = PLANT.cylinder


def test_piston_area_is_that_of_a_25_mm_bore() -> None:
    """π/4 · (25 mm)² = 490.87 mm²."""
    assert CYLINDER.piston_area == pytest.approx(490.8739e-6, rel=1e-6)


def test_chamber_volumes_by_hand() -> None:
    """At 50 mm: V_a = 15 cm³ + 4.908739 cm² · 5 cm, V_b = 15 cm³ + 4.908739 cm² · 15 cm."""
    assert volume_a(CYLINDER, 0.05) == pytest.approx(39.543695e-6, rel=1e-7)
    assert volume_b(CYLINDER, 0.05) == pytest.approx(88.631085e-6, rel=1e-7)


@pytest.mark.parametrize("position", [0.0, 0.03, 0.1, 0.2])
def test_chambers_share_a_constant_volume_and_mirror_each_other(position: float) -> None:
    """What A gains B loses, and B at y equals A at (stroke - y) with equal dead volumes."""
    total = volume_a(CYLINDER, position) + volume_b(CYLINDER, position)
    assert total == pytest.approx(volume_a(CYLINDER, 0.0) + volume_b(CYLINDER, 0.0), rel=1e-14)
    assert volume_b(CYLINDER, position) == pytest.approx(
        volume_a(CYLINDER, 0.2 - position), rel=1e-14
    )


def test_filling_rate_of_a_fixed_chamber_by_hand() -> None:
    """0.1 g/s into 40 cm³ at 297 K raises the pressure by κ R T ṁ/V = 298.4 kPa/s."""
    # 1.4*287.05*297*1e-4/40e-6 = 119355.39*2.5 = 298388.5
    assert pressure_rate(PLANT.air, 40e-6, 0.0, 3e5, 1e-4) == pytest.approx(298388.475, rel=1e-8)


def test_compression_rate_of_a_sealed_chamber() -> None:
    """Without flow dP/P = -κ dV/V: shrinking 1 % per second raises P by 1.4 % per second."""
    assert pressure_rate(PLANT.air, 40e-6, -0.4e-6, 5e5, 0.0) == pytest.approx(7000.0, rel=1e-12)
