# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Sensors that are further off than stated: a fit takes that up without a trace, and says so."""

from functools import partial

import numpy as np
import pytest
from extent import extensive, some_of

from rodless_lab.identification.coverage import KNOWN, SUBJECTS, measured_run
from rodless_lab.identification.pressures.causes import trials, with_cause
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.verdict import Verdict
from rodless_lab.runs.measured_run import MeasuredRun

pytestmark = pytest.mark.slow

STATED = 5e3  # Pa, 0.5 % of 1 MPa


def off(subject: str, offsets: dict[str, float]) -> tuple[MeasuredRun, Verdict]:
    """Measure a rig whose sensors are off by ``offsets`` (Pa) and by nothing else; identify it."""
    generator = np.random.default_rng(1)
    hidden, _ = SUBJECTS[subject].hide(generator)
    faults = {f"fault.{name}.offset": size for name, size in offsets.items()}
    rig = hidden.with_values({"sensors.pressure_bias": 0.0, **faults})
    run = measured_run(rig, SUBJECTS[subject].voltages, generator)
    known = KNOWN.with_values({name: hidden[name] for name in SUBJECTS[subject].known})
    return run, SUBJECTS[subject].identify(run, known)[1]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("pressure_a", "bias of the sensor of chamber A"),
        ("pressure_b", "bias of the sensor of chamber B"),
        ("supply_pressure", "bias of the sensor of the supply"),
    ],
)
@pytest.mark.parametrize("size", [7e3, -2e4])
def test_a_sensor_off_by_more_is_named(name: str, says: str, size: float) -> None:
    """By 7 kPa, or by 20 to the other side: the verdict says whose, by how much, and what to do."""
    run, verdict = off("chambers", {name: size})
    assert not verdict.fits
    (worst,) = [check for check in verdict.checks if check.p_value == 0.0]
    assert worst.name == says
    assert worst.found == pytest.approx(abs(size), rel=0.1)
    assert worst.expected == STATED
    fit = identify_chambers(run, KNOWN)
    blamed = with_cause(run, fit, partial(trials, run, fit.solution)).verdict
    assert "sensors that are zeroed against each other" in str(blamed)


@pytest.mark.parametrize("subject", ["chambers", "valve", "bristles"])
@pytest.mark.parametrize("signs", some_of([(1, -1, -1), (-1, 1, 1), (1, 1, 1)], 3))
def test_as_much_as_is_stated_is_none(subject: str, signs: tuple[int, int, int]) -> None:
    """All at the edge of what they may be, in one direction or against each other."""
    names = ("pressure_a", "pressure_b", "supply_pressure")
    offsets = {name: sign * STATED for name, sign in zip(names, signs, strict=True)}
    assert off(subject, offsets)[1].fits


@extensive
def test_bristles_pushed_by_a_bias_are_told() -> None:
    """Half a bar on one side of 491 mm² are 25 N; what is stated of both sensors is 5 N."""
    _, verdict = off("bristles", {"pressure_a": 5e4})
    assert not verdict.fits
    assert "constant force" in str(verdict)
    assert "sensors that are zeroed against each other" in str(verdict)
