# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Every law on the calibrated rig with the instruments of the paper: it arrives, stays, follows."""

import pytest

from rodless_control import references
from rodless_control.controller import Law
from rodless_control.laws import LAWS
from rodless_lab import closed_loop, run_metrics
from rodless_lab.benchmark.laws.entries import of_package
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET

RIG = RigParameters.preset("calibrated").with_values(DATA_SHEET)


def tuned() -> dict[str, Law]:
    """Return the laws with gains for such rigs, by name."""
    return {one.name: one.law for one in of_package()}


@pytest.mark.parametrize("name", LAWS)
def test_it_moves_58_mm_and_keeps_still(name: str) -> None:
    """To 0.2 mm within 0.5 s, no more than 0.4 mm past it, then within 0.15 mm on average.

    The instrument's linearity alone may put the carriage 0.1 mm off.
    """
    step = references.step(0.0, 0.058, at=0.1)
    found = run_metrics(closed_loop(RIG, tuned()[name], step, 2.1, 1e-3))
    assert found.settling_time < 0.5
    assert 0.0 <= found.overshoot < 4e-4
    assert abs(found.mean_error) < 1.5e-4


@pytest.mark.parametrize("name", LAWS)
def test_it_follows_a_sine(name: str) -> None:
    """20 mm at 0.381 Hz after the start: within 1.2 mm all the time, and 0.6 mm RMS."""
    sine = references.sine(0.1, 0.02, 0.381, at=0.1)
    run = closed_loop(RIG, tuned()[name], sine, 3.3, 1e-3, position=0.1)
    found = run_metrics(run, since=0.6)
    assert found.peak_error < 1.2e-3
    assert found.rms_error < 6e-4
