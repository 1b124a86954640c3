# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A law of 50 ms at 100 Hz in the running node: services answer, and the cause is named."""

import os
from pathlib import Path
from time import monotonic

import numpy as np
import pytest
from extent import some_of

from rodless_lab.harness import RigSession

pytestmark = pytest.mark.ros

# Slow for a machine that has other things to do as well.
PERIOD = 0.01
TAKES = 0.05
BEFORE = 3.0
BACKLOG = BEFORE / PERIOD * TAKES

# How long the plant waits for a command in lock-step, in s.
PATIENCE = 0.2
SLOW = """
import time

from rodless_control import Law


class Slow(Law):
    USES_PRESSURES = PRESSURES

    def update(self, measurement, reference, interval):
        time.sleep(TAKES)
        return 5.2
"""


# Each call counts in what it answers, and every fifth one takes its time.
COUNTING = """
import time

from rodless_control import Law


class Counting(Law):
    def reset(self):
        self.calls = 0

    def update(self, measurement, reference, interval):
        self.calls += 1
        if self.calls % 5 == 0:
            time.sleep(WAITS)
        return 5.0 + 0.01 * self.calls
"""


def slow(pressures: bool) -> str:
    return SLOW.replace("PRESSURES", str(pressures)).replace("TAKES", str(TAKES))


def at(folder: Path, name: str, law: str) -> dict[str, str]:
    """Write a module of laws; return the environment in which it is found."""
    (folder / f"{name}.py").write_text(law, "utf-8")
    others = os.environ.get("PYTHONPATH")
    return {"PYTHONPATH": os.pathsep.join([str(folder), *([others] if others else [])])}


@pytest.mark.parametrize("pressures", some_of([True, False], 2))
def test_a_law_that_is_too_slow_is_named_and_starves_nothing(
    tmp_path: Path, pressures: bool
) -> None:
    """After three seconds a service answers soon; commands still come."""
    environment = at(tmp_path, "slow_laws", slow(pressures))
    controller = {"controller.law": "slow_laws:Slow"}
    plant = {"time.period": PERIOD}
    with RigSession(plant=plant, controller=controller, environment=environment) as rig:
        rig.run_for(BEFORE)
        began = monotonic()
        rig.reset_controller()
        assert monotonic() - began < BACKLOG / 3.0
        rig.wait_until(
            lambda: (
                rig.diagnostics("controller").get("message", "").startswith("law Slow takes ")
                and "samples skipped" in rig.diagnostics("controller")["message"]
            ),
            "the diagnostics to name the law",
        )
        assert rig.counter("controller", "samples skipped") > 100.0
        seen = len(rig.samples())
        rig.run_for(0.5)
        fresh = rig.samples().voltage[seen:]
        assert 5.2 in fresh[np.isfinite(fresh)]
    assert "law Slow takes " in rig.outputs["controller"]


def test_a_sample_that_is_offered_again_is_answered_by_what_it_was(tmp_path: Path) -> None:
    """In lock-step each call of a law is for one sample, however often the plant offers it.

    Some samples take the law six times as long as the plant waits before it offers them again;
    their answers, and those to what follows, count the calls.
    """
    environment = at(tmp_path, "counting_laws", COUNTING.replace("WAITS", str(6.0 * PATIENCE)))
    with RigSession(
        "lockstep",
        plant={"time.command_timeout": PATIENCE},
        controller={"controller.law": "counting_laws:Counting"},
        environment=environment,
        duration=0.02,
    ) as rig:
        voltage = rig.run().voltage
        assert rig.counter("controller", "samples skipped") == 0.0
    calls = np.arange(1, len(voltage))
    assert voltage[:-1] == pytest.approx(5.0 + 0.01 * calls, abs=1e-12)
