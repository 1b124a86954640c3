# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Errata in the paper's words, where no printed formula is wrong but its reading is."""

import numpy as np
import pytest

from rodless_control import PidParameters, references
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters, simulate


def test_eq_30_measures_the_friction_of_eq_29() -> None:
    """In uniform motion A(P_a - P_b) is the sliding friction (29), well away from (28)'s F_s.

    At 5.6 V the carriage ends up gliding steadily; friction by Table 2 at that speed is written
    out here from the printed numbers.
    """
    run = simulate(RigParameters.preset("paper"), [5.6] * 3000, period=1e-3, position=0.02)
    speed = run.velocity[-1]
    assert np.ptp(run.velocity[-200:]) < 0.02 * speed
    by_eq_29 = 4500.0 * speed + 12.0 + (29.0 - 12.0) * np.exp(-((speed / 1.3e-3) ** 2))
    assert run.force[-1] == pytest.approx(by_eq_29, rel=0.01)
    assert run.force[-1] > 2.0 * 29.0


def test_section_7_errors_are_not_tracking_errors() -> None:
    """The step's tracking error starts at 58 mm, so "error < 0.2 mm" cannot mean that.

    The difference of two runs of one rig, here with 3 % more friction, is what stays that small
    once both have settled.
    """
    rig, pid = RigParameters.preset("paper"), PidParameters.preset("paper")
    step = references.step(0.0, 0.058, at=0.5)
    other = rig.with_values(
        {
            f"friction.{side}.viscous": rig.number(f"friction.{side}.viscous") * 1.03
            for side in ("forward", "reverse")
        }
    )
    first = closed_loop(rig, pid, step, 6.0, 1e-3)
    second = closed_loop(other, pid, step, 6.0, 1e-3)
    assert np.abs(first.error).max() == pytest.approx(0.058, abs=1e-4)
    assert abs(first.position[-1] - second.position[-1]) < 2e-4
