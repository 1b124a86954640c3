# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The gains of ``calibrated`` on two hundred rigs around it: docs/calibrated.md.

The rigs are drawn as those of the task `pid`, by two other seeds, a hundred each: mass, supply,
friction and dead volumes vary, half of them have bristles, and all have heat, a spool with
hysteresis and noisy instruments.
"""

from collections import Counter

import numpy as np
import pytest
from extent import extensive
from fresh_rigs import RIGS, SEEDS, fresh, fresh_rigs

from rodless_control import PidParameters
from rodless_lab.simulation.ensemble import Ensemble, ensemble
from rodless_lab.studies.study import Study
from rodless_lab.studies.tuning_task import read_task
from rodless_sim import RigParameters

pytestmark = pytest.mark.slow

LATE = 1e-3  # s
PID = PidParameters.preset("calibrated")
TRIALS = {trial.name: trial.study for trial in read_task("pid").trials}
STEP, SINE = TRIALS["step"], TRIALS["sine"]


def drawn(study: Study, seed: int, dead_time: float) -> list[RigParameters]:
    """A hundred rigs that no search has seen, with a valve that answers late."""
    return [rig.with_values({"valve.dead_time": dead_time}) for rig in fresh_rigs(study, seed)]


def controlled(
    study: Study, seed: int, period: float = 1e-3, dead_time: float = 0.0, duration: float = 2.1
) -> Ensemble:
    """The runs of a study on a hundred rigs; none fails."""
    rigs = drawn(study, seed, dead_time)
    found = ensemble(rigs, PID, study.base.reference, duration, period, since=study.base.since)
    assert len(found) == RIGS
    assert not found.failures
    return found


def count(found: Ensemble, figure: str, most: float) -> int:
    """On how many rigs the size of a figure is at most ``most``; none at all is no size."""
    return int(np.sum(np.abs(found[figure]) <= most))


def test_the_rigs_are_those_that_the_gains_are_for() -> None:
    """Each range is used up to a tenth of its ends; heat, spool, hysteresis, bristles and noise."""
    rigs = drawn(STEP, SEEDS[0], 0.0)
    for name, low, high in (
        ("cylinder.moving_mass", 0.7, 2.0),
        ("supply.pressure", 501325.0, 701325.0),
        ("cylinder.dead_volume_a", 1e-5, 3e-5),
        ("cylinder.dead_volume_b", 1e-5, 3e-5),
        ("friction.forward.static", 0.7 * 29.0, 1.3 * 29.0),
    ):
        values = [rig.number(name) for rig in rigs]
        tenth = 0.1 * (high - low)
        assert low <= min(values) < low + tenth
        assert high - tenth < max(values) <= high
    assert Counter(rig["friction.dynamics"] for rig in rigs) == {"static": 50, "lugre": 50}
    for rig in rigs:
        assert rig["chambers.thermodynamics"] == "energy_balance"
        assert rig["valve.dynamics"] == "second_order"
        assert rig["valve.hysteresis"] == 0.004
        assert rig["sensors.position_noise"] == 2e-5


@extensive
@fresh
def test_steps_end_at_the_target_and_stay(seed: int) -> None:
    """58 mm: to 0.2 mm in 0.35 s, within 50 µm, no overshoot over 0.2 mm; few hunt, valves rest."""
    found = controlled(STEP, seed)
    assert count(found, "mean_error", 50e-6) >= 97
    # An amplitude: 0.05 mm from peak to peak.
    assert count(found, "limit_cycle", 25e-6) >= 97
    assert count(found, "settling_time", 0.35) >= 90
    assert count(found, "overshoot", 0.2e-3) == RIGS
    assert count(found, "chatter", 0.05) >= 97


@extensive
@fresh
def test_a_millisecond_more_of_delay_costs_little(seed: int) -> None:
    """The command arrives 1 ms later: as before, but to 0.2 mm in 0.5 s."""
    found = controlled(STEP, seed, dead_time=LATE)
    assert count(found, "mean_error", 50e-6) >= 97
    assert count(found, "limit_cycle", 25e-6) >= 97
    assert count(found, "settling_time", 0.5) >= 90
    assert count(found, "overshoot", 0.2e-3) == RIGS
    assert count(found, "chatter", 0.05) >= 95


@fresh
def test_at_200_hz_it_still_arrives(seed: int) -> None:
    """A fifth of the samples: within 60 µm on 95 rigs."""
    assert count(controlled(STEP, seed, period=5e-3), "mean_error", 60e-6) >= 95


@fresh
@pytest.mark.parametrize(("dead_time", "most"), [(0.0, 1.0e-3), (LATE, 1.4e-3)])
def test_a_sine_is_followed(seed: int, dead_time: float, most: float) -> None:
    """20 mm at 0.381 Hz, a whole period: at most 1.0 mm off on 90 rigs, 1 ms later 1.4 mm."""
    found = controlled(SINE, seed, dead_time=dead_time, duration=4.2)
    assert count(found, "peak_error", most) >= 90
