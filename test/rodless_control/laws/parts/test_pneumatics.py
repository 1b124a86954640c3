# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The nominal model of valve and air: its inverse, and how near it is to the rig."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from rodless_control import Measurement
from rodless_control.laws.cascade import Cascade
from rodless_control.laws.parts import pneumatics
from rodless_control.laws.parts.pneumatics import Pneumatics
from rodless_sim import RigParameters
from rodless_sim.physics.equations import inflows, pressure_rates
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.state import Motion
from rodless_sim.physics.valve import centred_area, flow_coefficient

MODEL = Pneumatics.of(Cascade.Parameters(), "cascade")


def force_rate(measurement: Measurement, position: float, velocity: float, volts: float) -> float:
    """Force rate (N/s) of the model as the head of its file writes it, in plain Python."""
    a, b, supply = measurement.pressure_a, measurement.pressure_b, measurement.supply_pressure
    area = MODEL.piston_area
    volume_a = MODEL.dead_volume + area * position
    volume_b = MODEL.dead_volume + area * (MODEL.stroke - position)
    flow = pneumatics.specific_flow
    if volts >= 0.0:
        rate = flow(supply, a) / volume_a + flow(b, 101325.0) / volume_b
    else:
        rate = flow(a, 101325.0) / volume_a + flow(supply, b) / volume_b
    square = volts * volts
    opening = MODEL.valve_curvature * square / (1.0 + square / MODEL.valve_saturation**2)
    index = MODEL.polytropic_index
    heat = index * area * pneumatics.GAS_CONSTANT * pneumatics.TEMPERATURE
    motion = index * area**2 * velocity * (a / volume_a + b / volume_b)
    return math.copysign(opening, volts) * heat * rate - motion


def random_states(count: int) -> list[tuple[Measurement, float, float]]:
    """Measurements with position (m) and velocity (m/s) that a rig can be in."""
    generator = np.random.default_rng(3)
    return [
        (
            Measurement(0, 0.0, *generator.uniform(1.5e5, 5.5e5, 2).tolist(), 6e5),
            float(generator.uniform(0.0, 0.2)),
            float(generator.uniform(-0.4, 0.4)),
        )
        for _ in range(count)
    ]


def test_the_inverse_is_that_of_a_bisection() -> None:
    """The root that scipy finds of the force rate, for 300 random states and rates within reach."""
    generator = np.random.default_rng(4)
    for measurement, position, velocity in random_states(300):
        volts = float(generator.uniform(-4.9, 4.9))
        rate = force_rate(measurement, position, velocity, volts)
        found = pneumatics.deflection_for(MODEL, measurement, position, velocity, rate)
        expected = brentq(
            lambda x, m=measurement, y=position, v=velocity, r=rate: force_rate(m, y, v, x) - r,
            -5.0,
            5.0,
            xtol=1e-13,
        )
        assert found == pytest.approx(expected, abs=1e-7)
        assert found == pytest.approx(volts, abs=1e-7)


def test_beyond_reach_the_valve_opens_in_full() -> None:
    """A rate that the supply cannot give, and one with no air to give it at all."""
    measurement = Measurement(0, 0.1, 3e5, 3e5, 6e5)
    empty = Measurement(0, 0.1, 3e5, 1e5, 2e5)  # forward nothing flows in, nor out
    for sample, rate in ((measurement, 1e9), (empty, 1e3)):
        assert pneumatics.deflection_for(MODEL, sample, 0.1, 0.0, rate) == 5.0
        assert pneumatics.deflection_for(MODEL, sample, 0.1, 0.0, -1e9) == -5.0


def test_opening_and_deflection_undo_each_other() -> None:
    """From closed to 4.9 V, either way; a quarter of the curvature's area at half a volt."""
    for volts in np.linspace(-4.9, 4.9, 99):
        area = pneumatics.opening(MODEL, float(volts))
        assert pneumatics.deflection(MODEL, area) == pytest.approx(volts, abs=1e-12)
    flat = MODEL._replace(valve_saturation=1e9)
    assert pneumatics.opening(flat, 0.5) == pytest.approx(0.25 * MODEL.valve_curvature, rel=1e-9)


def test_its_flow_is_nearly_that_of_an_ideal_nozzle() -> None:
    """Within 1.5 % of the largest flow at any ratio of the pressures, exact where it is choked."""
    supply, gas = 6e5, 287.05 * 293.15
    choked = math.sqrt(1.4) * (2.0 / 2.4) ** 3 * supply / math.sqrt(gas)
    for ratio in np.linspace(0.05, 1.0, 96):
        r = max(float(ratio), (2.0 / 2.4) ** 3.5)
        psi = math.sqrt(max(2.0 * 1.4 / 0.4 * (r ** (2.0 / 1.4) - r ** (2.4 / 1.4)), 0.0))
        found = pneumatics.specific_flow(supply, float(ratio) * supply)
        assert found == pytest.approx(psi * supply / math.sqrt(gas), abs=0.015 * choked)
        assert pneumatics.specific_flow(float(ratio) * supply, supply) == -found
    assert pneumatics.specific_flow(supply, 1e5) == pytest.approx(choked, rel=1e-12)


def test_its_valve_is_nearly_the_paper_s() -> None:
    """Within 4 % of C_v·S of eqs. (5) and (25) from 0.25 to 3 V, either way."""
    valve = Plant.of(RigParameters()).valve
    for volts in (0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0):
        for side in (1.0, -1.0):
            expected = flow_coefficient(valve, side * volts) * centred_area(valve, side * volts)
            found = pneumatics.opening(MODEL, side * volts)
            assert abs(found) == pytest.approx(expected, rel=0.04)


def test_its_force_rate_is_nearly_the_rig_s() -> None:
    """Within 4 % or 40 N/s of what the rig's own equations give for the same chambers, 0.5-3 V.

    What leaks past the closed edges is not in the model.
    """
    rig = RigParameters(
        {
            "cylinder.dead_volume_a": MODEL.dead_volume,
            "cylinder.dead_volume_b": MODEL.dead_volume,
            "chambers.thermodynamics": "polytropic",
            "chambers.polytropic_index": MODEL.polytropic_index,
            "supply.pressure": 6e5,
        }
    )
    plant = Plant.of(rig)
    for measurement, position, _ in random_states(20):
        a, b = measurement.pressure_a, measurement.pressure_b
        state = Motion(position, 0.0, a, b)
        for volts in (-3.0, -1.0, -0.5, 0.5, 1.0, 3.0):
            flows = inflows(plant, openings(plant, 5.08 + volts), state)
            rate_a, rate_b = pressure_rates(plant, state, flows, 0.0)
            expected = MODEL.piston_area * (rate_a.rate - rate_b.rate)
            assert force_rate(measurement, position, 0.0, volts) == pytest.approx(
                expected, rel=0.04, abs=40.0
            )
