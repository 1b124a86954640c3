# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A law of 5 ms at 1 kHz in the running node: the services answer, and the cause is named."""

import os
from pathlib import Path
from time import monotonic

import numpy as np
import pytest

from rodless_lab.harness import RigSession

pytestmark = pytest.mark.ros

SLOW = """
import time

from rodless_control import Law


class Slow(Law):
    USES_PRESSURES = PRESSURES

    def update(self, measurement, reference, interval):
        time.sleep(5e-3)
        return 5.2
"""


@pytest.mark.parametrize("pressures", [False, True])
def test_a_law_that_is_too_slow_is_named_and_starves_nothing(
    tmp_path: Path, pressures: bool
) -> None:
    """After three seconds a service answers soon; commands still come."""
    (tmp_path / "slow_laws.py").write_text(SLOW.replace("PRESSURES", str(pressures)), "utf-8")
    others = os.environ.get("PYTHONPATH")
    environment = {"PYTHONPATH": os.pathsep.join([str(tmp_path), *([others] if others else [])])}
    controller = {"controller.law": "slow_laws:Slow"}
    with RigSession(controller=controller, environment=environment) as rig:
        rig.run_for(3.0)
        began = monotonic()
        rig.reset_controller()
        # Behind the backlog of 3 s the answer would take 12 s.
        assert monotonic() - began < 6.0
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
