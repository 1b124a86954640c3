# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The gains of ``calibrated`` on a hundred rigs around it: docs/calibrated.md, and what they miss.

The rigs are drawn as those of the task `pid`, by another seed.
"""

from dataclasses import replace

import numpy as np
import pytest

from rodless_control import PidParameters
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.studies.tuning_task import read_task
from rodless_sim import RigParameters

pytestmark = pytest.mark.slow

RIGS = 100
FRESH = 20221122
PID = PidParameters.preset("calibrated")


def rigs(task: str) -> list[RigParameters]:
    """A hundred rigs of a task that its search has not seen."""
    study = read_task(task).study
    fresh = replace(study, seed=FRESH, count=RIGS)
    assert fresh.seed != study.seed
    return [fresh.row(number).base.rig for number in range(RIGS)]


def controlled(task: str, period: float = 1e-3, **changes: float) -> Ensemble:
    """The runs of a task on its fresh rigs, with ``changes`` of all of them; none fails."""
    base = read_task(task).study.base
    values = {name.replace("__", "."): value for name, value in changes.items()}
    found = ensemble(
        (rig.with_values(values) for rig in rigs(task)),
        PID,
        base.reference,
        base.duration,
        period,
        since=base.since,
    )
    assert len(found) == RIGS
    assert not found.failures
    return found


def count(found: Ensemble, figure: str, most: float) -> int:
    """On how many rigs the size of a figure is at most ``most``; none at all is no size."""
    return int(np.sum(np.abs(found[figure]) <= most))


def test_steps_end_at_the_target_and_stay() -> None:
    """58 mm: within 50 µm on 97 rigs. A tenth hunts, and most pass the target by over 0.2 mm."""
    found = controlled("pid")
    assert count(found, "mean_error", 50e-6) >= 97
    assert count(found, "limit_cycle", 25e-6) >= 85  # an amplitude: 0.05 mm from peak to peak
    assert count(found, "settling_time", 0.65) >= 85
    assert count(found, "overshoot", 0.45e-3) >= 97
    assert count(found, "chatter", 0.05) >= 75


def test_a_millisecond_more_of_delay_costs_little() -> None:
    """The command arrives 1 ms later: still within 50 µm, the sine within 1.4 mm."""
    found = controlled("pid", valve__dead_time=1e-3)
    assert count(found, "mean_error", 50e-6) >= 97
    assert count(found, "limit_cycle", 25e-6) >= 80
    assert count(controlled("pid_sine", valve__dead_time=1e-3), "peak_error", 1.4e-3) >= 90


def test_at_200_hz_it_still_arrives() -> None:
    """A fifth of the samples: within 60 µm on 95 rigs."""
    assert count(controlled("pid", period=5e-3), "mean_error", 60e-6) >= 95


def test_a_sine_is_followed_within_a_millimetre() -> None:
    """20 mm at 0.381 Hz, its second period: at most 1.0 mm off on 90 rigs."""
    assert count(controlled("pid_sine"), "peak_error", 1.0e-3) >= 90
