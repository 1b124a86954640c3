# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A flow coefficient that is the same at any opening, and the rated flow as a data sheet has it."""

import pytest

from rodless_sim import RigParameters
from rodless_sim.physics.plant import Plant
from rodless_sim.physics.ports import edge_flow, openings

GAUGE = 101325.0
LITRES_PER_MINUTE = 60e3 / 1.185  # of free air, ISO 8778


def rated_flow(values: dict[str, object]) -> float:
    """Free air in L/min through the fully opened port, 6 bar gauge before and 5 bar behind it."""
    plant = Plant.of(RigParameters(values))
    opening = openings(plant, 10.0).opening
    return edge_flow(plant, opening, 6e5 + GAUGE, 5e5 + GAUGE) * LITRES_PER_MINUTE


@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
@pytest.mark.parametrize("law", ["nozzle", "iso_6358"])
def test_rated_flow_is_that_of_the_data_sheet(assembly: str, law: str) -> None:
    """100 L/min ± 10 % from 6 to 5 bar gauge (Festo MPYE-5-M5), for either law of flow.

    The printed assembly's own curve passes more: there is no smallest area taken off it.
    """
    chosen = {"valve.discharge": "constant", "valve.flow_law": law, "valve.assembly": assembly}
    high = 110.0 if assembly == "reconciled" or law == "iso_6358" else 120.0
    assert 90.0 < rated_flow(chosen) < high


@pytest.mark.parametrize("assembly", ["reconciled", "printed"])
@pytest.mark.parametrize("voltage", [0.0, 3.0, 6.0, 10.0])
def test_openings_are_the_coefficient_times_the_area(assembly: str, voltage: float) -> None:
    """The orifice at 0.9 is 0.9 times that at 1, at any voltage; the gaps stay."""
    values = {"valve.discharge": "constant", "valve.assembly": assembly}
    found, whole = (
        openings(Plant.of(RigParameters({**values, **more})), voltage)
        for more in ({}, {"valve.discharge_coefficient": 1.0})
    )
    assert whole.opening.orifice_area > 0.0
    assert found.opening.orifice_area == pytest.approx(0.9 * whole.opening.orifice_area, rel=1e-12)
    assert (found.opening.gap, found.closing) == (whole.opening.gap, whole.closing)


def test_the_polynomial_is_left_alone_until_the_constant_is_chosen() -> None:
    """A coefficient without the choice changes nothing."""
    plain = Plant.of(RigParameters())
    assert Plant.of(RigParameters({"valve.discharge_coefficient": 0.5})) == plain
