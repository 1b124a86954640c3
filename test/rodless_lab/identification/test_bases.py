# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which options a base may have: what the fit of pressures knows nothing of is refused by name."""

import numpy as np
import pytest

from rodless_base.parameters import ParameterError
from rodless_lab.identification.pressures.fit import solve
from rodless_lab.identification.pressures.unknowns import gap
from rodless_lab.runs.measured_run import MeasuredRun, UninformativeRunError, run_of_trace
from rodless_sim import RigParameters, simulate


@pytest.fixture(scope="module")
def still() -> MeasuredRun:
    """A rig at rest behind a closed valve: a run that tells nothing of the chambers."""
    rig = RigParameters()
    closed = rig.number("valve.closed_voltage")
    trace = simulate(rig, np.full(400, closed), 1e-3, position=0.06)
    return run_of_trace(trace, rig.number("supply.pressure"))


@pytest.mark.parametrize(
    "values",
    [
        {"tubes.model": "delay"},
        {"supply.ripple_amplitude": 1e3},
        {"supply.droop": 1e7},
        {"supply.kind": "compressor"},
    ],
)
def test_a_base_without_a_steady_supply_or_with_tubes_is_refused(
    still: MeasuredRun, values: dict[str, object]
) -> None:
    """Before anything is fitted."""
    base = RigParameters(values)
    with pytest.raises(ParameterError, match=r"supply\.droop, supply\.kind: refused"):
        solve(still, base, [gap(base)])


@pytest.mark.parametrize(
    "values",
    [{"coupling.kind": "magnetic"}, {"friction.dynamics": "lugre"}, {"friction.drift": 0.1}],
)
def test_what_acts_on_the_carriage_alone_is_not_refused(
    still: MeasuredRun, values: dict[str, object]
) -> None:
    """The carriage's motion is measured: all that is wrong here is that the run tells nothing."""
    base = RigParameters(values)
    with pytest.raises(UninformativeRunError, match="the pressures change by only"):
        solve(still, base, [gap(base)])
