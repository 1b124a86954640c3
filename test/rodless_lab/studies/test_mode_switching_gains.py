# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The gains of ``config/laws/mode_switching.yaml`` on two hundred rigs: docs/laws.md."""

import numpy as np
import pytest
from extent import extensive
from fresh_rigs import SEEDS, controlled, fresh, fresh_rigs

from rodless_control import PidParameters, references
from rodless_control.controller import Law
from rodless_lab.benchmark.laws.entries import tuned
from rodless_lab.simulation.ensemble import ensemble
from rodless_lab.studies.tuning_task import read_task

pytestmark = pytest.mark.slow

FOLLOWING = {trial.name: trial.study for trial in read_task("mode_switching").trials}
MOVING = {trial.name: trial.study for trial in read_task("cascade").trials}
PID = PidParameters.preset("calibrated")


def law() -> Law:
    """The law with the gains of its file."""
    return tuned("mode_switching").law


@extensive
@fresh
@pytest.mark.parametrize(
    ("trial", "most", "worst"),
    [("sine", 0.30, 0.40), ("late", 0.30, 0.45), ("low friction", 0.32, 0.50)],
)
def test_a_sine_is_followed(seed: int, trial: str, most: float, worst: float) -> None:
    """20 mm at 0.381 Hz, late and slippery too: within so many mm on 90 rigs, and on all."""
    found = controlled(FOLLOWING[trial], seed, law(), 3.6)["peak_error"] * 1e3
    assert np.sum(found <= most) >= 90
    assert found.max() <= worst


class RestsFirst:
    """A jump by 20 mm, ten seconds of rest, then a sine about there."""

    def sample(self, time: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) at ``time`` (s)."""
        if time < 10.0:
            return (0.1 if time < 0.1 else 0.12), 0.0
        return SINE.sample(time)


SINE = references.sine(0.12, 0.02, 0.381, at=10.0)


@fresh
def test_a_long_rest_is_forgotten(seed: int) -> None:
    """Nothing has wound up meanwhile: 0.9 s after the sine's start it is followed as ever."""
    rigs = fresh_rigs(FOLLOWING["sine"], seed)
    found = ensemble(rigs, law(), RestsFirst(), 13.5, since=10.9)["peak_error"] * 1e3
    assert np.sum(found <= 0.37) >= 90
    assert found.max() <= 0.5


@fresh
def test_no_limit_cycle_with_friction_halved(seed: int) -> None:
    """58 mm: none moves on and on. All end within 50 µm, and leave the valve in peace.

    A carriage that creeps may break loose once more, so one hop is no cycle: two seconds are looked
    at, three seconds apart.
    """
    runs = [controlled(MOVING["low friction"], seed, law(), seconds) for seconds in (6.1, 9.1)]
    # An amplitude: 0.05 mm from peak to peak.
    moved = [np.abs(found["limit_cycle"]) > 25e-6 for found in runs]
    assert not np.any(moved[0] & moved[1])
    assert np.sum(moved) <= 2
    for found in runs:
        assert np.all(np.abs(found["mean_error"]) <= 50e-6)
        assert np.all(np.abs(found["chatter"]) <= 0.05)


def test_steps_are_those_of_the_preset() -> None:
    """Bit for bit: what test_calibrated_gains holds of the PID holds of this law."""
    one, other = (controlled(MOVING["step"], SEEDS[0], by, 1.0) for by in (law(), PID))
    assert one.columns().keys() == other.columns().keys()
    for name in one.columns():
        assert np.array_equal(one[name], other[name], equal_nan=True), name
