# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.
"""Rigs with something that the model leaves out: the verdict says so, and what it likely is."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from extent import extensive, some_of
from quiet_stop import Quiet

from rodless_lab.cli import identify
from rodless_lab.identification.coverage import KNOWN, SUBJECTS, measured_run, round_trip
from rodless_lab.identification.pressures.causes import trials, with_cause
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.fit import PressureFit
from rodless_lab.identification.pressures.heat import identify_heat
from rodless_lab.runs.measured_run import MeasuredRun
from rodless_sim.instruments.instruments import DATA_SHEET

pytestmark = pytest.mark.slow

HEAT = {"chambers.thermodynamics": "energy_balance"}
SATURATING = {"friction.form": "saturating"}


def measured(subject: str, values: dict[str, object], seed: int = 1) -> MeasuredRun:
    """A hidden rig with ``values`` on top, as its noisy sensors show it."""
    generator = np.random.default_rng(seed)
    hidden, _ = SUBJECTS[subject].hide(generator)
    return measured_run(hidden.with_values(values), SUBJECTS[subject].voltages, generator)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("subject", "effect"),
    [
        ("chambers", "heat"),
        ("valve", "heat"),
        ("chambers", "leak across"),
        ("valve", "polytropic"),
        ("chambers", "iso_6358"),
        ("valve", "discharge"),
        ("friction", "saturating"),
    ],
)
def test_an_effect_left_out_is_not_silent(subject: str, effect: str, seed: int) -> None:
    """Either all 95 % intervals hold the truth, or the verdict says that the model does not fit.

    Sizes are drawn; ``coverage --effects`` counts the same over 100 draws.
    """
    trial = round_trip(subject, seed, effect)
    assert trial.rows
    assert trial.covered or not trial.verdict.fits


def blamed(run: MeasuredRun) -> PressureFit:
    """The chambers of the run, and what their verdict blames."""
    fit = identify_chambers(run, KNOWN)
    return with_cause(run, fit, partial(trials, run, fit.solution))


@pytest.mark.parametrize(
    "values",
    some_of(
        [{"valve.hysteresis": 4e-3}, {"valve.dynamics": "second_order"}, {"valve.dead_time": 3e-3}],
        3,
    ),
    ids=["hysteresis", "dynamics", "dead time"],
)
def test_a_late_spool_is_found_out(values: dict[str, object]) -> None:
    """A spool that lags, comes late or has play: the drive of the valve is blamed."""
    verdict = blamed(measured("chambers", values)).verdict
    assert not verdict.fits
    causes = [f"{kind} of the valve" for kind in ("dynamics", "dead time", "hysteresis")]
    assert verdict.cause.startswith(tuple(causes))


@extensive
def test_what_a_heated_rig_lacks_is_named_as_well() -> None:
    """Of identify heat: chambers without heat, which have no such coefficient, explain nothing."""
    run = measured("heat", {"valve.hysteresis": 4e-3})
    fit = identify_heat(run, KNOWN.with_values(HEAT))
    verdict = with_cause(run, fit, partial(trials, run, fit.solution)).verdict
    assert not verdict.fits
    assert verdict.cause


def test_a_supply_that_droops_is_found_out() -> None:
    """Readings that sag by 3 kPa while the model has them constant: the supply is blamed."""
    run = measured("chambers", {})
    sag = 3e3 * np.sin(np.pi * run.time / run.time[-1])
    verdict = blamed(replace(run, supply_pressure=run.supply_pressure - sag)).verdict
    assert not verdict.fits
    assert "supply" in verdict.cause


def test_readings_without_the_stated_lag_are_told_of() -> None:
    """As of a rig with ideal sensors, beside those of the data sheet: no valve is blamed."""
    ideal = measured("chambers", {name: 0.0 for name in DATA_SHEET if name != "sensors.seed"})
    verdict = blamed(ideal).verdict
    assert not verdict.fits
    assert "without it (--sensors ideal, or sensors.pressure_lag in the base) the" in verdict.cause


def test_noisier_sensors_than_stated_are_said_to_be() -> None:
    """600 Pa where 200 are stated: no effect helps; the line gives the readings' own noise.

    And the options that state it.
    """
    verdict = blamed(measured("chambers", {"sensors.pressure_noise": 600.0})).verdict
    assert not verdict.fits
    assert "none of the effects tried" in verdict.cause
    assert "--sensors ideal, or --base FILE --sensors base" in verdict.cause
    said = float(verdict.cause.split("own noise is ")[1].split(" Pa")[0])
    assert said == pytest.approx(600.0, rel=0.05)


@extensive
@pytest.mark.parametrize(
    ("subject", "values", "cause"),
    [
        ("chambers", HEAT, "heat to the walls (chambers.thermodynamics: energy_balance)"),
        ("friction", SATURATING, "another form of friction, friction.form: saturating"),
    ],
)
def test_the_command_says_that_the_model_does_not_fit(
    tmp_path: Path,
    write_bag,
    capsys: pytest.CaptureFixture[str],
    subject: str,
    values: dict[str, object],
    cause: str,
) -> None:
    """Exit code 3, a line that names the cause, the residuals drawn, the verdict in the file.

    From a base that has the effect the same bag fits: code 0.
    """
    bag, output = write_bag(tmp_path / "bag", measured(subject, values)), tmp_path / "found.yaml"
    arguments = [subject, str(bag), "-o", str(output)]
    assert identify.main(arguments, Quiet()) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("the model does not fit: ")
    assert f"likely missing: {cause}" in line
    assert output.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    if output.exists():
        assert "# Verdict: the model does not fit" in output.read_text(encoding="utf-8")
    base = tmp_path / "base.yaml"
    lines = "".join(f"    {name}: {value}\n" for name, value in values.items())
    base.write_text(f"/**/plant:\n  ros__parameters:\n{lines}", encoding="utf-8")
    assert identify.main([*arguments, "--base", str(base)], Quiet()) == 0
    assert "what the stated sensors explain" in capsys.readouterr().out
