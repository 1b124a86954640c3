# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a search leaves: the parameter file, and a page with the trade-off."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rodless_base.atomic_write import write_together
from rodless_base.yaml_file import yaml_text
from rodless_lab.figures.files import figure_contents, files_of_figure
from rodless_lab.figures.style import label, literal, panels
from rodless_lab.simulation.ensemble import Ensemble
from rodless_lab.simulation.quantile import nth
from rodless_lab.studies.summary import shown
from rodless_lab.studies.tune import IMPOSSIBLE, Bench, Candidate, Tuned, figures_of
from rodless_lab.studies.tuning_task import TuningTask

PARAMETERS = "tuned.yaml"
PAGE = "tuning.md"
PICTURE = "trade_off"


def result_files(folder: Path) -> list[Path]:
    """Return where parameter file, page and picture may go."""
    return [folder / PARAMETERS, folder / PAGE, *files_of_figure(folder, PICTURE)]


def write_tuned(folder: Path, task: TuningTask, found: Tuned) -> str:
    """Write parameter file, page and picture; return the page's table.

    The table has the values before and after, on the rigs they were tuned on and on as many others.
    Raises OSError where the folder cannot be written.
    """
    contents: dict[Path, str | bytes] = {}
    table = _table(task, found, {"tuned on": Bench(task), "others": Bench(task.other_rigs())})
    pictures = ""
    if len(labels(task)) > 1 and not len(_points(task, found)):
        pictures = "\nNo candidate has both of the first two figures: there is no picture.\n"
    elif len(labels(task)) > 1:
        contents |= figure_contents(folder, PICTURE, lambda: draw_trade_off(task, found))
        pictures = "\n![Trade-off between two figures](trade_off.png)\n"
    values = _values_table(task, found)
    contents[folder / PAGE] = f"# {task.name}\n\n{values}\n{table}{pictures}"
    contents[folder / PARAMETERS] = parameter_text(task, found)
    write_together(contents)
    return f"{values}\n{table}"


def labels(task: TuningTask) -> dict[str, str]:
    """Return what each figure that is scored is called, and which one it is."""
    return {trial.label(figure): figure for trial in task.trials for figure in trial.score.figures}


def parameter_text(task: TuningTask, found: Tuned) -> str:
    """Return a parameter file for the controller: the values found, and the law's other ones.

    It has the law's whole set with the limits of its output, so that what it does depends on no
    preset that it is laid on.
    """
    controller = task.study.base.controller
    law = controller.text("controller.law")
    values = {**controller.of_law(), **found.values}
    figures = ", ".join(labels(task))
    rigs = len(task.study)
    lines = [
        f"# Tuned by `rodless tune {task.name}`: the law {law} over {rigs} rigs, by {figures}",
        f"# {_scored(task)}: score {found.best.score:.6g}{_of_finals(task, found)}.",
        "/**/controller:",
        "  ros__parameters:",
        f"    controller.law: {law}",
        *(f"    {name}: {yaml_text(value)}" for name, value in values.items()),
    ]
    return "\n".join(lines) + "\n"


def _of_finals(task: TuningTask, found: Tuned) -> str:
    if not task.finalists:
        return ""
    count = len(task.finals()) * len(task.study)
    if found.final_score is None:
        return f"; the finalists have not met on {count} other rigs yet: go on by the same command"
    finalists = min(task.finalists, len(found.candidates))
    return f"; of {finalists} finalists the best on {count} other rigs: {found.final_score:.6g}"


def _scored(task: TuningTask) -> str:
    at = f"the {task.quantile:g} quantile"
    return f"in the mean from {at} on" if task.mean_beyond else f"at {at}"


def _values_table(task: TuningTask, found: Tuned) -> str:
    declared = task.study.base.controller.DECLARATIONS
    lines = ["| parameter | before | tuned | unit |", "|---|---|---|---|"]
    for name, before in task.present().items():
        after = found.values[name]
        lines.append(f"| `{name}` | {before:g} | {after:.6g} | {declared[name].unit} |")
    return "\n".join(lines) + "\n"


def _table(task: TuningTask, found: Tuned, benches: dict[str, Bench]) -> str:
    heads = [
        f"{label.replace('_', ' ')}, {shown(figure).unit}" for label, figure in labels(task).items()
    ]
    lines = [f"| rigs | values | score | {' | '.join(heads)} |", "|---" * (len(heads) + 3) + "|"]
    for rigs, bench in benches.items():
        for which, values in (("before", task.present()), ("tuned", found.values)):
            lines.append(_line(task, rigs, which, bench.measured(values)))
    note = (
        f"Figures at the {task.quantile:g} quantile of {len(task.study)} rigs, the "
        f"{nth(len(task.study), task.quantile)} by size; the score is what they cost, "
        f"{_scored(task)}."
    )
    return "\n".join([*lines, "", note]) + "\n"


def _line(task: TuningTask, rigs: str, which: str, measured: Sequence[Ensemble]) -> str:
    called = labels(task)
    cells = [
        f"{value * shown(called[label]).scale:.3f}" if np.isfinite(value) else "never"
        for label, value in figures_of(task, measured).items()
    ]
    return f"| {rigs} | {which} | {task.score(measured):.4g} | {' | '.join(cells)} |"


def draw_trade_off(task: TuningTask, found: Tuned) -> Figure:
    """Draw all candidates by the first two figures of the score, and those no other one beats."""
    (first, of_first), (second, of_second), *_ = labels(task).items()
    there = _points(task, found)
    figure, (panel,) = panels()
    panel.plot(there[:, 0], there[:, 1], ".", color="0.7", label="tried")
    edge = front(there)
    panel.plot(edge[:, 0], edge[:, 1], ".-", label="no other is better in both")
    chosen = _point(task, found.best)
    panel.plot(chosen[0], chosen[1], "o", color="tab:red", label="taken")
    quantile = f"at the {task.quantile:g} quantile"
    for name, scale in ((first, panel.set_xscale), (second, panel.set_yscale)):
        if len(there) and (there[:, 0 if name == first else 1] > 0.0).all():
            scale("log")
    names = [
        f"{literal(name.replace('_', ' '))} {quantile} / {shown(figure).unit}"
        for name, figure in ((first, of_first), (second, of_second))
    ]
    label(panel, names[0], names[1])
    return figure


def _points(task: TuningTask, found: Tuned) -> np.ndarray:
    """Return the first two figures of all candidates that have both, as shown, shape (n, 2)."""
    points = [_point(task, one) for one in found.candidates if one.score < IMPOSSIBLE]
    return np.array([one for one in points if np.isfinite(one).all()]).reshape(-1, 2)


def _point(task: TuningTask, one: Candidate) -> tuple[float, float]:
    (first, of_first), (second, of_second), *_ = labels(task).items()
    x, y = (one.figures.get(label, np.inf) for label in (first, second))
    return x * shown(of_first).scale, y * shown(of_second).scale


def front(points: np.ndarray) -> np.ndarray:
    """Return the points, shape (n, 2), that no other one is below in both, by the first."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]
    best = np.minimum.accumulate(ordered[:, 1]) if len(ordered) else ordered[:, 1]
    lower = np.r_[True, best[1:] < best[:-1]] if len(ordered) else np.empty(0, dtype=bool)
    return ordered[lower]
