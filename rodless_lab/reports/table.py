# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Comparisons as the cells of a table, for Markdown, HTML and the terminal alike."""

import math
import re
from collections.abc import Sequence

from rodless_lab.experiments.result import Comparison, Limits

HEADINGS = ("quantity", "obtained", "paper", "must lie", "holds", "why these limits")


def cells(row: Comparison) -> tuple[str, ...]:
    """Return the texts of one row in the order of ``HEADINGS``."""
    return (
        row.quantity,
        value_text(row),
        minus(row.paper),
        "" if row.limits is None else span(row.limits, row.decimals),
        "" if row.limits is None else "yes" if row.holds else "NO",
        "" if row.limits is None else minus(row.limits.why),
    )


def value_text(row: Comparison) -> str:
    """Write the number obtained with its unit; infinite stands for what did not come."""
    if math.isinf(row.value):
        return "not in this run"
    return f"{number(row.value, row.decimals)} {row.unit}".rstrip()


def minus(text: str) -> str:
    """Write hyphens before numbers as minus signs, except within a word."""
    return re.sub(r"(?<!\w)-(?=\d)", "−", text)


def number(value: float, decimals: int) -> str:
    """Write a number with a true minus sign and without a negative zero."""
    if math.isnan(value):
        return "not a number"
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", "−")


def span(limits: Limits, decimals: int) -> str:
    """Say in words where a number must lie."""
    low, high = number(limits.lowest, decimals), number(limits.highest, decimals)
    if math.isinf(limits.highest):
        return f"above {low}"
    if math.isinf(limits.lowest):
        return f"below {high}"
    return f"at {low}" if limits.lowest == limits.highest else f"{low} to {high}"


def markdown_table(rows: Sequence[Comparison]) -> str:
    """Return the table in Markdown."""
    lines = [HEADINGS, ("---",) * len(HEADINGS), *map(cells, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def verdict(rows: Sequence[Comparison]) -> str:
    """Say how many of the judged numbers hold, and name those that do not."""
    judged = [row for row in rows if row.limits is not None]
    failed = [row.quantity for row in judged if not row.holds]
    text = f"{len(judged) - len(failed)} of {len(judged)} hold"
    return text + "".join(f"\n  leaves its limits: {name}" for name in failed)
