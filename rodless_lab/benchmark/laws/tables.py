# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The scores as tables in Markdown."""

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from io import StringIO

from rodless_lab.benchmark.laws.contest import LIMIT_CYCLE, Score
from rodless_lab.simulation.quantile import nth

Cell = Callable[[Score], str]


def three(figure: str, scale: float, digits: int) -> Cell:
    """Return what writes median / 90 % / worst."""

    def write(score: Score) -> str:
        return " / ".join(number(one, digits) for one in score.quantiles(figure, scale))

    return write


def number(value: float, digits: int) -> str:
    """Write a figure, or a dash where there is none."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


def _cycles(score: Score) -> str:
    return str(score.count("limit_cycle", LIMIT_CYCLE))


def _travel(score: Score) -> str:
    return number(score.quantiles("valve_travel")[0] / score.task.duration, 1)


def _air(score: Score) -> str:
    return number(score.quantiles("air", 1e3 / score.task.cycles)[0], 2)


MOVES: dict[str, Cell] = {
    "settled to ± 0.2 mm, s": three("settling_time", 1.0, 2),
    "mean error of the last second, µm": three("mean_error", 1e6, 0),
    "overshoot, mm": three("overshoot", 1e3, 2),
    "limit cycles": _cycles,
    "valve travel, V/s": _travel,
}

SINES: dict[str, Cell] = {
    "peak error, mm": three("peak_error", 1e3, 2),
    "RMS error, mm": three("rms_error", 1e3, 2),
    "air a cycle, g": _air,
    "valve travel, V/s": _travel,
}


def markdown(scores: Sequence[Score]) -> str:
    """Return what the numbers are and both tables: moves, and sines."""
    parts = [_places(len(scores[0].runs))] if scores else []
    for title, columns, cyclic in (("Moves", MOVES, False), ("Sines", SINES, True)):
        rows = [one for one in scores if bool(one.task.cycles) is cyclic]
        if rows:
            parts += [f"### {title}", "\n".join(_lines(columns, rows))]
    failed = [line for one in scores for line in _failed(one)]
    if failed:
        parts += ["### Runs without figures", "\n".join(failed)]
    return "\n\n".join(parts) + "\n"


def _places(rigs: int) -> str:
    """Say which of the rigs the three numbers of a cell are of."""
    if rigs == 1:
        return "One rig: median, 90 % and worst are its own."
    median, most = (nth(rigs, share) for share in (0.5, 0.9))
    return (
        f"Median / 90 % / worst of {rigs} rigs: by size the {median}, {most} and last value; a rig "
        "without the figure (–) comes last."
    )


def _failed(score: Score) -> Iterator[str]:
    """Say how many runs have no figures, and why the first of them has none."""
    for place, why in list(score.runs.failures.items())[:1]:
        count = f"{len(score.runs.failures)} of {len(score.runs)}"
        yield f"- {score.entry.name}, {score.task.name}: {count}, the first with rig {place}: {why}"


def _lines(columns: dict[str, Cell], scores: Sequence[Score]) -> Iterator[str]:
    yield "| task | law | " + " | ".join(columns) + " |"
    yield "|---" * (2 + len(columns)) + "|"
    before = ""
    for one in scores:
        task = one.task.name if one.task.name != before else ""
        before = one.task.name
        cells = (cell(one) for cell in columns.values())
        yield f"| {task} | {one.entry.name} | " + " | ".join(cells) + " |"


def rows(scores: Sequence[Score]) -> str:
    """Return the figures of every run as CSV, a line each; ``failure`` says why it has none."""
    names = list(scores[0].runs.columns())
    text = StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(["task", "law", "rig", *names, "failure"])
    for one in scores:
        columns = [one.runs[name].tolist() for name in names]
        # Without commas, for who splits lines at them.
        who = one.task.name.replace(",", ";"), one.entry.name.replace(",", ";")
        for place, values in enumerate(zip(*columns, strict=True)):
            why = one.runs.failures.get(place, "")
            lines.writerow([*who, place, *map(repr, values), why])
    return text.getvalue()
