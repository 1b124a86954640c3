# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The chambers alone against the plant: its own integrator, which takes other steps."""

import numpy as np
import pytest
from extent import extensive

from rodless_lab.identification.excitation import chamber_voltages, spool_voltages, steps
from rodless_lab.identification.pressures.problem import Problem
from rodless_lab.runs.measured_run import run_of_trace
from rodless_sim import RigParameters, simulate

PULSES = steps(*((5.08 + size, 0.02) for size in (0.5, -0.5, 1.0, -1.0, 2.0, -2.0, 4.5, -4.5)))
VOLTAGES = np.concatenate([chamber_voltages(), PULSES])


@extensive
@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "damping"), [(60.0, 0.4), (115.0, 0.7), (1000.0, 0.5)])
def test_the_chambers_follow_a_busy_spool(frequency: float, damping: float) -> None:
    """Square waves up to 167 Hz about closed: within 10 Pa of the plant integrated finely.

    The spool crosses the dead zone hundreds of times; what each crossing loses would add up.
    """
    rig = RigParameters(
        {
            "valve.dynamics": "second_order",
            "valve.natural_frequency": frequency,
            "valve.damping": damping,
            "valve.dead_time": 1.4e-3,
            "time.tolerance": 0.01,
        }
    )
    trace = simulate(rig, spool_voltages(), 1e-3, position=0.06)
    run = run_of_trace(trace, rig.number("supply.pressure"))
    problem = Problem(run, rig, [])
    begun = problem.start.copy()
    begun[-5:-3] = run.pressure_a[0], run.pressure_b[0]
    apart = problem.modelled(begun) - np.stack([run.pressure_a, run.pressure_b], axis=1)
    assert np.abs(apart).max() < 10.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [
        {},
        {"valve.hysteresis": 4e-3},
        {"valve.dead_time": 1.3e-3},
        {"valve.dynamics": "second_order", "valve.dead_time": 2e-3, "valve.hysteresis": 2e-3},
    ],
    ids=["at once", "hysteresis", "dead time", "dynamics"],
)
def test_the_chambers_follow_the_plants(values: dict[str, object]) -> None:
    """Along the plant's own motion both pressures agree within 30 Pa, 2 Pa root mean square."""
    rig = RigParameters(values)
    run = run_of_trace(simulate(rig, VOLTAGES, 1e-3, position=0.06), rig.number("supply.pressure"))
    problem = Problem(run, rig, [])
    begun = problem.start.copy()
    begun[-5:-3] = run.pressure_a[0], run.pressure_b[0]
    apart = problem.modelled(begun) - np.stack([run.pressure_a, run.pressure_b], axis=1)
    assert np.abs(apart).max() < 30.0
    assert np.std(apart) < 2.0
