# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""One report of several experiments: a self-contained HTML file and a Markdown summary."""

import base64
import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

from rodless_base.atomic_write import write_together
from rodless_lab.experiments.experiment import Experiment
from rodless_lab.experiments.result import Comparison, Result
from rodless_lab.figures.files import figure_contents, files_of_figure
from rodless_lab.reports.table import HEADINGS, cells, markdown_table, verdict

TITLE = "The paper's experiments, reproduced"
SOURCE = "Zhang et al., Actuators 2022, 11(2), 50"
STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-size: 14px; }
td, th { border: 1px solid #ccc; padding: 0.2rem 0.5rem; text-align: left; vertical-align: top; }
td:nth-child(2) { white-space: nowrap; }
tr.leaves { background: #fdd; }
img { max-width: 100%; }
figure { margin: 1rem 0; }
"""


class Performed(NamedTuple):
    """An experiment and what it gave."""

    experiment: Experiment
    result: Result


def write_report(folder: Path, performed: Sequence[Performed]) -> tuple[Path, Path]:
    """Write ``report.html``, ``summary.md`` and the pictures into ``folder``; return the two.

    Each picture is a PNG and a PDF for print, with what it shows as CSV. Where something cannot be
    written, which raises OSError, an earlier report stays as it is.
    """
    contents: dict[Path, str | bytes] = {}
    pictures: dict[str, bytes] = {}
    for shown in (picture for _, result in performed for picture in result.pictures):
        files = figure_contents(folder, shown.name, shown.draw)
        pictures[shown.name] = files[files_of_figure(folder, shown.name)[0]]
        contents |= files
    report, summary = report_files(folder)
    contents[report] = html_report(performed, pictures)
    contents[summary] = markdown_summary(performed)
    write_together(contents)
    return report, summary


def report_files(folder: Path) -> tuple[Path, Path]:
    """Return where the report and its summary go."""
    return folder / "report.html", folder / "summary.md"


def markdown_summary(performed: Sequence[Performed]) -> str:
    """Return all tables and pictures in Markdown."""
    parts = [f"# {TITLE}", f"{SOURCE}."]
    for experiment, result in performed:
        parts += [f"## {experiment.title}", f"{experiment.source}: {verdict(result.comparisons)}"]
        parts.append(markdown_table(result.comparisons))
        parts += [f"![{shown.caption}]({shown.name}.png)" for shown in result.pictures]
        parts.append("\n".join(f"- {remark}" for remark in result.remarks))
    return "\n\n".join(parts) + "\n"


def html_report(performed: Sequence[Performed], pictures: dict[str, bytes]) -> str:
    """Return one HTML file with ``pictures`` (PNG by name) inside."""
    contents = "".join(
        f'<li><a href="#{experiment.name}">{escape(experiment.title)}</a>: '
        f"{escape(verdict(result.comparisons))}</li>"
        for experiment, result in performed
    )
    sections = "".join(section(one, pictures) for one in performed)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(TITLE)}</title>'
        f"<style>{STYLE}</style></head><body><h1>{escape(TITLE)}</h1><p>{escape(SOURCE)}.</p>"
        f"<ul>{contents}</ul>{sections}</body></html>\n"
    )


def section(performed: Performed, pictures: dict[str, bytes]) -> str:
    """Return the part of one experiment."""
    experiment, result = performed
    figures = "".join(
        f'<figure><img alt="{escape(shown.caption)}" src="data:image/png;base64,'
        f'{base64.b64encode(pictures[shown.name]).decode()}"><figcaption>{escape(shown.caption)}'
        "</figcaption></figure>"
        for shown in result.pictures
    )
    remarks = "".join(f"<li>{html_text(remark)}</li>" for remark in result.remarks)
    return (
        f'<h2 id="{experiment.name}">{escape(experiment.title)}</h2>'
        f"<p>{escape(experiment.source)}. {escape(experiment.summary)}</p>{figures}"
        f"{html_table(result.comparisons)}<ul>{remarks}</ul>"
    )


def html_text(text: str) -> str:
    """Return Markdown text of ours as HTML: code is all the markup it has."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def html_table(rows: Sequence[Comparison]) -> str:
    """Return the table of comparisons; rows that leave their limits stand out."""
    head = "".join(f"<th>{heading}</th>" for heading in HEADINGS)
    body = "".join(
        f"<tr{'' if row.holds else ' class=leaves'}>"
        + "".join(f"<td>{escape(cell)}</td>" for cell in cells(row))
        + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
