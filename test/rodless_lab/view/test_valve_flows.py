# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The flows that a page draws are those that the rig is computed with."""

import pytest

from rodless_lab.view.valve_flows import ValveFlows, spool_voltage
from rodless_sim import Rig, RigParameters
from rodless_sim.physics.valve import spool_displacement

# kg/s of a free-air flow in L/min at 20 °C and one atmosphere, as the parameters have them.
KILOGRAMS = 101325.0 / (287.0 * 293.15) / 6e4


@pytest.mark.parametrize("voltage", [3.0, 5.0, 5.6, 8.0])
@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
def test_the_edges_add_up_to_what_the_chambers_receive(voltage: float, assembly: str) -> None:
    """What comes from the supply and does not leave through an exhaust is in the chambers."""
    parameters = RigParameters().with_values({"valve.assembly": assembly})
    rig = Rig(parameters)
    state = rig.advance(voltage, 0.05)
    found = ValveFlows(parameters).at(
        voltage, state.pressure_a, state.pressure_b, parameters.number("supply.pressure")
    )
    supplied = found.supply_to_a + found.supply_to_b
    assert supplied == pytest.approx(rig.free_air_flow * 6e4, rel=1e-9)
    ratio = state.mass_flow_a / (found.supply_to_a - found.a_to_exhaust)
    assert ratio == pytest.approx(KILOGRAMS, rel=5e-3)
    assert state.mass_flow_b / (found.supply_to_b - found.b_to_exhaust) == pytest.approx(
        ratio, rel=1e-6
    )


@pytest.mark.parametrize("voltage", [0.0, 5.08, 10.0])
def test_where_the_spool_is_tells_its_voltage(voltage: float) -> None:
    """The other way round than the plant has it, which publishes metres."""
    assert spool_voltage(spool_displacement(voltage)) == pytest.approx(voltage, abs=1e-12)


def test_above_the_closed_voltage_a_is_filled_and_b_emptied() -> None:
    """And a voltage beyond the valve's range is its limit."""
    flows = ValveFlows(RigParameters())
    at = (2e5, 4e5, 6e5)
    forward = flows.at(10.0, *at)
    assert forward.supply_to_a > 10.0 * forward.supply_to_b
    assert forward.b_to_exhaust > 10.0 * forward.a_to_exhaust
    assert flows.at(12.0, *at) == forward
