# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What predicts a second run of the rig: the model as it is, or one with the effect it lacks.

The rigs are simulated: which effect they have is known, and nobody tells the identification.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from extent import extensive, some_of
from quiet_stop import Quiet

from rodless_lab.cli import identify
from rodless_lab.identification.coverage import KNOWN, SUBJECTS, measured_run
from rodless_lab.identification.excitation import EXCITATIONS
from rodless_lab.identification.plausible import PRESSURES
from rodless_lab.identification.pressures.causes import trials, with_cause
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.validation import PLAIN, Prediction, Validation, validated
from rodless_lab.identification.verdict import Check, Verdict
from rodless_lab.runs.measured_run import MeasuredRun, RunError

HEAT = {"chambers.thermodynamics": "energy_balance"}


def two_runs(values: dict[str, object], seed: int) -> tuple[MeasuredRun, MeasuredRun]:
    """One hidden rig with ``values`` on top, driven by other voltages the second time."""
    generator = np.random.default_rng(seed)
    hidden, _ = SUBJECTS["chambers"].hide(generator)
    rig = hidden.with_values(values)
    first = measured_run(rig, EXCITATIONS["chambers"](), generator)
    return first, measured_run(rig, EXCITATIONS["heat"](), generator)


@pytest.mark.slow
@pytest.mark.parametrize("seed", some_of([1, 2, 3], 3))
def test_a_right_model_predicts_a_second_run(seed: int) -> None:
    """Of rigs that are as the model says: chosen as it is, and what is left is the sensors' noise.

    200 Pa are what the rig's pressure sensors were given.
    """
    first, second = two_runs({}, seed)
    fitted = identify_chambers(first, KNOWN).solution
    found = validated(fitted, second, partial(trials, first, fitted))
    assert found.chosen is found.plain
    assert found.chosen.predicts
    assert found.chosen.left == pytest.approx(200.0, rel=0.05)


@pytest.mark.slow
@extensive
@pytest.mark.parametrize(
    ("values", "effect"),
    [(HEAT, "heat to the walls")],
    ids=["heat"],
)
def test_the_effect_that_the_rig_has_predicts_best(values: dict[str, object], effect: str) -> None:
    """Of a rig with one effect: that one is chosen and predicts, the model without does not."""
    first, second = two_runs(values, 1)
    fitted = identify_chambers(first, KNOWN).solution
    found = validated(fitted, second, partial(trials, first, fitted))
    assert not found.plain.predicts
    assert found.chosen.name.startswith(effect)
    assert found.chosen.predicts
    assert found.chosen.left < 0.5 * found.plain.left


@pytest.mark.slow
def test_the_command_says_what_predicts(
    tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 0 where the model predicts the second bag, and the line that says so."""
    first, second = (write_bag(tmp_path / f"bag{k}", run) for k, run in enumerate(two_runs({}, 1)))
    output = tmp_path / "found.yaml"
    arguments = ["chambers", str(first), "-o", str(output), "--validate", str(second)]
    assert identify.main(arguments, Quiet()) == 0
    assert f"chosen: {PLAIN}" in capsys.readouterr().out


def test_friction_is_refused(tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2 and why, before anything is fitted or written."""
    first, second = (write_bag(tmp_path / f"bag{k}", run) for k, run in enumerate(two_runs({}, 1)))
    output = tmp_path / "found.yaml"
    arguments = ["friction", str(first), "-o", str(output), "--validate", str(second)]
    assert identify.main(arguments, Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--validate: refused for friction" in line
    assert not output.exists()


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (slice(None), "refused, most of it is in {first}, which is fitted; take another run"),
        (slice(2000, None), "refused, most of it is in {first}"),
        (slice(30), "the pressures change by only"),
    ],
    ids=["all", "a part", "at rest"],
)
def test_a_second_bag_that_tests_nothing_is_refused(
    tmp_path: Path, write_bag, capsys: pytest.CaptureFixture[str], part: slice, says: str
) -> None:
    """The first once more, in part, or one whose pressures stay: code 2 before it is fitted."""
    run, _ = two_runs({}, 1)
    first = write_bag(tmp_path / "first", run)
    cut = {name: values[part] for name, values in run.columns().items()}
    second = write_bag(tmp_path / "second", replace(run, **cut))
    output = tmp_path / "found.yaml"
    arguments = ["chambers", str(first), "-o", str(output), "--validate", str(second)]
    assert identify.main(arguments, Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{second}: {says.format(first=first)}")
    assert not output.exists()


@pytest.mark.slow
@pytest.mark.parametrize("atmosphere", [101325.0, 84e3])
def test_gauge_pressures_are_named(atmosphere: float) -> None:
    """Those of a second run are refused; of the first, which does not fit, they are the cause.

    At sea level, and where the air has 84 kPa and the base says so.
    """
    values = {"atmosphere.pressure": atmosphere}
    first, second = two_runs(values, 1)
    known = KNOWN.with_values(values)
    fit = identify_chambers(first, known)
    with pytest.raises(RunError, match="they are gauge readings, and absolute ones are needed"):
        validated(fit.solution, gauge(second, atmosphere), lambda: [])
    misfit = identify_chambers(gauge(first, atmosphere), known)
    assert not misfit.verdict.fits
    blamed = with_cause(gauge(first, atmosphere), misfit, lambda: []).verdict
    assert "likely missing: absolute pressures; with the atmosphere added" in str(blamed)


def gauge(run: MeasuredRun, atmosphere: float) -> MeasuredRun:
    """The run with pressures counted from the atmosphere (Pa)."""
    return replace(run, **{name: getattr(run, name) - atmosphere for name in PRESSURES})


@pytest.mark.slow
def test_a_sensor_off_in_the_second_run_is_named() -> None:
    """Half a bar: the line says whose and by how much, and no other model is sold for it."""
    first, second = two_runs({}, 1)
    off = replace(second, supply_pressure=second.supply_pressure + 3e4)
    fitted = identify_chambers(first, KNOWN).solution
    found = validated(fitted, off, lambda: [])
    assert not found.plain.predicts
    assert "does not predict it: bias of the sensor of the supply 3" in str(found.plain)
    assert "explained 5e+03 Pa" in str(found.plain)
    assert str(found).endswith(
        "take sensors that are zeroed against each other, or their "
        "sensors.pressure_bias in the base"
    )


def test_what_does_not_predict_is_not_chosen() -> None:
    """Not the model that leaves least, but the best of those that predict; or none, and so said."""
    left_open = prediction("too open", 100.0, explained=900.0, fits=True)
    wrong = prediction("wrong", 300.0, explained=210.0, fits=False)
    right = prediction("right", 205.0, explained=210.0, fits=True)
    assert Validation(wrong, [left_open, right, wrong]).chosen is right
    # Predicts, but only as the first run leaves it so open.
    open_wide = prediction("open", 305.0, explained=310.0, fits=True)
    wide = Validation(wrong, [open_wide])
    assert wide.chosen is wrong
    assert "none of the models tried predicts it and leaves less; take a first bag" in str(wide)
    none = Validation(wrong, [left_open, wrong])
    assert none.chosen is wrong
    assert str(none).startswith("chosen: none of the models tried predicts it")
    assert Validation(right, []).chosen is right


def prediction(name: str, left: float, *, explained: float, fits: bool) -> Prediction:
    """What a model leaves of a second run whose readings have 200 Pa of noise."""
    check = Check("scatter", left, explained, "Pa", 0.5 if fits else 1e-9)
    return Prediction(name, left, explained, 200.0, Verdict((check,)))
