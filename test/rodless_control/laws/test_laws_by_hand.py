# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Each law's equation, worked out from what it knows after a sample, and what it begins with.

What the filter, the parts and the model of valve and chambers give is tested beside those.
"""

import math
from typing import Any

import pytest

from rodless_control import Measurement, ReferencePoint
from rodless_control.laws import adrc, cascade, law_class
from rodless_control.laws.parts import fading_memory, pneumatics
from rodless_control.laws.parts.dead_zone import DeadZone
from rodless_control.laws.parts.effort import Valve
from rodless_control.laws.parts.fading_memory import Motion
from rodless_control.laws.parts.saturation import Limits

INTERVAL = 1e-3
START = Measurement(0, 0.05, 3.2e5, 3.0e5, 6e5)
AREA = math.pi / 4.0 * 0.025**2

# Nothing parks, integrates or holds; what crosses the valve's dead zone is not in the effort.
PLAIN = {"parking_error": 0.0, "integral_gain": 0.0}


def law_of(name: str, **gains: float) -> Any:
    """Return a law of which all but ``gains`` is as it is by default."""
    return law_class(name)({f"{name}.{gain}": value for gain, value in gains.items()})


def moved(law: Any) -> tuple[Any, Any, Any]:
    """Let a law see a carriage that lags behind a reference that speeds up.

    Returns its memory before and after the last sample, and its answer to that.
    """
    for k in range(40):
        before = law.memory if k else None
        time = k * INTERVAL
        position = 0.05 + 0.5 * 0.6 * time**2 + 2e-6 * (-1) ** k
        measurement = Measurement(
            k * 1_000_000, position, 3.2e5 + 4e5 * time, 3.0e5 - 3e5 * time, 6e5
        )
        reference = ReferencePoint(0.0501 + 0.5 * 0.8 * time**2, 0.8 * time)
        command = law.update(measurement, reference, INTERVAL if k else 0.0)
    return before, law.memory, command


def estimated(law: Any, before: Any, after: Any, acceleration: float) -> None:
    """Check that the filter was told of ``acceleration`` (m/s²), and that this matters."""
    known, position = before.known.motion, after.known.measurement.position
    bandwidth = law.gains.follower.filter_bandwidth
    found, without = (
        fading_memory.estimated(bandwidth, known, position, told, INTERVAL)
        for told in (acceleration, 0.0)
    )
    assert after.known.motion == pytest.approx(found, rel=1e-9)
    assert abs(found.velocity - without.velocity) > 1e-5


def errors(known: Any) -> tuple[float, float, float]:
    """Of position, velocity and acceleration; each is large enough to matter."""
    found = (
        known.reference.position - known.motion.position,
        known.reference.velocity - known.motion.velocity,
        known.reference_acceleration - known.motion.acceleration,
    )
    assert all(abs(error) > 1e-5 for error in found)
    return found


def test_active_disturbance_rejection() -> None:
    """U = (ω² e + 2 ω ė + r̈ − d̂)/b₀, d̂ what the filter finds beyond b₀ times the effort left."""
    law = law_of("adrc", parking_error=0.0, bandwidth=17.0, input_gain=6.0)
    before, memory, command = moved(law)
    error, velocity, acceleration = errors(memory.known)
    expected = (17.0**2 * error + 2.0 * 17.0 * velocity + acceleration) / 6.0
    assert command.effort == pytest.approx(expected, rel=1e-9)
    estimated(law, before, memory, 6.0 * before.applied)
    assert memory.applied == pytest.approx(expected, rel=1e-9)
    assert law.USES_PRESSURES is False


def test_active_disturbance_rejection_counts_what_the_limits_leave() -> None:
    """0 to 10 V about 4.5 V with 0.7 V crossed: from -3.8 to 4.8 V; nothing within the zone."""
    valve = Valve(DeadZone(0.7, 0.1), Limits(4.5, 0.0, 10.0))
    found = [adrc.left_of(valve, wanted) for wanted in (-9.0, -3.5, 0.3, 4.0, 9.0)]
    assert found == pytest.approx([-3.8, -3.5, 0.3, 4.0, 4.8], rel=1e-12)
    upward = Valve(DeadZone(0.7, 0.1), Limits(5.08, 4.9, 10.0))
    assert [adrc.left_of(upward, wanted) for wanted in (-1.0, 0.3)] == [0.0, 0.3]
    narrow = Valve(DeadZone(0.7, 0.1), Limits(5.08, 4.9, 5.3))
    assert [adrc.left_of(narrow, wanted) for wanted in (-1.0, 0.0, 1.0)] == [0.0, 0.0, 0.0]
    law = law_of("adrc")
    assert adrc.begin(law.gains, START).applied == 0.0


def test_state_feedback() -> None:
    """K_p e + K_v ė + K_a ë + F_v ṙ + F_a r̈ − K_Δ (Δ − its slow part)."""
    gains = {
        "position_gain": 170.0,
        "velocity_gain": 13.0,
        "acceleration_gain": 0.3,
        "velocity_feedforward": 7.0,
        "acceleration_feedforward": 0.11,
        "pressure_damping": 2e-6,
        "pressure_bandwidth": 25.0,
    }
    law = law_of("state_feedback", **PLAIN, **gains)
    _, memory, command = moved(law)
    error, velocity, acceleration = errors(memory.known)
    slow = 2e4
    for k in range(1, 40):
        slow += (1.0 - math.exp(-25.0 * INTERVAL)) * (2e4 + 7e5 * k * INTERVAL - slow)
    assert memory.slow_difference == pytest.approx(slow, rel=1e-9)
    damping = -2e-6 * (2e4 + 7e5 * 39 * INTERVAL - slow)
    assert command.damping == pytest.approx(damping, rel=1e-9)
    assert abs(damping) > 1e-3
    expected = (
        170.0 * error
        + 13.0 * velocity
        + 0.3 * acceleration
        + 7.0 * memory.known.reference.velocity
        + 0.11 * memory.known.reference_acceleration
        + damping
    )
    assert command.effort == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("layer", [0.02, 1e-4])
def test_sliding_mode(layer: float) -> None:
    """K sat(s/φ) + F_a r̈ + friction, s = e + ė/λ; within the layer and beyond it."""
    gains = {
        "surface_bandwidth": 31.0,
        "reaching_voltage": 3.0,
        "boundary_layer": layer,
        "acceleration_feedforward": 0.13,
        "static_friction": 0.0,
        "coulomb_friction": 0.0,
        "viscous_friction": 0.0,
    }
    law = law_of("sliding_mode", **PLAIN, **gains)
    _, memory, command = moved(law)
    error, velocity, _ = errors(memory.known)
    surface = error + velocity / 31.0
    assert command.surface == pytest.approx(surface, rel=1e-9)
    share = min(surface / layer, 1.0)
    assert (share == 1.0) == (layer == 1e-4)
    expected = 3.0 * share + 0.13 * memory.known.reference_acceleration
    assert command.effort == pytest.approx(expected, rel=1e-9)
    assert law.USES_PRESSURES is False


CASCADE = {
    "mass": 1.3,
    "position_gain": 700.0,
    "velocity_gain": 40.0,
    "rejection": 0.6,
    "static_friction": 0.0,
    "coulomb_friction": 0.0,
    "viscous_friction": 0.0,
    "pressure_lag": 5e-3,
    "force_bandwidth": 300.0,
}


def test_cascade_demands_a_force() -> None:
    """F_d = M (r̈ + K_v ė + K_p e − K_d â), and knows the force without its transmitters' lag."""
    law = law_of("cascade", **PLAIN, **CASCADE)
    before, memory, command = moved(law)
    known = memory.known
    error, velocity, _ = errors(known)
    expected = 1.3 * (
        known.reference_acceleration
        + 40.0 * velocity
        + 700.0 * error
        - 0.6 * known.motion.acceleration
    )
    assert command.demanded_force == pytest.approx(expected, rel=1e-9)
    assert abs(known.motion.acceleration) > 1e-2
    assert command.force == pytest.approx(
        memory.force.position + 5e-3 * memory.force.velocity, rel=1e-9
    )
    estimated(law, before, memory, command.force / 1.3)


def test_cascade_asks_for_the_rate_that_brings_the_force_there() -> None:
    """Ḟ = K_F (F_d − F) + Ḟ_d by the model of valve and chambers."""
    law = law_of("cascade", **PLAIN, **CASCADE, force_gain=55.0)
    for k in range(40):
        before = law.memory if k else None
        time = k * INTERVAL
        measurement = Measurement(
            k * 1_000_000, 0.05 + 0.3 * time**2, 3.2e5 + 2e4 * time, 3.0e5, 6e5
        )
        reference = ReferencePoint(0.05 + 0.31 * time**2, 0.62 * time)
        command = law.update(measurement, reference, INTERVAL if k else 0.0)
    assert before is not None
    demand = fading_memory.estimated(300.0, before.demand, command.demanded_force, 0.0, INTERVAL)
    assert law.memory.demand == demand
    rate = 55.0 * (command.demanded_force - command.force) + demand.velocity
    motion = law.memory.known.motion
    expected = 5.08 + pneumatics.deflection_for(
        law.gains.model, measurement, motion.position, motion.velocity, rate
    )
    assert 0.0 < expected < 10.0
    assert command.voltage == pytest.approx(expected, rel=1e-9)


def test_cascade_begins_with_friction_that_holds() -> None:
    """At rest under a push of 20 kPa on the piston: the disturbance takes all of it."""
    law = law_of("cascade", **CASCADE)
    memory = cascade.begin(law.gains, START)
    push = AREA * 2e4
    assert memory.force == Motion(pytest.approx(push, rel=1e-9), 0.0, 0.0)
    assert memory.demand == Motion(0.0, 0.0, 0.0)
    held = Motion(0.05, 0.0, pytest.approx(-push / 1.3, rel=1e-9))
    assert memory.known.motion == held
    assert memory.known.reference == ReferencePoint(0.05, 0.0)
