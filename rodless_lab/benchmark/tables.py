# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The side-by-side measurement as tables in Markdown."""

from collections.abc import Callable, Iterator, Sequence

from rodless_lab.benchmark.side_by_side import OTHERS, QUICK, Measured, SideBySide
from rodless_lab.benchmark.work import Work

SOLVERS = (*QUICK, *OTHERS)

HEADINGS: dict[str, Callable[[SideBySide, Measured], str]] = {
    "Simulated seconds per second of processor time": lambda _, one: speed(one.speed),
    "Processor time ÷ that of this package's compiled loop": lambda found, one: ratio(
        found.ratio(one)
    ),
    "Largest error: position in µm / pressure in Pa": lambda _, one: errors(one),
}


def markdown(found: SideBySide) -> str:
    """Return the tables: settings, then speed, ratios and errors in closed and in open loop."""
    parts = [_table(_settings(found))]
    for title, closed in (("Closed loop", True), ("Open loop", False)):
        work = [one for one in found.work if one.is_closed is closed]
        if work:
            parts.append(f"### {title}")
        for heading, text in HEADINGS.items():
            if work:
                parts += [f"{heading}:", _table(_numbers(found, work, text))]
    return "\n\n".join(parts)


def speed(value: float) -> str:
    """Write a speed: one decimal where it is small."""
    return f"{value:.1f}" if value < 100.0 else f"{value:.0f}"


def ratio(value: float) -> str:
    """Write a ratio: two decimals where it is near 1, none where it is large."""
    return f"{value:.2f}" if value < 10.0 else f"{value:.0f}"


def errors(found: Measured) -> str:
    """Write both errors."""
    return f"{found.errors.position * 1e6:.2g} / {found.errors.pressure:.2g}"


def _settings(found: SideBySide) -> Iterator[tuple[str, ...]]:
    yield "solver", "settings", "tolerance"
    for solver in SOLVERS:
        tolerance = found.tolerance(solver)
        absent = found.missing.get(solver.name, "not measured")
        yield solver.name, solver.settings, absent if tolerance is None else f"{tolerance:g}"


def _numbers(
    found: SideBySide, work: Sequence[Work], text: Callable[[SideBySide, Measured], str]
) -> Iterator[tuple[str, ...]]:
    yield "", *(f"{one.task}, {one.rig}" for one in work)
    for solver in SOLVERS:
        shown = (found.shown(solver, one) for one in work)
        yield solver.name, *("" if one is None else text(found, one) for one in shown)


def _table(rows: Iterator[tuple[str, ...]]) -> str:
    head, *body = rows
    lines = [head, ("---",) * len(head), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
