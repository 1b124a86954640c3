# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which edge joins which pressures: flows that must be equal, or vanish, whatever the valve."""

import pytest
from chamber_flows import flow_into_a, flow_into_b

from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings, supply_flow

SUPPLY, AMBIENT = 621325.0, 101325.0
ASSEMBLIES = ("reconciled", "printed")
# Wide open and half open, both ways, and just past closed.
VOLTAGES = (0.0, 3.0, 5.0, 5.2, 7.0, 10.0)


@pytest.fixture(params=ASSEMBLIES)
def plant(request: pytest.FixtureRequest) -> Plant:
    """Return the rig of the paper with either assembly of its valve."""
    return Plant.of(RigParameters({"valve.assembly": request.param}))


@pytest.mark.parametrize("voltage", VOLTAGES)
def test_what_leaves_the_supply_fills_chambers_that_vent_nothing(
    plant: Plant, voltage: float
) -> None:
    """With both chambers at ambient pressure nothing leaves by the exhausts: the sums are equal."""
    lands = openings(plant, voltage)
    into = flow_into_a(plant, lands, AMBIENT) + flow_into_b(plant, lands, AMBIENT)
    assert into > 0.0
    assert supply_flow(plant, lands, AMBIENT, AMBIENT) == pytest.approx(into, rel=1e-12)


@pytest.mark.parametrize("voltage", VOLTAGES)
def test_a_chamber_at_supply_pressure_takes_none(plant: Plant, voltage: float) -> None:
    """With one chamber at the supply's pressure, all of its flow enters the other one."""
    lands = openings(plant, voltage)
    only_b = supply_flow(plant, lands, SUPPLY, AMBIENT)
    assert only_b == pytest.approx(flow_into_b(plant, lands, AMBIENT), rel=1e-12)
    only_a = supply_flow(plant, lands, AMBIENT, SUPPLY)
    assert only_a == pytest.approx(flow_into_a(plant, lands, AMBIENT), rel=1e-12)
    assert supply_flow(plant, lands, SUPPLY, SUPPLY) == 0.0


@pytest.mark.parametrize("voltage", [0.0, 3.0, 7.0, 10.0])
def test_the_valve_fills_one_chamber_and_vents_the_other(plant: Plant, voltage: float) -> None:
    """Above the closed position A fills and B vents, below it the other way round.

    At the pressures in the middle the open edges pass far more than the gaps.
    """
    lands = openings(plant, voltage)
    side = 1.0 if voltage > 5.08 else -1.0
    assert side * flow_into_a(plant, lands, 3.6e5) > 1e-5
    assert side * flow_into_b(plant, lands, 3.6e5) < -1e-5


@pytest.mark.parametrize(("one", "other"), [(0.08, -0.08), (1.9, -1.9), (4.9, -4.9)])
def test_the_reconciled_valve_is_the_same_both_ways_but_for_its_area(
    one: float, other: float
) -> None:
    """With an area curve that is even about closed, exchanging the ways exchanges the chambers."""
    even = (1e-6, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0)
    # A sine's minimum at the centre of the curve: 0.5 · 5.2416 + phase = -π/2.
    phase = -1.5707963267948966 - 0.5 * 5.2416
    plant = Plant.of(
        RigParameters({"valve.area_coefficients": (even[0], even[1], phase, *even[3:])})
    )
    there, back = openings(plant, 5.08 + one), openings(plant, 5.08 + other)
    for pressure in (1.2e5, 3.6e5, 6e5):
        assert flow_into_a(plant, there, pressure) == pytest.approx(
            flow_into_b(plant, back, pressure), rel=1e-9
        )
