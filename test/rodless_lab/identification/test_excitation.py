# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The voltages that show what is to be identified, also where the valve is closed elsewhere."""

import numpy as np
import pytest
from quiet_stop import Quiet

from rodless_lab.cli import drive
from rodless_lab.identification.excitation import EXCITATIONS, PERIOD, excitation
from rodless_sim import RigParameters, simulate


@pytest.mark.parametrize("subject", EXCITATIONS)
def test_a_valve_that_is_closed_elsewhere_moves_the_carriage_alike(subject: str) -> None:
    """Its areas follow the distance from where it is closed: within 1 µm and 10 Pa all along."""
    paths = []
    for closed in (5.08, 5.18):
        rig = RigParameters({"valve.closed_voltage": closed})
        paths.append(simulate(rig, excitation(subject, closed), PERIOD, position=0.06))
    one, other = paths
    assert np.ptp(one.pressure_a) > 1e4
    assert other.position == pytest.approx(one.position, abs=1e-6)
    assert other.pressure_a == pytest.approx(one.pressure_a, abs=10.0)


def test_a_voltage_at_which_no_valve_is_closed_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """One line with the range, exit code 2, and nothing is sent."""
    assert drive.main(["spool", "--closed-voltage", "7"], Quiet()) == 2
    assert capsys.readouterr() == (
        "",
        "valve.closed_voltage: 7.0 refused, must be from 4 to 6 (V)\n",
    )
