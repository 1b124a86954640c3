# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Tuning: a search that finds what is better, goes on where it was, and refuses what cannot be."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from rodless_control import ControllerParameters
from rodless_control.laws import law_class
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.run_metrics import NO_METRICS, RunMetrics
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.shipped import shipped
from rodless_lab.studies.tune import (
    Bench,
    Candidate,
    Candidates,
    NothingKnownError,
    Tuned,
    search,
)
from rodless_lab.studies.tuning_report import front, parameter_text, write_tuned
from rodless_lab.studies.tuning_task import NEVER, Score, Trial, TuningTask, read_task

PID = law_class("pid").PARAMETERS.keys()

TASK = """
base: calibrated
set: {{reference.at: 0.02, controller.kp: 120.0, controller.kd: 25.0}}
vary: {{cylinder.moving_mass: {{from: 0.7, to: 2.0}}}}
design: {{method: sobol, rows: 3}}
run: {{duration: 0.6}}
tune:
  controller.kp: {{from: 50.0, to: 1000.0, scale: logarithmic}}
  controller.kd: {{from: 1.0, to: 50.0}}
score: {{quantile: 1.0, figures: {{mean_error: 1.0e-2, overshoot: 1.0e-2{more}}}}}
search: {{generations: 2, population: 4, seed: 5}}
{extra}
"""


TRIALS = """
trials:
  step: {figures: {mean_error: 1.0e-3}}
  sine:
    set: {reference.type: sine, cylinder.initial_position: 0.1}
    run: {duration: 0.3}
    figures: {peak_error: 1.0e-3}
"""


def written(folder: Path, more: str = "", extra: str = "") -> Path:
    """A small task: two gains over three rigs."""
    path = folder / "small.yaml"
    path.write_text(TASK.format(more=more, extra=extra), encoding="utf-8")
    return path


def with_trials(folder: Path, trials: str, all_set: str = "") -> Path:
    """The same with trials, which have the figures instead of the score, and more set for all."""
    path = written(folder, extra=trials)
    text = path.read_text(encoding="utf-8").replace(
        "score: {quantile: 1.0, figures: {mean_error: 1.0e-2, overshoot: 1.0e-2}}", "score: {}"
    )
    if all_set:
        text = text.replace("set: {", f"set: {{{all_set}, ", 1)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("common", "step", "sine", "refused"),
    [
        ("reference.frequency: 0.5", "", "reference.type: sine", None),
        ("reference.type: step, reference.target: 0.12", "", "reference.type: sine", None),
        (
            "reference.frequency: 0.5",
            "",
            "",
            "small.yaml: set: reference.frequency: refused: no run",
        ),
        (
            "reference.target: 0.12",
            "",
            "reference.type: sine, reference.target: 0.1",
            "trials: sine: set: reference.target: refused: no run",
        ),
    ],
)
def test_what_is_set_for_all_trials_is_read_by_one_of_them(
    tmp_path: Path, common: str, step: str, sine: str, refused: str | None
) -> None:
    """A frequency for the sine among them is none that nothing depends on; a trial's own may be."""
    trials = f"""
trials:
  step: {{set: {{{step}}}, figures: {{mean_error: 1.0e-3}}}}
  sine: {{set: {{{sine}}}, figures: {{peak_error: 1.0e-3}}}}
"""
    path = with_trials(tmp_path, trials, common)
    if refused is None:
        assert [trial.name for trial in read_task(path).trials] == ["step", "sine"]
        return
    with pytest.raises(StudyError) as error:
        read_task(path)
    assert refused in str(error.value)


def test_the_values_found_score_better_than_those_before(tmp_path: Path) -> None:
    """Their score is that of the three rigs run by themselves; those in force were tried too."""
    task = read_task(written(tmp_path))
    found = search(task, tmp_path / "out")
    before = Bench(task).measured(task.present())
    after = Bench(task).measured(found.values)
    assert found.complete
    assert found.best.score == task.score(after) < task.score(before)
    assert min(one.score for one in found.candidates) == found.best.score
    assert any(task.score(before) == pytest.approx(one.score) for one in found.candidates[:8])


def test_a_search_that_goes_on_ends_where_one_in_one_go_does(tmp_path: Path) -> None:
    """Stopped twice, with half a line in its journal: the same candidates, none tried twice."""
    task = read_task(written(tmp_path))
    whole = search(task, tmp_path / "whole")
    folder = tmp_path / "parts"
    for asked in (3, 9):
        left = iter([False] * asked)
        assert not search(task, folder, stopped=partial(next, left, True)).complete
        journal = folder / "candidates.jsonl"
        with journal.open("a", encoding="utf-8") as file:
            file.write('["0123456789abcdef", [[0.1, 0.2], 3.0, {"mean')
    found = search(task, folder)
    assert found == whole
    lines = [json.loads(line) for line in journal.read_text(encoding="utf-8").splitlines()]
    assert [Candidate(tuple(a), b, c) for _, (a, b, c) in lines] == whole.candidates


def test_the_parameter_file_is_the_candidate(tmp_path: Path) -> None:
    """The controller loads it with all digits; page and picture stand beside it.

    It has the gains of the task's base too, and so is the same law wherever it is laid on.
    """
    task = read_task(written(tmp_path))
    found = search(task, tmp_path / "out")
    text = write_tuned(tmp_path / "out", task, found)
    loaded = ControllerParameters.from_file(tmp_path / "out" / "tuned.yaml")
    assert {name: loaded[name] for name in found.values} == found.values
    law = task.study.base.controller.with_values(found.values)
    assert {name: loaded[name] for name in PID} == {name: law[name] for name in PID}
    assert any(law[name] != ControllerParameters()[name] for name in PID - found.values.keys())
    assert "at the 1 quantile: score" in (tmp_path / "out" / "tuned.yaml").read_text(
        encoding="utf-8"
    )
    assert "in the mean from the 1 quantile on" in parameter_text(
        replace(task, mean_beyond=True), found
    )
    assert "| `controller.kp` | 120 | " in text
    assert text.count("| others |") == text.count("| tuned on |") == 2
    assert (tmp_path / "out" / "tuning.md").read_text(encoding="utf-8").count("trade_off.png") == 1
    assert (tmp_path / "out" / "trade_off.png").stat().st_size > 1000


def test_the_parameter_file_has_the_limits_of_the_output(tmp_path: Path) -> None:
    """A law tuned about 5.2 V and up to 8 V is loaded with these, whatever file lies below."""
    limits = {"controller.neutral_voltage": 5.2, "controller.maximum_voltage": 8.0}
    path = written(tmp_path)
    given = "".join(f"{name}: {value}, " for name, value in limits.items())
    text = path.read_text(encoding="utf-8").replace("set: {", f"set: {{{given}")
    path.write_text(text, encoding="utf-8")
    task = read_task(path)
    best = Candidate((0.5, 0.5), 1.0, {})
    tuned = tmp_path / "tuned.yaml"
    found = Tuned(task.present(), best, [best], complete=True)
    tuned.write_text(parameter_text(task, found), encoding="utf-8")
    loaded = ControllerParameters.from_file(tuned)
    assert {name: loaded[name] for name in limits} == limits


def test_the_score_is_a_quantile_of_what_the_rigs_cost() -> None:
    """Sizes of errors count, a rig without a figure costs ten, and so does one far beyond."""
    rows = [
        NO_METRICS._replace(mean_error=value, settling_time=time)
        for value, time in ((-1e-4, 1.0), (2e-4, 0.5), (1.0, np.nan))
    ]
    found = Ensemble(rows, {})
    score = Score({"mean_error": 1e-4, "settling_time": 1.0})
    assert score.costs(found) == pytest.approx([2.0, 2.5, 2.0 * NEVER])
    task = TuningTask("both", (Trial("a", None, score),) * 2, {}, 0.5, 1, 1, 1)  # type: ignore[arg-type]
    assert task.score([found, found]) == pytest.approx(5.0)


def test_the_mean_beyond_the_quantile_counts_each_of_the_worst() -> None:
    """Of twenty rigs the five worst, by hand; the quantile itself knows the fifth alone."""
    costs = np.random.default_rng(4).permutation(np.arange(20.0)) / 2.0
    found = Ensemble([NO_METRICS._replace(mean_error=cost) for cost in costs], {})
    one = TuningTask("worst", (Trial("", None, Score({"mean_error": 1.0})),), {}, 0.78, 1, 1, 1)  # type: ignore[arg-type]
    assert one.score([found]) == 7.5
    assert replace(one, mean_beyond=True).score([found]) == (7.5 + 8.0 + 8.5 + 9.0 + 9.5) / 5.0


def test_a_search_may_begin_near_the_values_in_force(tmp_path: Path) -> None:
    """With `spread` the first forty lie about them, as far as it says; without, all over."""
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8").replace("population: 4", "population: 20")
    first = {}
    for spread in (0.0, 0.02):
        path.write_text(text.replace("seed: 5", f"seed: 5, spread: {spread}"), encoding="utf-8")
        task, left = read_task(path), iter([False] * 40)
        found = search(task, tmp_path / f"{spread}", stopped=partial(next, left, True))
        assert task.candidates == 120
        first[spread] = np.array([one.shares for one in found.candidates])
        assert first[spread][0] == pytest.approx(task.present_shares)
    deviations = {spread: np.std(shares, axis=0) for spread, shares in first.items()}
    assert deviations[0.02] == pytest.approx([0.02, 0.02], rel=0.4)
    # The standard deviation of numbers that are spread evenly from 0 to 1.
    assert deviations[0.0] == pytest.approx([12.0**-0.5] * 2, rel=0.2)


def test_finalists_meet_on_rigs_that_the_search_has_not_seen(tmp_path: Path) -> None:
    """Of three and the values in force the one that scores best there is taken, by hand.

    Interrupted among them and gone on, it is the same; the report's other rigs are others again.
    """
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8").replace("seed: 5", "seed: 5, finalists: 4")
    path.write_text(text, encoding="utf-8")
    task = read_task(path)
    asked: list[None] = []  # whether it is to stop, last before each finalist
    found = search(task, tmp_path / "whole", stopped=lambda: bool(asked.append(None)))
    assert found.candidates == search(replace(task, finalists=0), tmp_path / "plain").candidates
    in_force, *others = found.candidates
    finalists = [in_force, *sorted(others, key=lambda one: one.score)[:3]]
    seeds = [one.study.seed for one in task.finals()]
    assert len({task.study.seed, *seeds, task.other_rigs().study.seed}) == 5

    def final_score(one: Candidate) -> float:
        values = task.values(np.array(one.shares))
        return float(
            np.mean([final.score(Bench(final).measured(values)) for final in task.finals()])
        )

    scores = [final_score(one) for one in finalists]
    assert found.final_score == min(scores)
    assert found.best == finalists[int(np.argmin(scores))]
    left = iter([False] * (len(asked) - 2))
    assert not search(task, tmp_path / "parts", stopped=partial(next, left, True)).complete
    kept = (tmp_path / "parts" / "finalists.jsonl").read_text(encoding="utf-8")
    assert kept.count("\n") == 2
    assert search(task, tmp_path / "parts") == found
    assert "of 4 finalists the best on 9 other rigs" in parameter_text(task, found)


def test_each_trial_is_done_by_the_same_rigs(tmp_path: Path) -> None:
    """A trial changes what the file says of all; rigs and noise stay; its figures have its name.

    To the letter, also in the picture, which takes what is between dollar signs for a formula.
    """
    task = read_task(with_trials(tmp_path, TRIALS.replace("  sine:", "  sine $^$:")))
    rigs = [[dict(one.study.row(k).base.rig) for k in range(3)] for one in task.trials]
    for step, sine in zip(*rigs, strict=True):
        assert sine["cylinder.initial_position"] == 0.1
        assert step == {**sine, "cylinder.initial_position": step["cylinder.initial_position"]}
    assert [one.study.base.duration for one in task.trials] == [0.6, 0.3]
    found = Bench(task).candidate(np.array([0.5, 0.5]))
    assert set(found.figures) == {"step: mean_error", "sine $^$: peak_error"}
    alone = [
        trial.score.costs(one)
        for trial, one in zip(
            task.trials, Bench(task).measured(task.values(np.array([0.5, 0.5]))), strict=True
        )
    ]
    assert found.score == sorted(alone[0] + alone[1])[2]
    text = write_tuned(tmp_path / "out", task, search(task, tmp_path / "out"))
    assert "| sine $^$: peak error, mm |" in text


@pytest.mark.parametrize(
    "axis", ["supply.pressure: {from: 5.0e5, to: 6.0e5}", "friction.*.static: [30.0, 40.0]"]
)
def test_a_trial_with_other_rigs_is_refused(tmp_path: Path, axis: str) -> None:
    """One axis more would draw all others anew: the costs of two rigs would be added up."""
    trials = TRIALS.replace("run: {duration: 0.3}", f"vary: {{{axis}}}")
    path = with_trials(tmp_path, trials)
    with pytest.raises(StudyError, match="sine: vary: refused, other axes than those of step"):
        read_task(path)


@pytest.mark.parametrize("name", ["controller.ki", "controller.kp", "controller.maximum_voltage"])
def test_a_trial_with_another_law_is_refused(tmp_path: Path, name: str) -> None:
    """tuned.yaml has each of the law's parameters once, tuned or not: as all trials have it."""
    trials = TRIALS.replace("reference.type: sine", f"reference.type: sine, {name}: 9.5")
    with pytest.raises(StudyError, match=f"trials: sine: {name}: refused, a task tunes one law"):
        read_task(with_trials(tmp_path, trials))
    if name != "controller.kp":  # which is set for all
        assert len(read_task(with_trials(tmp_path, TRIALS, f"{name}: 9.5")).trials) == 2


def test_what_trials_have_in_common_need_not_run_by_itself(tmp_path: Path) -> None:
    """Its reference would begin once its run is over; those of the trials begin before."""
    trials = """
trials:
  short: {set: {reference.at: 0.1}, figures: {mean_error: 1.0e-3}}
  long: {run: {duration: 0.9}, figures: {mean_error: 1.0e-3}}
"""
    path = with_trials(tmp_path, trials)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("reference.at: 0.02", "reference.at: 0.7"), encoding="utf-8")
    assert [trial.study.base.duration for trial in read_task(path).trials] == [0.6, 0.9]
    path.write_text(
        text.replace("reference.at: 0.02", "reference.at: 0.7").replace(
            "{reference.at: 0.1}", "{}"
        ),
        encoding="utf-8",
    )
    with pytest.raises(StudyError, match=r"trials: short: row 0 of 3: reference\.at: 0\.7 s ref"):
        read_task(path)


def test_a_trial_may_vary_what_the_others_set(tmp_path: Path) -> None:
    """If all do, they have the same rigs; what is set for all gives way."""
    vary = "vary: {supply.pressure: {from: 5.0e5, to: 6.0e5}}"
    trials = f"""
trials:
  first: {{{vary}, figures: {{mean_error: 1.0e-3}}}}
  second: {{{vary}, figures: {{mean_error: 1.0e-3}}}}
"""
    path = with_trials(tmp_path, trials, "supply.pressure: 7.0e5")
    axes = [[one.name for one in trial.study.dimensions] for trial in read_task(path).trials]
    assert axes == [["cylinder.moving_mass", "supply.pressure"]] * 2


@pytest.mark.parametrize(
    ("axis", "low", "high"),
    [
        ("supply.pressure: {from: 0.9, to: 1.1, factor: true}", 0.9 * 7.0e5, 1.1 * 7.0e5),
        ("supply.pressur*: {from: 5.0e5, to: 6.0e5}", 5.0e5, 6.0e5),
    ],
)
def test_a_trial_multiplies_what_all_set_and_replaces_it_by_a_pattern(
    tmp_path: Path, axis: str, low: float, high: float
) -> None:
    """Factors need what is set; a name with a star is as good as the whole one."""
    trials = f"""
trials:
  first: {{vary: {{{axis}}}, figures: {{mean_error: 1.0e-3}}}}
  second: {{vary: {{{axis}}}, figures: {{mean_error: 1.0e-3}}}}
"""
    path = with_trials(tmp_path, trials, "supply.pressure: 7.0e5")
    for trial in read_task(path).trials:
        rows = [trial.study.row(k).base.rig for k in range(len(trial.study))]
        pressures = [rig.number("supply.pressure") for rig in rows]
        assert low <= min(pressures) < max(pressures) <= high


def test_a_grid_has_other_rigs_too(tmp_path: Path) -> None:
    """For finals and the report: as many, drawn within its ranges, none of them of the grid."""
    text = written(tmp_path).read_text(encoding="utf-8")
    text = text.replace("to: 2.0}", "to: 2.0, count: 4}").replace("method: sobol, rows: 3", "")
    path = tmp_path / "grid.yaml"
    path.write_text(text, encoding="utf-8")
    task = read_task(path)

    def masses(one: TuningTask) -> list[float]:
        rows = (one.study.row(k).base.rig for k in range(len(one.study)))
        return [rig.number("cylinder.moving_mass") for rig in rows]

    assert len(masses(task)) == len(masses(task.other_rigs())) == 4
    assert not set(masses(task)) & set(masses(task.other_rigs()))
    assert all(0.7 <= mass <= 2.0 for mass in masses(task.other_rigs()))


@pytest.mark.parametrize("name", shipped("tasks"))
def test_the_values_in_force_are_tried_to_the_last_digit(name: str) -> None:
    """Their shares give them back, though a logarithm and a power lie between."""
    task = read_task(name)
    assert task.outside() == {}
    assert task.values(task.present_shares) == task.present()
    assert task.values(task.present_shares + 1e-9) != task.present()


def test_a_damaged_journal_is_refused_and_the_folder_is_free_again(tmp_path: Path) -> None:
    """A line that has changed, wherever it stands: it is named, each time, and nothing is lost."""
    task = read_task(written(tmp_path))
    search(task, tmp_path / "out", stopped=partial(next, iter([False] * 5), True))
    journal = tmp_path / "out" / "candidates.jsonl"
    lines = journal.read_text(encoding="utf-8").splitlines()
    digits, (shares, score, figures) = json.loads(lines[2])
    for bad in (
        "[1]",
        "{}",
        "[" * 100_000,
        lines[2][:40],
        json.dumps([shares, score, figures]),
        json.dumps([digits, [shares, score + 1e-9, figures]]),
        json.dumps([digits, [shares[:-1], score, figures]]),
    ):
        text = "\n".join([*lines[:2], bad, *lines[3:], ""])
        journal.write_text(text, encoding="utf-8")
        for _ in range(2):
            with pytest.raises(
                StudyError, match=r"candidates\.jsonl: line 3 is damaged; remove"
            ) as no:
                Candidates(tmp_path / "out", task)
            assert "\n" not in str(no.value)
        assert journal.read_text(encoding="utf-8") == text
    journal.write_text("\n".join([*lines, ""]), encoding="utf-8")
    Candidates(tmp_path / "out", task).close()
    (tmp_path / "out" / "finalists.jsonl").write_text(lines[0] + "\n")
    with pytest.raises(StudyError, match=r"finalists\.jsonl: line 1 is damaged; remove that line"):
        Candidates(tmp_path / "out", task)


def test_a_search_that_ends_with_its_generations_has_not_converged(tmp_path: Path) -> None:
    """Two generations of eight are not enough for the candidates to score alike."""
    assert not search(read_task(written(tmp_path)), tmp_path / "out").converged


def test_figures_stand_in_one_place(tmp_path: Path) -> None:
    """Those of the score are refused where trials have their own."""
    with pytest.raises(StudyError, match="score: figures: refused: each of trials has its own"):
        read_task(written(tmp_path, extra=TRIALS))


def test_the_front_is_what_no_other_point_beats() -> None:
    """Found by comparing each point with all others."""
    points = np.random.default_rng(1).random((60, 2))
    beaten = [any((other < one).all() for other in points) for one in points]
    expected = points[~np.array(beaten)]
    assert {*map(tuple, front(points))} == {*map(tuple, expected)}
    assert front(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("name", shipped("tasks"))
def test_the_tasks_that_ship_can_be_done(name: str) -> None:
    """By name; the figures they score are there."""
    task = read_task(name)
    assert len(task.study) >= 16
    for trial in task.trials:
        assert trial.score.figures.keys() <= set(RunMetrics._fields)


@pytest.mark.parametrize(
    ("more", "extra", "expected"),
    [
        (", speed: 1.0", "", "score: figures: speed: no such figure, there are final_error"),
        (", air: 0.0", "", "score: figures: air: 0 refused, must be the size that costs 1"),
        ("", "serch: {}", "serch: no such field; did you mean search?"),
        ("", "sensors: none", "sensors: 'none' refused"),
    ],
)
def test_a_task_that_cannot_be_done_is_refused_in_one_line(
    tmp_path: Path, more: str, extra: str, expected: str
) -> None:
    """With file, key and value."""
    path = written(tmp_path, more, extra)
    with pytest.raises(StudyError) as refusal:
        read_task(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert expected in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("controller.kd: {", "controller.kx: {", "controller.kx: no such parameter of the law"),
        ("from: 50.0, to: 1000.0", "from: 50.0, to: 1.0e9", "must be within 0 to"),
        ("quantile: 1.0", "quantile: 2.0", "score: quantile: 2 refused, must be from 0 to 1"),
        ("score: {", "scroe: {", "scroe: no such field; did you mean score?"),
        ("design: {", "desing: {", "desing: no such field; did you mean design?"),
        ("seed: 5", "finalists: -1", "search: finalists: -1 refused, must be from 0 to 1000"),
        ("seed: 5", "finalists: 1", "search: finalists: 1 refused, it is the values in force"),
        ("seed: 5", "spread: 1.5", "search: spread: 1.5 refused, must be from 0 to 1"),
        ("quantile: 1.0", "mean_beyond: 3", "score: mean_beyond: 3 refused, must be true or false"),
        ("generations: 2", "generations: 0", "search: generations: 0 refused"),
        (
            "cylinder.moving_mass: {",
            "controller.ki: {",
            "vary: controller.ki: refused, a task varies rigs alone",
        ),
        ("kd: {from: 1.0, to: 50.0}", "kd: [1.0, 2.0]", "must be a range, from and to"),
    ],
)
def test_each_field_of_a_task_is_checked(
    tmp_path: Path, before: str, after: str, expected: str
) -> None:
    """Against what the law declares, and the ranges of the fields."""
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")
    with pytest.raises(StudyError) as refusal:
        read_task(path)
    assert expected in str(refusal.value)


TWO_AXES = """
base: calibrated
set: {reference.type: step, reference.target: 0.058}
vary:
  cylinder.stroke: {from: 0.30, to: 0.5}
  cylinder.initial_position: {from: 0.0, to: 0.32}
design: {method: random, rows: 8, seed: 1}
run: {duration: 1.0}
tune: {controller.kp: {from: 500.0, to: 5000.0}}
score: {figures: {mean_error: 1.0e-4}}
search: {finalists: 2}
"""


def test_rigs_that_only_the_finals_draw_are_checked_as_well(tmp_path: Path) -> None:
    """Hours later they would be refused: its own eight are rigs, those of the finals not all."""
    path = tmp_path / "two.yaml"
    path.write_text(TWO_AXES, encoding="utf-8")
    with pytest.raises(
        StudyError, match=r"the search does not see, by seed \d+: .*cylinder\.initial_position: "
    ):
        read_task(path)


TWO_LAWS = """
base: calibrated
vary: {cylinder.moving_mass: {from: 0.7, to: 1.0}}
design: {method: random, rows: 2}
tune: {controller.kp: {from: 500.0, to: 5000.0}}
trials:
  a: {set: {reference.type: step}, run: {duration: 1.0}, figures: {mean_error: 1.0e-4}}
  b:
    set: {reference.type: step, controller.law: adrc}
    run: {duration: 1.0}
    figures: {mean_error: 1.0e-4}
"""


def test_trials_of_two_laws_are_refused(tmp_path: Path) -> None:
    """No candidate could do both."""
    path = tmp_path / "two.yaml"
    path.write_text(TWO_LAWS, encoding="utf-8")
    with pytest.raises(StudyError, match=r"trials: b: controller\.law: refused, a task tunes one"):
        read_task(path)


NAMED_AS_A_RIGS = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Named(Law):
    PARAMETERS = declare(Parameter("supply.pressure", 1.0, "V", "a gain", "own", 0.0, 2.0))

    def update(self, measurement, reference, interval):
        return 5.0
"""


def test_a_name_that_the_rig_has_too_is_not_tuned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rig's would change with each candidate, and the law's never."""
    (tmp_path / "named_law.py").write_text(NAMED_AS_A_RIGS, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "named.yaml"
    path.write_text(
        "{set: {controller.law: 'named_law:Named'}, tune: {supply.pressure: {from: 0.1, to: 2.0}},"
        " score: {figures: {mean_error: 1.0e-4}}}",
        encoding="utf-8",
    )
    with pytest.raises(
        StudyError,
        match=r"tune: supply\.pressure: the rig has it, and named_law:Named too; rename the law's",
    ):
        read_task(path)


@pytest.mark.parametrize("error", [ValueError("odd"), TypeError("odder")])
def test_a_candidate_that_cannot_be_tried_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    """Not that a function handed to scipy is none; the folder is free again."""

    def candidate(*_: object) -> Candidate:
        raise error

    task = read_task(written(tmp_path))
    with monkeypatch.context() as odd:
        odd.setattr(Bench, "candidate", candidate)
        with pytest.raises(type(error), match=f"^{error}$"):
            search(task, tmp_path / "out")
    assert search(task, tmp_path / "out").complete


def test_the_folder_of_another_task_is_left_alone(tmp_path: Path) -> None:
    """A search does not mix its candidates with those of another."""
    left = iter([False, False])
    search(read_task(written(tmp_path)), tmp_path / "out", stopped=lambda: next(left, True))
    other = read_task(written(tmp_path, ", air: 1.0e-3"))
    with pytest.raises(StudyError, match="holds the search of another task"):
        search(other, tmp_path / "out")


def test_two_searches_at_once_do_not_share_a_folder(tmp_path: Path) -> None:
    """The second is refused while the first has it open, and not after."""
    task = read_task(written(tmp_path))
    first = Candidates(tmp_path / "out", task)
    with pytest.raises(StudyError, match="another process writes there"):
        search(task, tmp_path / "out")
    first.close()
    Candidates(tmp_path / "out", task).close()


def test_a_search_that_is_interrupted_at_once_leaves_nothing(tmp_path: Path) -> None:
    """No folder that would be this task's from then on; what somebody else has there stays."""
    task, new = read_task(written(tmp_path)), tmp_path / "new"
    with pytest.raises(NothingKnownError, match="interrupted before the first candidate"):
        search(task, new, stopped=lambda: True)
    assert not new.exists()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").touch()
    with pytest.raises(NothingKnownError):
        search(task, tmp_path / "other", stopped=lambda: True)
    assert [file.name for file in (tmp_path / "other").iterdir()] == ["notes.txt"]


def test_a_search_that_goes_on_keeps_what_it_knew(tmp_path: Path) -> None:
    """Interrupted before the first new candidate: its result is that of all it knew, no less."""
    task, folder = read_task(written(tmp_path)), tmp_path / "out"
    before = search(task, folder, stopped=partial(next, iter([False] * 3), True))
    files = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert len(before.candidates) == 3
    assert search(task, folder, stopped=lambda: True) == before
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == files


def test_a_search_that_is_over_is_found_again_whole_however_early_it_is_stopped(
    tmp_path: Path,
) -> None:
    """Its finals too: else its file would hold the best of the search, and not the one chosen."""
    task = replace(read_task(written(tmp_path)), finalists=2)
    whole = search(task, tmp_path / "out")
    assert whole.final_score is not None
    assert search(task, tmp_path / "out", stopped=lambda: True) == whole
