# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The pressures at which the flows through the valve balance, without a run in time."""

import math
from functools import partial
from typing import Any

import pytest
from chamber_flows import flow_into_a, flow_into_b
from scipy.optimize import brentq

from rodless_lab import draw
from rodless_lab.accuracy.random_rigs import case
from rodless_sim import RigParameters, SimulationError
from rodless_sim.physics.cylinder import volume_a, volume_b
from rodless_sim.physics.equations import inflows
from rodless_sim.physics.heat import wall_area
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import openings
from rodless_sim.physics.settled import settled_air, settled_motion, settled_pressures
from rodless_sim.physics.settled_chamber import (
    PRESSURE_ERROR,
    RELATIVE_ERROR,
    TEMPERATURE_ERROR,
    settled_chamber,
    settled_warm_chamber,
)
from rodless_sim.physics.state import HeatedMotion

SUPPLY, AMBIENT = 621325.0, 101325.0


@pytest.mark.parametrize("voltage", [0.0, 4.9, 5.08, 5.2, 10.0])
def test_nothing_flows_into_a_settled_chamber(voltage: float) -> None:
    """At both pressures the net flow is a millionth of what passes at half the supply, or less.

    The chamber that the valve fills is the fuller one.
    """
    plant = Plant.of(RigParameters())
    lands = openings(plant, voltage)
    a, b = settled_pressures(plant, voltage)
    assert AMBIENT < a < SUPPLY
    assert AMBIENT < b < SUPPLY
    # The flow grows by some 1e-12 kg/s for each pascal at the least.
    assert flow_into_a(plant, lands, a + 0.01) < 0.0 < flow_into_a(plant, lands, a - 0.01)
    assert flow_into_b(plant, lands, b + 0.01) < 0.0 < flow_into_b(plant, lands, b - 0.01)
    if voltage != 5.08:
        assert (a > b) == (voltage > 5.08)


@pytest.mark.parametrize("voltage", [2.0, 5.08, 8.0])
def test_a_valve_without_gaps_leaves_what_it_does_not_fill_at_ambient(voltage: float) -> None:
    """Closed it seals both chambers; open it fills one to the supply's pressure."""
    plant = Plant.of(RigParameters({"valve.gap_height": 0.0}))
    a, b = settled_pressures(plant, voltage)
    expected = {2.0: (AMBIENT, SUPPLY), 5.08: (AMBIENT, AMBIENT), 8.0: (SUPPLY, AMBIENT)}
    assert (a, b) == pytest.approx(expected[voltage], abs=1e-3)


@pytest.mark.parametrize("number", range(12))
def test_the_pressures_are_those_of_scipy_bit_for_bit(number: int) -> None:
    """Of random rigs, some at the ends of all ranges, at the closed valve and open ones."""
    parameters = case(number).parameters
    plant = Plant.of(parameters)
    ambient, supply = plant.ambient_pressure, plant.supply_pressure
    for voltage in (plant.valve.closed_voltage, 0.0, 4.9, 5.3, 9.0):
        lands = openings(plant, voltage)
        found = settled_pressures(plant, voltage)
        for flow, pressure in zip((flow_into_a, flow_into_b), found, strict=True):
            net = partial(flow, plant, lands)
            expected = (
                ambient
                if net(ambient) <= 0.0
                else brentq(net, ambient, supply, xtol=PRESSURE_ERROR, rtol=RELATIVE_ERROR)
            )
            assert pressure == expected


@pytest.mark.parametrize("voltage", [5.08, 4.9, 5.3, 0.0])
def test_warm_chambers_are_those_of_scipy_bit_for_bit(voltage: float) -> None:
    """Of random rigs whose walls have another temperature than the supply's air."""
    ranges = {
        "chambers.wall_temperature": (280.0, 320.0),
        "chambers.heat_transfer_coefficient": (5.0, 200.0),
        "supply.pressure": (4e5, 8e5),
        "cylinder.dead_volume_*": (5e-6, 5e-5),
    }
    for rig in draw(ranges, 8):
        plant = Plant.of(rig)
        found = settled_air(plant, voltage, 0.05)
        volumes = volume_a(plant.cylinder, 0.05), volume_b(plant.cylinder, 0.05)
        expected = [_warm(plant, voltage, chamber, volumes[chamber]) for chamber in (0, 1)]
        assert (found.pressure_a, found.temperature_a) == expected[0]
        assert (found.pressure_b, found.temperature_b) == expected[1]


def _warm(plant: Plant, voltage: float, chamber: int, volume: float) -> tuple[float, float]:
    """Return what a chamber settles at, by scipy's roots of its flow and of the heat it gains."""
    lands, heat = openings(plant, voltage), plant.heat
    wall, ambient, supply = heat.wall_temperature, plant.ambient_pressure, plant.supply_pressure

    def flow(pressure: float, temperature: float, beside: float) -> Any:
        own, other = (pressure, temperature), (ambient, beside)
        a, b = (own, other) if chamber == 0 else (other, own)
        return inflows(plant, lands, HeatedMotion(0.0, 0.0, a[0], b[0], a[1], b[1]))[chamber]

    def pressure(temperature: float) -> float:
        def net(tried: float) -> float:
            return float(flow(tried, temperature, temperature).mass_flow)

        if net(ambient) <= 0.0:
            return ambient
        return float(brentq(net, ambient, supply, xtol=PRESSURE_ERROR, rtol=RELATIVE_ERROR))

    def gained(temperature: float) -> float:
        carried = flow(pressure(temperature), temperature, wall).enthalpy_flow
        loss = heat.coefficient * wall_area(heat, volume)
        return float(carried + loss * (wall - temperature))

    known = plant.air.temperature, wall, heat.ambient_temperature
    low, high = min(known) - 1.0, max(known) + 1.0
    temperature = brentq(gained, low, high, xtol=TEMPERATURE_ERROR, rtol=RELATIVE_ERROR)
    return pressure(temperature), temperature


@pytest.mark.parametrize("chamber", [0, 1])
def test_a_warm_chamber_is_found_from_either_side_and_only_between(chamber: int) -> None:
    """The ends may change places, as for brentq; where neither side has the other sign, NaN."""
    plant = Plant.of(RigParameters({"chambers.thermodynamics": "energy_balance"}))
    plant = plant._replace(heat=plant.heat._replace(wall_temperature=320.0))
    lands = openings(plant, 5.2)
    found = settled_warm_chamber(plant, lands, chamber, 0.01, 280.0, 330.0)
    assert 293.0 < found[1] < 320.0
    turned = settled_warm_chamber(plant, lands, chamber, 0.01, 330.0, 280.0)
    assert turned == pytest.approx(found, rel=1e-9)
    for ends in ((280.0, 290.0), (325.0, 330.0)):
        assert all(map(math.isnan, settled_warm_chamber(plant, lands, chamber, 0.01, *ends)))


@pytest.mark.parametrize("chamber", [0, 1])
def test_a_supply_below_the_atmosphere_leaves_a_chamber_at_that(chamber: int) -> None:
    """Whatever opens, air only leaves."""
    plant = Plant.of(RigParameters())._replace(supply_pressure=9e4)
    lands = openings(plant, 8.0 if chamber == 0 else 2.0)
    assert settled_chamber(plant, lands, chamber, None) == plant.ambient_pressure


@pytest.mark.parametrize("field", ["supply_pressure", "ambient_pressure"])
@pytest.mark.parametrize("preset", ["paper", "calibrated"])
def test_a_chamber_whose_flow_is_no_number_is_refused(preset: str, field: str) -> None:
    """At either end of the pressures: none of them is taken for settled."""
    plant = Plant.of(RigParameters.preset(preset))._replace(**{field: math.nan})
    with pytest.raises(SimulationError, match=r"the chambers do not settle at 5\.08 V"):
        settled_motion(plant, 5.08, 0.05)
