# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The pages on sweeps and tuning: what they show can be done."""

import math
import re
from pathlib import Path

import numpy as np
import pyarrow as arrow
import pytest
import yaml

from rodless_lab import sweep
from rodless_lab.simulation.run_metrics import NO_METRICS, RunMetrics
from rodless_lab.studies.pictures import draw_rows, draw_sensitivities
from rodless_lab.studies.results import Results
from rodless_lab.studies.study import read_study
from rodless_lab.studies.summary import sensitivities, sensitivity_table, summary
from rodless_lab.studies.tuning_task import read_task

DOCS = Path(__file__).parents[3] / "docs"


def blocks(page: str, kind: str) -> list[str]:
    """The code of a page, of one kind."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL)


def test_the_files_on_the_pages_can_be_read(tmp_path: Path) -> None:
    """The study is a grid of 54 rows, the task has two gains to tune."""
    study, task = tmp_path / "study.yaml", tmp_path / "task.yaml"
    (text,) = blocks("sweeps.md", "yaml")
    study.write_text(text, encoding="utf-8")
    assert len(read_study(study)) == 54
    text, trials = blocks("tuning.md", "yaml")
    task.write_text(text, encoding="utf-8")
    assert list(read_task(task).ranges) == ["controller.kp", "controller.kd"]
    several = {**yaml.safe_load(text), **yaml.safe_load(trials)}
    for name in ("run", "set"):
        several.pop(name)
    task.write_text(yaml.safe_dump(several, sort_keys=False), encoding="utf-8")
    assert [trial.name for trial in read_task(task).trials] == ["step", "sine"]


def written(folder: Path, study: str) -> Path:
    """Return the file of a study."""
    path = folder / "study.yaml"
    path.write_text(study, encoding="utf-8")
    return path


@pytest.mark.slow
def test_the_python_on_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As it stands, after the sweep that the shell ran above it."""
    monkeypatch.chdir(tmp_path)
    sweep("friction", "results/sweeps/friction")
    snippets = blocks("sweeps.md", "python")
    assert len(snippets) == 2
    for snippet in snippets:
        exec(compile(snippet, "sweeps.md", "exec"), {})


def test_the_page_names_every_column(tmp_path: Path) -> None:
    """Each column of the data set stands in the table of the page."""
    page = (DOCS / "sweeps.md").read_text(encoding="utf-8")
    path = written(
        tmp_path, "set: {reference.at: 0.0}\nrun: {duration: 0.05}\ntraces: {columns: [position]}"
    )
    found = sweep(path, tmp_path / "out")
    assert "trace.position" in found.columns()
    assert [name for name in found.columns() if f"`{name}`" not in page] == []


def test_the_summary_counts_what_never_settled_as_worse_than_all_that_did(tmp_path: Path) -> None:
    """In 50 ms none settles: the table says never, and how many."""
    path = written(
        tmp_path,
        "set: {reference.at: 0.01}\nrun: {duration: 0.05}\n"
        "vary: {supply.pressure: {from: 5.0e5, to: 6.0e5, count: 3}}",
    )
    found = sweep(path, tmp_path / "out")
    (line,) = (one for one in summary(found).splitlines() if one.startswith("| settling"))
    assert line == "| settling time, s | - | - | - | 3 |"
    (line,) = (one for one in summary(found).splitlines() if one.startswith("| peak"))
    assert line.startswith("| peak error, mm | 5")
    assert draw_rows(found).axes


@pytest.mark.filterwarnings("error")
def test_texts_are_drawn_over_their_axis(tmp_path: Path) -> None:
    """Both forms of friction stand below the panel, beside the numbers of the other axis."""
    path = written(
        tmp_path,
        "set: {reference.at: 0.0}\nrun: {duration: 0.05}\n"
        "vary: {friction.form: [stribeck, saturating], supply.pressure: [5.0e5, 6.0e5]}",
    )
    figure = draw_rows(sweep(path, tmp_path / "out"))
    figure.draw_without_rendering()
    shown = {label.get_text() for panel in figure.axes for label in panel.get_xticklabels()}
    assert {"stribeck", "saturating"} <= shown


def test_panels_above_one_another_have_one_axis(tmp_path: Path) -> None:
    """Where one level alone settles, its dot stands above that level, not in the middle."""
    path = written(
        tmp_path,
        "run: {duration: 0.6}\nset: {reference.at: 0.01}\n"
        "vary: {friction.form: [stribeck, saturating], supply.pressure: [2.0e5, 6.0e5]}",
    )
    found = sweep(path, tmp_path / "out")
    settled = ~np.isnan(found["settling_time"])
    assert settled.any()
    assert not settled.all()
    panels = draw_rows(found).axes
    below = panels[-len(found.axes) :]
    assert all(
        panel.get_xlim() == below[place % len(below)].get_xlim()
        for place, panel in enumerate(panels)
    )
    left, right = below[0].get_xlim()
    assert left < 0.0
    assert right > 1.0
    assert [label.get_text() for label in below[0].get_xticklabels()] == ["stribeck", "saturating"]


def test_an_axis_has_the_unit_of_what_it_varies(tmp_path: Path) -> None:
    """Pa for the supply, 1 for a factor; a pattern of frictions in N and N s/m has none."""
    path = written(
        tmp_path,
        "set: {reference.at: 0.0}\nrun: {duration: 0.02}\n"
        "vary:\n"
        "  supply.pressure: [5.0e5, 6.0e5]\n"
        "  cylinder.moving_mass: {from: 1, to: 2, count: 2, factor: true}\n"
        '  "friction.forward.[cv]*": [10.0, 20.0]',
    )
    found = sweep(path, tmp_path / "out")
    assert [found.unit(axis) for axis in found.axes] == ["Pa", "1", ""]
    assert found.to_dataframe().attrs["units"]["supply.pressure"] == "Pa"
    labels = [panel.get_xlabel() for panel in draw_rows(found).axes]
    assert next(label for label in labels if label) == "supply.\npressure\n/ Pa"


def test_no_worst_is_better_than_the_ninetieth() -> None:
    """Where three of twenty never settled, 90 % and worst both say so."""
    runs = [NO_METRICS._replace(settling_time=0.3 if k < 17 else math.nan) for k in range(20)]
    columns = {"row": np.arange(20), "failure": [""] * 20, "seed": np.arange(20)}
    columns |= dict(zip(RunMetrics._fields, np.array(runs).T, strict=True))
    (line,) = (
        one
        for one in summary(Results(arrow.table(columns), (), 20)).splitlines()
        if one.startswith("| settling")
    )
    assert line == "| settling time, s | 0.300 | never | never | 3 |"


def test_the_parameter_that_matters_has_the_index(tmp_path: Path) -> None:
    """Air used over 0.2 s of a step follows from the supply, and hardly from the mass."""
    path = written(
        tmp_path,
        "set: {reference.at: 0.01}\nrun: {duration: 0.2}\n"
        "vary: {supply.pressure: {from: 5.0e5, to: 7.0e5}, "
        "cylinder.moving_mass: {from: 0.99, to: 1.01}}\n"
        "design: {method: saltelli, rows: 64, seed: 1}",
    )
    study = read_study(path)
    found = sweep(study, tmp_path / "out")
    indices = sensitivities(found, study.seed)
    supply, mass = indices["air"].total
    assert supply > 0.9
    assert mass < 0.1
    assert "| air | " in sensitivity_table(found, indices)
    assert "None of: settling time" in sensitivity_table(found, indices)
    assert draw_sensitivities(found.axes, indices).axes
