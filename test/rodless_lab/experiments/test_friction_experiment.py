# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The friction experiment on rigs whose friction it does not know."""

import pytest

from rodless_lab.experiments.friction_campaign import (
    FrictionRun,
    constant_run,
    identified,
    ramp_run,
    read_off,
)
from rodless_sim import RigParameters

SUPPLY = 0.5e6 + 101325.0
FORWARD = (5.26, 5.28, 5.30, 5.34, 5.40, 5.50)
REVERSE = (4.90, 4.86, 4.80, 4.70, 4.60, 4.50)


@pytest.mark.slow
def test_another_friction_comes_back() -> None:
    """A rig with other friction than Table 2 is identified within 3 % by the same campaign."""
    hidden = {
        "friction.forward.static": 26.0,
        "friction.forward.coulomb": 10.0,
        "friction.forward.stribeck_velocity": 1.6e-3,
        "friction.forward.viscous": 3800.0,
        "friction.reverse.coulomb": 14.0,
        "friction.reverse.viscous": 5200.0,
    }
    rig = RigParameters({"supply.pressure": SUPPLY, **hidden})
    traces = [(voltage, False, constant_run(rig, voltage)) for voltage in FORWARD + REVERSE]
    traces.append((5.28, True, ramp_run(rig, 5.28)))
    fit = identified(traces, rig, seed=1).complete
    for direction in ("forward", "reverse"):
        for name in ("static", "coulomb", "stribeck_velocity", "viscous"):
            true = rig.number(f"friction.{direction}.{name}")
            found = getattr(getattr(fit, direction), name)
            assert found.value == pytest.approx(true, rel=0.03), f"{direction} {name}"


@pytest.mark.parametrize(
    ("voltage", "reason"), [(5.2, "the carriage never moves"), (5.26, "stick-slip")]
)
def test_runs_without_uniform_motion_are_left_out_with_the_reason(
    voltage: float, reason: str
) -> None:
    """A run that holds still, and one that sticks and slips, give no point and say why."""
    rig = RigParameters({"supply.pressure": SUPPLY})
    trace = constant_run(rig, voltage)
    run = FrictionRun(voltage, False, trace, read_off(trace, rig))
    assert len(run.points.speeds) == 0
    assert "left out of uniform motion" in run.verdict
    assert reason in run.verdict


def test_runs_end_before_the_end_cap() -> None:
    """Runs are cut where the carriage comes within 15 mm of the end it runs to."""
    rig = RigParameters({"supply.pressure": SUPPLY})
    assert constant_run(rig, 5.5).position.max() <= 0.185
    assert constant_run(rig, 4.395).position.min() >= 0.015
