"""The cylinder: volumes, pressure rates and end stops, each against a closed form."""

import math

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.cylinder import end_stop_force, pressure_rate, volume_a, volume_b
from rodless_sim.physics.plant import plant_constants

PLANT = plant_constants(RigParameters())
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


def test_end_stops_are_silent_within_the_stroke() -> None:
    """From end to end, both ends included, the caps exert no force at any speed."""
    for position in (0.0, 1e-9, 0.1, 0.2 - 1e-9, 0.2):
        for velocity in (-1.0, 0.0, 1.0):
            assert end_stop_force(CYLINDER, position, velocity) == 0.0


@pytest.mark.parametrize("depth", [1e-9, 1e-5, 1e-3])
@pytest.mark.parametrize("velocity", [-5.0, -0.1, 0.0, 0.1, 5.0])
def test_end_stops_never_pull(depth: float, velocity: float) -> None:
    """However fast the carriage leaves the cap, the force points into the stroke or is zero."""
    assert end_stop_force(CYLINDER, -depth, velocity) >= 0.0
    assert end_stop_force(CYLINDER, CYLINDER.stroke + depth, velocity) <= 0.0


def test_end_stop_force_by_hand_and_the_same_at_both_ends() -> None:
    """0.5 mm deep, entering at 0.1 m/s: 2e5 · 0.5e-3 + 300 · 0.1 = 130 N, away from the cap."""
    assert end_stop_force(CYLINDER, -0.5e-3, -0.1) == pytest.approx(130.0, rel=1e-12)
    assert end_stop_force(CYLINDER, 0.2005, 0.1) == pytest.approx(-130.0, rel=1e-9)


def test_an_impact_takes_energy_from_the_carriage() -> None:
    """Around a closed cycle in the cap, in and out at the same speeds, the force does net work < 0.

    Entering at speed v over depth s costs ∫(kx + cv)dx, leaving returns at most ∫(kx - cv)dx.
    """
    depths = [1e-3 * (i + 0.5) / 1000 for i in range(1000)]
    entering = sum(end_stop_force(CYLINDER, -x, -0.2) for x in depths) * 1e-6
    leaving = sum(end_stop_force(CYLINDER, -x, 0.2) for x in depths) * 1e-6
    # ½ k s² = 0.1 J; in: + c v s = 300*0.2*1e-3 = 0.06 J; out: no pull for the first 0.3 mm, then
    # ∫ from 0.3 to 1 mm of (2e5 x - 60) dx = 0.091 - 0.042 = 0.049 J
    assert entering == pytest.approx(0.16, rel=1e-6)
    assert leaving == pytest.approx(0.049, rel=1e-3)
    assert math.isfinite(entering)
    assert leaving < entering
