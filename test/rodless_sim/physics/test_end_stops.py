"""The carriage against its end caps."""

import numpy as np
import pytest

from rodless_sim import Rig, RigParameters, simulate

STIFFNESS = 2e5


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
