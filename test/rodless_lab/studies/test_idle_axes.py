# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A parameter that no run depends on cannot be an axis of a study."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from every_option import RIGS

from rodless_base.parameters import Parameter, Value
from rodless_control import ControllerParameters, references
from rodless_control.setpoint import FROM_PARAMETERS
from rodless_lab import closed_loop
from rodless_lab.simulation.stepped_loop import needs_steps
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.results import Results
from rodless_lab.studies.study import read_study
from rodless_lab.studies.summary import summary
from rodless_lab.studies.sweep import sweep
from rodless_sim import RigParameters
from rodless_sim.faults import sensor_states
from rodless_sim.instruments.sampling import instruments_and_noise
from rodless_sim.physics.plant import Plant

OF_NODES = [
    one
    for kind in (RigParameters, ControllerParameters)
    for one in kind.DECLARATIONS.values()
    if not one.in_runs
]

STEP = references.step(0.0, 0.05, at=0.01)

# What other parameters follow from, or which of them are looked at, when a set is made.
MADE_FROM = {"cylinder.model"}


def other(parameter: Parameter) -> Value:
    """Another value that the parameter may have."""
    if parameter.choices:
        return parameter.choices[-1]
    if isinstance(parameter.default, bool):
        return not parameter.default
    if isinstance(parameter.default, str):
        return f"{parameter.default}left"
    low, high = parameter.minimum, parameter.maximum
    return type(parameter.default)(low + 0.01 * (high - low) + 1.0 * (low == high))  # type: ignore[arg-type]


def study_in(folder: Path, text: str) -> Path:
    """A study file."""
    path = folder / "idle.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_period_of_the_nodes_is_no_axis(tmp_path: Path) -> None:
    """The rows would all run at run.period, beside a column that says otherwise."""
    study = study_in(tmp_path, "vary: {time.period: [0.001, 0.004]}\n")
    with pytest.raises(StudyError) as refused:
        read_study(study)
    assert str(refused.value) == (
        f"{study}: vary: time.period: refused: no run of this study depends on time.period; "
        "set run.period"
    )


@pytest.mark.parametrize(
    ("name", "value", "way_out"),
    [
        ("time.period", 0.01, "set run.period"),
        ("time.duration", 3.0, "set run.duration"),
        ("reference.frequency", 0.5, "leave it out"),
        ("time.mode", "lockstep", "leave it out"),
    ],
)
def test_what_no_run_depends_on_cannot_be_set(
    tmp_path: Path, name: str, value: object, way_out: str
) -> None:
    """A period that is set for the nodes would leave every row at run.period, without a word."""
    text = f"set: {{{name}: {value}}}\nvary: {{friction.forward.coulomb: [5, 10]}}\n"
    study = study_in(tmp_path, text)
    with pytest.raises(StudyError) as refused:
        read_study(study)
    assert str(refused.value) == (
        f"{study}: set: {name}: refused: no run of this study depends on {name}; {way_out}"
    )


@pytest.mark.parametrize("name", sorted({one.name for one in OF_NODES}))
def test_what_is_for_nodes_alone_changes_no_run_and_is_refused(tmp_path: Path, name: str) -> None:
    """Another value gives the same run, bit for bit, with ideal and with real instruments."""
    (parameter, *_) = [one for one in OF_NODES if one.name == name]
    changed = {name: other(parameter)}
    study = study_in(tmp_path, f"vary: {{{name}: [{str(changed[name]).lower()}]}}\n")
    with pytest.raises(StudyError, match=f"refused: no run of this study depends on {name}"):
        read_study(study)
    rig, law = RigParameters.preset("paper"), ControllerParameters.preset("paper")
    for noise in (0.0, 200.0):
        noisy = rig.with_values({"sensors.pressure_noise": noise})
        before = closed_loop(noisy, law, STEP, 0.05, 1e-3).columns()
        after = closed_loop(
            noisy.with_values(changed if name in noisy else {}),
            law.with_values(changed if name in law else {}),
            STEP,
            0.05,
            1e-3,
        ).columns()
        assert all(np.array_equal(before[column], after[column]) for column in before)


def noting(parameters: RigParameters, read: set[str]) -> RigParameters:
    """The same parameters, which put into ``read`` what is asked of them."""

    class Noting(RigParameters):
        def __getitem__(self, name: str) -> Value:
            read.add(name)
            return super().__getitem__(name)

    found = object.__new__(Noting)
    vars(found).update(vars(parameters))
    return found


def rigs() -> Iterator[RigParameters]:
    """Rigs that have each option at least once, and each choice."""
    paper = RigParameters.preset("paper")
    yield from (paper.with_values(values) for values in RIGS.values())
    for name, parameter in RigParameters.DECLARATIONS.items():
        for choice in parameter.choices if parameter.in_runs else ():
            magnets = {"coupling.kind": "magnetic"} if name == "fault.carriage.decoupled" else {}
            yield paper.with_values({**magnets, name: choice})


def test_every_other_parameter_of_the_rig_is_read_for_some_run() -> None:
    """Of rigs with each option and each choice, each parameter is asked for; of nodes' none is.

    What a run is made of is made for each of these rigs; one of them runs.
    """
    read: set[str] = set()
    for rig in rigs():
        noted = noting(rig, read)
        for make in (Plant.of, instruments_and_noise, needs_steps, sensor_states):
            make(noted)  # type: ignore[operator]
    closed_loop(noting(RigParameters(), read), lambda *_: 5.05, STEP, 2e-3, 1e-3)
    names = {name for name, one in RigParameters.DECLARATIONS.items() if one.in_runs}
    assert names - read <= MADE_FROM
    # Drawn, though the loop has no flow meter.
    of_nodes = {one.name for one in OF_NODES} - {"sensors.flow_noise", "sensors.flow_gain_error"}
    assert not read & of_nodes


@pytest.mark.parametrize(
    ("kind", "own", "others"),
    [("step", "target", "amplitude"), ("sine", "amplitude", "target")],
)
def test_a_reference_varies_in_its_own_parameters(
    tmp_path: Path, kind: str, own: str, others: str
) -> None:
    """A step has no amplitude and a sine no target; neither moves with a jerk limit."""
    start = f"set: {{reference.type: {kind}}}\nvary: {{reference."
    assert len(read_study(study_in(tmp_path, f"{start}{own}: [0.01, 0.02]}}\n"))) == 2
    reads = FROM_PARAMETERS[kind]
    assert f"reference.{own}" in reads
    assert f"reference.{others}" not in reads
    for name in (others, "jerk", "maximum"):
        with pytest.raises(StudyError, match=f"no run of this study depends on reference.{name}"):
            read_study(study_in(tmp_path, f"{start}{name}: [0.15, 0.16]}}\n"))


def test_a_pattern_of_nothing_that_acts_is_refused(tmp_path: Path) -> None:
    """Period and speed are of the nodes alone; the tolerance of an integration step acts."""
    with pytest.raises(StudyError, match=r"depends on time\.period, time\.speed; set run\.period"):
        read_study(study_in(tmp_path, "vary: {time.*d: [0.5, 1.0]}\n"))
    assert len(read_study(study_in(tmp_path, "vary: {time.tolerance: [0.5, 1.0]}\n"))) == 2


@pytest.mark.parametrize(("values", "said"), [("[5.0e5]", "1 row."), ("[5.0e5, 6.0e5]", "2 rows.")])
def test_the_summary_counts_its_rows(tmp_path: Path, values: str, said: str) -> None:
    """One is no plural."""
    run = "set: {reference.at: 0.0}\nrun: {duration: 0.01}\n"
    text = f"{run}vary: {{supply.pressure: {values}}}\n"
    found: Results = sweep(study_in(tmp_path, text), tmp_path / "out", workers=1)
    assert said in summary(found).splitlines()
