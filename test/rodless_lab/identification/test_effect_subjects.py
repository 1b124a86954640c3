# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Subjects that find an effect: rigs that have none of it, and names nobody knows."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from extent import also, extensive
from quiet_stop import Quiet

from rodless_base.parameters import Value
from rodless_lab.cli import drive, identify
from rodless_lab.identification import coverage, subjects
from rodless_lab.identification.coverage import (
    KNOWN,
    hidden_chambers,
    hidden_leaks,
    measured_run,
)
from rodless_lab.identification.excitation import EXCITATIONS
from rodless_lab.identification.pressures.fit import SUPPLY
from rodless_lab.identification.pressures.heat import heat_findings, identify_heat
from rodless_lab.identification.pressures.leaks import identify_leaks, leak_findings
from rodless_lab.identification.pressures.spool import identify_spool, spool_findings
from rodless_lab.identification.pressures.unknowns import (
    CLOSED,
    DAMPING,
    DEAD_TIME,
    FREQUENCY,
    GAP,
    HEAT_TRANSFER,
    HYSTERESIS,
    LEAKS,
)

FOUND = {
    "heat": (identify_heat, heat_findings),
    "leak": (identify_leaks, leak_findings),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("subject", "values", "absent", "most"),
    [
        also(
            "heat",
            {"chambers.thermodynamics": "energy_balance", HEAT_TRANSFER: 0.0},
            [HEAT_TRANSFER],
            1.0,
        ),
        ("leak", {}, LEAKS, 1e-9),
    ],
)
def test_an_effect_that_is_not_there_is_bounded(
    subject: str, values: dict[str, Value], absent: list[str], most: float
) -> None:
    """Of adiabatic walls and tight chambers: not told from 0, and at most so much.

    The model fits, the rest is found all the same, and the file leaves out what is not there.
    """
    identify_it, findings = FOUND[subject]
    generator = np.random.default_rng(2)
    hidden, truth = hidden_chambers(generator)
    run = measured_run(hidden.with_values(values), EXCITATIONS[subject](), generator)
    fit = identify_it(run, KNOWN)
    written = {found.name: found.value for found in findings(fit)}
    assert fit.verdict.fits
    for name in absent:
        estimate = fit.estimates[name]
        assert estimate.low <= 0.0 < estimate.high < most, name
        assert estimate.note.startswith("not told from 0, and at most "), name
        assert written[name] is None, name
    assert all(fit.estimates[name].informed for name in truth)


@extensive
@pytest.mark.slow
@pytest.mark.parametrize("seed", [202, 208])
def test_tight_chambers_behind_a_valve_closed_elsewhere(seed: int) -> None:
    """A rig without leaks whose valve closes 70 or 90 mV off the base's: the model fits.

    From the base's closed voltage alone the search ran away to 6 V, and to 4 V. Each interval holds
    what the rig was made with.
    """
    generator = np.random.default_rng(seed)
    hidden, _ = hidden_leaks(generator)
    rig = hidden.with_values(dict.fromkeys(LEAKS, 0.0))
    fit = identify_leaks(measured_run(rig, EXCITATIONS["leak"](), generator), KNOWN)
    assert fit.verdict.fits
    for name in (GAP, CLOSED, SUPPLY):
        assert fit.estimates[name].informed
        assert fit.estimates[name].covers(rig.number(name)), name
    for name in LEAKS:
        assert fit.estimates[name].note.startswith("not told from 0, and at most "), name
        assert fit.estimates[name].high < 1e-10, name


@extensive
@pytest.mark.slow
def test_a_spool_at_once_is_bounded() -> None:
    """Of a spool that follows at once, with play: the play is found, the frequency is bounded.

    Neither dead time, damping ratio nor frequency is written, and no dynamics are switched on.
    """
    generator = np.random.default_rng(2)
    hidden, _ = hidden_chambers(generator)
    rig = hidden.with_values({HYSTERESIS: 2e-3, "time.tolerance": 0.01})
    fit = identify_spool(measured_run(rig, EXCITATIONS["spool"](), generator), KNOWN)
    written = {found.name: found.value for found in spool_findings(fit)}
    assert fit.verdict.fits
    for name in ("valve.dynamics", FREQUENCY, DAMPING, DEAD_TIME):
        assert written[name] is None, name
    assert 300.0 < fit.estimates[FREQUENCY].low <= 2000.0
    assert "not told from a spool that follows at once" in fit.estimates[FREQUENCY].note
    assert fit.estimates[DEAD_TIME].note.startswith("not told from 0, and at most ")
    assert fit.estimates[HYSTERESIS].covers(2e-3)
    assert fit.estimates[HYSTERESIS].half_width < 3e-4


def test_every_subject_has_voltages_and_a_measured_coverage() -> None:
    """What `identify` finds, `drive` excites, and the campaign counts."""
    assert set(subjects.SUBJECTS) == set(EXCITATIONS) == set(coverage.SUBJECTS)


@pytest.mark.parametrize("count", ["-1", "1.5", "x", "9" * 19])
def test_drive_waits_for_a_number_of_recorders(
    count: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and the value; nothing is driven."""
    with pytest.raises(SystemExit) as refused:
        drive.main(["chambers", f"--recorders={count}"], Quiet())
    assert refused.value.code == 2
    assert f"'{count}' is not a whole number from 0 on" in capsys.readouterr().err


@pytest.mark.parametrize("command", [identify, drive], ids=["identify", "drive"])
def test_an_unknown_subject_is_refused(
    command: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and the names that there are; nothing is read or written."""
    output = tmp_path / "found.yaml"
    rest = ["bag", "-o", str(output)] if command is identify else []
    with pytest.raises(SystemExit) as refused:
        command.main(["bristle", *rest], Quiet())
    assert refused.value.code == 2
    said = capsys.readouterr().err
    assert "'bristle'" in said
    assert all(name in said for name in EXCITATIONS)
    assert not output.exists()
