# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session with telemetry ends where the controller, and not its law, gave the last answer."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from extent import also

from rodless_control import references
from rodless_control.laws import law_class
from rodless_lab import closed_loop
from rodless_lab.session.session import RigSession
from rodless_sim import RigParameters, Scenario

pytestmark = [pytest.mark.ros, pytest.mark.usefixtures("compiled")]

STEP = {"reference.type": "step", "reference.at": 0.02, "reference.target": 0.058}
DURATION = 0.1
NEUTRAL = 5.08

# Wall-clock s: where nothing more comes, a wait ends within two of the controller's reports.
TIMEOUT = 30.0

FAILING = """
from typing import NamedTuple

from rodless_control import Law


class Command(NamedTuple):
    voltage: float
    term: float


class Failing(Law):
    TERMS = ("term",)

    def update(self, measurement, reference, interval):
        if measurement.time > 0.05:
            raise ValueError("no more")
        return Command(5.5, 1.0)
"""


def with_telemetry(controller: dict[str, object], **options: Any) -> RigSession:
    """A session in lock-step of this file's duration."""
    return RigSession(
        "lockstep",
        controller=controller,
        duration=DURATION,
        telemetry=True,
        timeout=TIMEOUT,
        **options,
    )


@pytest.mark.parametrize("gone_from", [also(0.0), 0.05, also(DURATION)])
def test_a_reading_that_is_gone_at_the_end_ends_the_run_all_the_same(
    gone_from: float, tmp_path: Path
) -> None:
    """From the start, from half-way on, or at the last sample: commands and terms of the loop.

    The law reads pressures. Samples without one close the valve and have no telemetry: NaN.
    """
    path = tmp_path / "gone.yaml"
    path.write_text(f"- {{at: {gone_from}, fault.pressure_a.sensor: gone}}\n", encoding="utf-8")
    with with_telemetry({**STEP, "controller.law": "cascade"}, scenario=path) as rig:
        run = rig.run()
        assert rig.diagnostics("controller")["last command"] == "closed valve"
    expected = closed_loop(
        RigParameters.preset("paper"),
        law_class("cascade").Parameters.preset("paper"),
        references.step(0.0, 0.058, at=0.02),
        DURATION,
        1e-3,
        scenario=Scenario.from_file(path),
    )
    gone = np.rint(run.time * 1e3) >= round(gone_from * 1e3)
    assert np.all(run.voltage[gone] == NEUTRAL)
    assert np.all(np.isnan(run.reference[gone]))
    assert np.all(np.isfinite(run.reference[~gone]))
    assert np.array_equal(run.voltage, expected.voltage)
    for name, values in expected.terms.items():
        assert np.array_equal(run.terms[name], values, equal_nan=True), name


def test_a_controller_that_was_switched_off_ends_its_run() -> None:
    """With `enable_controller(False)` before the start: the valve is closed, no term comes."""
    with with_telemetry(STEP, paused=True) as rig:
        rig.enable_controller(False)
        rig.resume()
        run = rig.run()
    # Sample 0 was answered before; its answer was kept back.
    assert np.all(run.voltage[1:] == NEUTRAL)
    assert np.all(np.isnan(run.error[1:]))


def test_a_law_that_has_failed_ends_its_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With `law_may_fail`: its term until the failure, NaN and a closed valve after it."""
    (tmp_path / "law_that_fails_later.py").write_text(FAILING, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    law = {**STEP, "controller.law": "law_that_fails_later:Failing"}
    path = {"PYTHONPATH": str(tmp_path)}
    with with_telemetry(law, law_may_fail=True, environment=path) as rig:
        run = rig.run()
    failed = np.rint(run.time * 1e3) > 50
    assert np.array_equal(run.terms["term"], np.where(failed, np.nan, 1.0), equal_nan=True)
    assert np.array_equal(run.voltage, np.where(failed, NEUTRAL, 5.5))


def test_the_telemetry_of_a_good_last_sample_is_waited_for() -> None:
    """After a run that ended without the law, one after a reset has its last term again."""
    with with_telemetry(STEP) as rig:
        first = rig.run()
        rig.enable_controller(False)
        rig.reset()
        second = rig.run()
        rig.enable_controller(True)
        rig.reset()
        third = rig.run()
    assert np.all(np.isfinite(first.error))
    assert np.all(np.isnan(second.error))
    assert np.isfinite(third.error[-1])


def test_a_run_ends_under_a_law_whose_terms_are_others() -> None:
    """Those of the law that it began with are NaN from the change on; none is waited for."""
    with with_telemetry(STEP, paused=True) as rig:
        rig.step(50)
        rig.set_parameters("controller", {"controller.law": "adrc"})
        rig.resume()
        run = rig.run()
    (there,) = np.nonzero(np.isfinite(run.p))
    assert there.tolist() == list(range(51))
    assert np.isfinite(run.voltage).all()
