# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The page of a sweep: its table, sensitivities where the design has them, and pictures."""

from pathlib import Path

from rodless_base.atomic_write import write_together
from rodless_lab.figures.files import figure_contents, files_of_figure
from rodless_lab.studies.pictures import draw_rows, draw_sensitivities
from rodless_lab.studies.results import read_results
from rodless_lab.studies.sensitivity import SALTELLI
from rodless_lab.studies.study import Study
from rodless_lab.studies.summary import sensitivities, sensitivity_table, summary

SUMMARY = "summary.md"
ROWS = "rows"  # the name of a folder too, which has no ending
SENSITIVITY = "sensitivity"

# A picture with its table of all rows of a large sweep would fill memory and page.
MOST_DRAWN = 10_000


def report_files(folder: Path) -> list[Path]:
    """Return where the page of a sweep and its pictures may go."""
    pictures = (files_of_figure(folder, name) for name in (ROWS, SENSITIVITY))
    return [folder / SUMMARY, *(file for files in pictures for file in files)]


def write_report(folder: Path, study: Study) -> str:
    """Write ``summary.md`` and the pictures into the folder of a sweep; return the text.

    Raises OSError where the folder cannot be written.
    """
    results = read_results(folder, study, traces=False)
    text = summary(results)
    contents: dict[Path, str | bytes] = {}
    drawn = results.some(MOST_DRAWN)
    contents |= figure_contents(folder, ROWS, lambda: draw_rows(drawn))
    of_all = "" if drawn is results else f": {MOST_DRAWN} of the {len(results)} rows, at random"
    pictures = f"![Figures over each axis{of_all}](rows.png)\n"
    if study.method == SALTELLI and (found := sensitivities(results, study.seed)):
        text += f"\nTotal Sobol indices:\n\n{sensitivity_table(results, found)}"
        contents |= figure_contents(
            folder, SENSITIVITY, lambda: draw_sensitivities(results.axes, found)
        )
        pictures += "\n![Sobol indices](sensitivity.png)\n"
    contents[folder / SUMMARY] = f"# {study.name}\n\n{text}\n{pictures}"
    write_together(contents)
    return text
