"""The carriage against its end caps."""

import math

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, simulate
from rodless_sim.physics import end_stop
from rodless_sim.physics.state import Motion

STIFFNESS = 2e5
END_STOP = end_stop.of(RigParameters())


def end_stop_force(position: float, velocity: float) -> float:
    """Force of the caps in N, whatever the pressures."""
    return end_stop.force(END_STOP, Motion(position, velocity, 4e5, 3e5))


@pytest.mark.parametrize("form", ["stribeck", "saturating"])
@pytest.mark.parametrize("voltage", [10.0, 0.0])
def test_carriage_comes_to_rest_where_the_cap_carries_the_force(form: str, voltage: float) -> None:
    """At rest the cap's k·depth balances the air's force to within the 36 N friction can hold."""
    rig = Rig(RigParameters({"friction.form": form}))
    rig.reset(0.1)
    state = rig.advance(voltage, 20.0)
    depth = state.position - 0.2 if voltage > 5.08 else -state.position
    assert depth > 0.0
    assert abs(state.velocity) < 1e-9
    assert abs(STIFFNESS * depth - abs(state.force)) <= 36.0 * (1.0 + 1e-9)


@pytest.mark.parametrize("voltage", [10.0, 0.0])
def test_without_static_friction_the_rest_depth_is_force_over_stiffness(voltage: float) -> None:
    """With next to no dry friction the carriage rests at stroke + F/k, to a nanometre."""
    wet = {
        f"friction.{side}.{name}": value
        for side in ("forward", "reverse")
        for name, value in (("static", 1e-5), ("coulomb", 1e-5), ("viscous", 500.0))
    }
    rig = Rig(RigParameters(wet))
    rig.reset(0.1)
    state = rig.advance(voltage, 10.0)
    depth = state.position - 0.2 if voltage > 5.08 else -state.position
    assert depth == pytest.approx(abs(state.force) / STIFFNESS, abs=1e-9)
    # 0.52 MPa over 490.87 mm² is 255.3 N: 1.28 mm into a cap of 2e5 N/m
    assert depth == pytest.approx(1.28e-3, rel=0.01)


def test_carriage_stays_near_the_stroke_when_it_is_slammed_end_to_end() -> None:
    """Full voltage back and forth at top speed never presses a cap deeper than 4 mm."""
    # ½ m v² + F d = ½ k d² with v < 1 m/s, F < 300 N gives d < 4.2 mm without damping
    voltages = np.tile(np.repeat([10.0, 0.0], 1500), 2)
    trace = simulate(RigParameters.preset("calibrated"), voltages, 1e-3, 0.1)
    assert trace.position.max() > 0.2
    assert trace.position.min() < 0.0
    assert trace.position.max() < 0.2042
    assert trace.position.min() > -0.0042


def test_end_stops_are_silent_within_the_stroke() -> None:
    """From end to end, both ends included, the caps exert no force at any speed."""
    for position in (0.0, 1e-9, 0.1, 0.2 - 1e-9, 0.2):
        for velocity in (-1.0, 0.0, 1.0):
            assert end_stop_force(position, velocity) == 0.0


@pytest.mark.parametrize("depth", [1e-9, 1e-5, 1e-3])
@pytest.mark.parametrize("velocity", [-5.0, -0.1, 0.0, 0.1, 5.0])
def test_end_stops_never_pull(depth: float, velocity: float) -> None:
    """However fast the carriage leaves the cap, the force points into the stroke or is zero."""
    assert end_stop_force(-depth, velocity) >= 0.0
    assert end_stop_force(0.2 + depth, velocity) <= 0.0


def test_end_stop_force_by_hand_and_the_same_at_both_ends() -> None:
    """0.5 mm deep, entering at 0.1 m/s: 2e5 · 0.5e-3 + 300 · 0.1 = 130 N, away from the cap."""
    assert end_stop_force(-0.5e-3, -0.1) == pytest.approx(130.0, rel=1e-12)
    assert end_stop_force(0.2005, 0.1) == pytest.approx(-130.0, rel=1e-9)


def test_an_impact_takes_energy_from_the_carriage() -> None:
    """Around a closed cycle in the cap, in and out at the same speeds, the force does net work < 0.

    Entering at speed v over depth s costs ∫(kx + cv)dx, leaving returns at most ∫(kx - cv)dx.
    """
    depths = [1e-3 * (i + 0.5) / 1000 for i in range(1000)]
    entering = sum(end_stop_force(-x, -0.2) for x in depths) * 1e-6
    leaving = sum(end_stop_force(-x, 0.2) for x in depths) * 1e-6
    # ½ k s² = 0.1 J; in: + c v s = 300*0.2*1e-3 = 0.06 J; out: no pull for the first 0.3 mm, then
    # ∫ from 0.3 to 1 mm of (2e5 x - 60) dx = 0.091 - 0.042 = 0.049 J
    assert entering == pytest.approx(0.16, rel=1e-6)
    assert leaving == pytest.approx(0.049, rel=1e-3)
    assert math.isfinite(entering)
    assert leaving < entering
