# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What flows through the valve into each chamber, kg/s."""

from rodless_sim.physics.lands import Lands
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import inflow_a, inflow_b


def flow_into_a(plant: Plant, lands: Lands, pressure: float) -> float:
    """Return the flow into chamber A at ``pressure`` (Pa)."""
    return float(inflow_a(plant, lands, pressure).mass_flow)


def flow_into_b(plant: Plant, lands: Lands, pressure: float) -> float:
    """Return the flow into chamber B at ``pressure`` (Pa)."""
    return float(inflow_b(plant, lands, pressure).mass_flow)
