# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Identification from a base with options that the paper has not: they are part of the model."""

import numpy as np
import pytest

from rodless_lab.identification.excitation import friction_voltages
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.valve import identify_valve, valve_findings
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate

LOCKED = {"cylinder.locked": True}
VOLTAGES = [5.7] * 500 + [4.6] * 500
SUPPLY = 621325.0


def test_the_valve_of_a_base_with_iso_6358_gets_its_conductance() -> None:
    """A valve of 3.3 dm³/(s·MPa), taken for 3.9: C is found to 1 %, and no area curve is written.

    The closed position is off by 30 mV too, which moves the widest opening that C belongs to.
    """
    base = RigParameters({**LOCKED, "valve.flow_law": "iso_6358"})
    rig = base.with_values({"valve.sonic_conductance": 3.3e-9, "valve.closed_voltage": 5.05})
    run = run_of_trace(simulate(rig, VOLTAGES, 1e-3, position=0.06), SUPPLY)
    fit = identify_valve(run, base)
    found = {finding.name: finding.value for finding in valve_findings(fit)}
    assert found["valve.sonic_conductance"] == pytest.approx(3.3e-9, rel=0.01)
    assert found["valve.closed_voltage"] == pytest.approx(5.05, abs=2e-3)
    assert "valve.area_coefficients" not in found


@pytest.mark.parametrize(
    "options",
    [
        {"leak.across": 2e-8, "leak.a": 1e-8},
        {"chambers.thermodynamics": "polytropic", "chambers.polytropic_index": 1.1},
        {"valve.discharge": "constant", "valve.discharge_coefficient": 0.8},
        {"chambers.thermodynamics": "energy_balance"},
    ],
    ids=lambda options: next(iter(options)),
)
def test_chambers_of_a_base_with_options(options: dict[str, object]) -> None:
    """Dead volumes come out within 1 % where the base has what the rig has."""
    base = RigParameters({**LOCKED, **options})
    rig = base.with_values({"cylinder.dead_volume_a": 20e-6})
    run = run_of_trace(simulate(rig, VOLTAGES, 1e-3, position=0.06), SUPPLY)
    estimates = identify_chambers(run, base).estimates
    assert estimates["cylinder.dead_volume_a"].value == pytest.approx(20e-6, rel=0.01)
    assert estimates["cylinder.dead_volume_b"].value == pytest.approx(15e-6, rel=0.01)


def test_friction_of_a_base_with_a_tilted_rail() -> None:
    """0.2 rad under 1 kg are 1.95 N: in F_c where the base is level, and not where it is tilted."""
    rig = RigParameters({"rail.tilt": 0.2})
    run = run_of_trace(simulate(rig, friction_voltages(), 1e-3, position=0.06), SUPPLY)
    true = rig.number("friction.forward.coulomb")
    for base, weight in ((rig, 0.0), (RigParameters(), 9.80665 * np.sin(0.2))):
        found = identify_friction(run, base).forward.coulomb.value
        assert found == pytest.approx(true + weight, abs=0.2)
