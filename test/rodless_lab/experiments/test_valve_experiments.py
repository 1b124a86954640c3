# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Valve area and flow coefficient: the stand against hand calculation, noise, hidden valves."""

import math

import numpy as np
import pytest

from rodless_lab.experiments.flow_coefficient import run_flow_coefficient
from rodless_lab.experiments.valve_area import VOLTAGES, run_valve_area
from rodless_lab.experiments.valve_stand import Stand, bare_flow, port_flow, systematic_share
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET
from rodless_sim.physics.plant import Plant


def test_bare_flow_by_hand() -> None:
    """At 10 V and 0.4 MPa gauge: 1.926831 mm² · 0.501325 MPa · 0.684731 / √(287.05 · 297)."""
    plant = Plant.of(RigParameters({"supply.pressure": 0.4e6 + 101325.0}))
    (flow,) = bare_flow(plant, np.array([10.0]))
    by_hand = 1.926831e-6 * 501325.0 * 0.684731 / math.sqrt(287.05 * 297.0)
    assert flow == pytest.approx(by_hand, rel=1e-5)


def test_port_flow_of_the_printed_assembly_carries_its_coefficient() -> None:
    """Printed, C_v stays 1.132: the port passes that many times the flow of the bare area."""
    plant = Plant.of(RigParameters({"valve.assembly": "printed"}))
    voltages = np.array([0.5, 9.5])
    ratio = port_flow(plant, voltages) / bare_flow(plant, voltages)
    assert ratio == pytest.approx([1.132, 1.132], abs=1e-4)


def test_instruments_without_errors_read_the_truth() -> None:
    """With every sensors.* at zero the stand shows flow and pressure as they are."""
    stand = Stand.specimen(RigParameters(), seed=3)
    assert stand.flow(np.array([1e-3])) == pytest.approx([1e-3 / 1.185])
    assert stand.supply(5e5, 2) == pytest.approx([5e5, 5e5])
    assert systematic_share(RigParameters()) == 0.0


def test_systematic_share_by_hand() -> None:
    """1 % of the flow meter and 5 kPa of 0.5 MPa: 2 %."""
    sheet = RigParameters({"supply.pressure": 5e5, **DATA_SHEET})
    assert systematic_share(sheet) == pytest.approx(0.02)


@pytest.mark.parametrize("seed", range(2, 10))
def test_curves_come_back_whatever_the_noise(seed: int) -> None:
    """Not only with the noise of the report: all judged numbers hold for other draws as well."""
    rows = [*run_valve_area(seed).comparisons, *run_flow_coefficient(seed).comparisons]
    assert [row.quantity for row in rows if not row.holds] == []


def test_noise_is_there() -> None:
    """Two seeds give two measurements, three sweeps up and down each."""
    first, second = run_valve_area(1), run_valve_area(2)
    assert first.areas.shape == (3, 2, VOLTAGES.size)
    assert np.abs(first.areas - second.areas).max() > 1e-9


def test_a_wrong_coefficient_is_noticed() -> None:
    """Judged against a curve 5 % larger than the valve's, the experiment fails."""
    found = run_valve_area()
    wrong = type(found)(**{**vars(found), "truth": found.truth * 1.05})
    failed = [row.quantity for row in wrong.comparisons if not row.holds]
    assert "with noise: largest distance of the curve from eq. (5)" in failed
    assert "without noise: amplitude of sine 1" in failed
