# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A sweep in figures: a table for the terminal and its page, and which parameter matters."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rodless_base.columns import quantities
from rodless_lab.simulation.quantile import nth, quantile
from rodless_lab.simulation.run_metrics import RunMetrics
from rodless_lab.studies.results import Results
from rodless_lab.studies.sensitivity import Indices, sobol_indices

Array = npt.NDArray[np.float64]


class Shown(NamedTuple):
    """How a figure is shown: its unit there, and how many of it make one SI unit."""

    unit: str
    scale: float
    decimals: int


# By the unit of the figure.
UNITS = {"m": Shown("mm", 1e3, 3), "s": Shown("s", 1.0, 3), "kg": Shown("g", 1e3, 3)}
VOLTS = Shown("V", 1.0, 3)

# Of a signed error its size counts.
SIGNED = ("final_error", "mean_error")


def shown(name: str) -> Shown:
    """Return how a figure is shown."""
    (unit,) = (quantity.unit for quantity in quantities(RunMetrics) if quantity.name == name)
    return UNITS.get(unit, VOLTS)


def in_words(name: str) -> str:
    """Return how a figure is called, with a word where its size counts."""
    return name.replace("_", " ") + (", size" if name in SIGNED else "")


def sizes(results: Results, name: str) -> Array:
    """Return a figure of all rows as it is shown, errors without their signs."""
    values = results[name] * shown(name).scale
    return np.abs(values) if name in SIGNED else values


def summary(results: Results) -> str:
    """Return the table of a sweep in Markdown: median, 90 % and worst of each figure."""
    lines = [
        "| figure | median | 90 % | worst | none |",
        "|---|---|---|---|---|",
        *(_line(results, name) for name in RunMetrics._fields),
    ]
    failed = [f"Row {row} failed: {why}" for row, why in list(results.failures.items())[:10]]
    more = len(results.failures) - len(failed)
    if more > 0:
        failed.append(f"{more} more row{'s' * (more > 1)} failed.")
    count = ["1 row."] if len(results) == 1 else [f"{len(results)} rows.", _places(len(results))]
    return "\n".join([*lines, "", *count, *failed]) + "\n"


def _places(rows: int) -> str:
    """Say which values the table has of so many rows."""
    median, most = (nth(rows, share) for share in (0.5, 0.9))
    return f"By size, the median is the {median} value, 90 % the {most}; rows with none come last."


def _line(results: Results, name: str) -> str:
    how, values = shown(name), sizes(results, name)
    there = values[~np.isnan(values)]
    label = f"{in_words(name)}, {how.unit}"
    if not there.size:
        return f"| {label} | - | - | - | {values.size} |"
    cells = [_cell(quantile(values, share), how.decimals) for share in (0.5, 0.9, 1.0)]
    return f"| {label} | {' | '.join(cells)} | {values.size - there.size} |"


def _cell(value: float, decimals: int) -> str:
    return "never" if np.isinf(value) else f"{value:.{decimals}f}"


def sensitivities(results: Results, seed: int) -> dict[str, Indices]:
    """Return the Sobol indices of each figure that a Saltelli design has them of.

    Those of a signed error are of its size.
    """
    found = {
        name: sobol_indices(results.axes, sizes(results, name), seed) for name in RunMetrics._fields
    }
    return {name: indices for name, indices in found.items() if indices is not None}


def sensitivity_table(results: Results, found: dict[str, Indices]) -> str:
    """Return the total indices in Markdown, a row for each figure, and which figures have none."""
    lines = [f"| figure | {' | '.join(results.axes)} |", "|---" * (len(results.axes) + 1) + "|"]
    for name, indices in found.items():
        cells = [
            f"{total:.2f} ± {interval:.2f}"
            for total, interval in zip(indices.total, indices.total_interval, strict=True)
        ]
        lines.append(f"| {in_words(name)} | {' | '.join(cells)} |")
    left_out = [name.replace("_", " ") for name in RunMetrics._fields if name not in found]
    if left_out:
        lines += ["", f"None of: {', '.join(left_out)}. A row has none, or all have the same."]
    return "\n".join(lines) + "\n"
